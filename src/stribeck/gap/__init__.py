"""The sim-to-real gap: where it lies, which effect causes it, and how far it shrinks."""

from stribeck.gap.diagnose import diagnose
from stribeck.gap.result import Diagnosis

__all__ = ["Diagnosis", "diagnose"]
