"""Thousands of simulations of one FMU: parameter studies and Monte Carlo runs at the speed of C."""

from stribeck.export.batch.batch import Batch, simulate_batch

__all__ = ["Batch", "simulate_batch"]
