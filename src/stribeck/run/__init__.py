"""A run: one recording, measured or simulated, and its CSV and Parquet files."""

from stribeck.run.file import load_run, save_columns, save_run
from stribeck.run.several import check_apart, load_runs
from stribeck.run.values import Run

__all__ = ["Run", "check_apart", "load_run", "load_runs", "save_columns", "save_run"]
