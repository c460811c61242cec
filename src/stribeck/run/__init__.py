"""A run: one recording, measured or simulated, and its CSV and Parquet files."""

from stribeck.run.file import load_run, save_columns, save_run
from stribeck.run.values import Run

__all__ = ["Run", "load_run", "save_columns", "save_run"]
