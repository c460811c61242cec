"""The paper's Section 3, step by step: Tustin's four constants from a few readings, by hand."""

from stribeck.identify.section3.procedure import Section3, section3

__all__ = ["Section3", "section3"]
