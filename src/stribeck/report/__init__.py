"""Pages, figures and terminal summaries: the only place that draws. Nothing is computed here that a result lacks."""

from stribeck.report.diagnosis import write_report
from stribeck.report.summary import summary

__all__ = ["summary", "write_report"]
