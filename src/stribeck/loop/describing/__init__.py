"""Approximate cycles: describing functions in closed form, and harmonic balance with one harmonic or many."""

from stribeck.loop.describing.frequency import LinearPart, linear_part
from stribeck.loop.describing.harmonics import Harmonics, harmonic_balance
from stribeck.loop.describing.residual import CompensatedResidual, Compensator
from stribeck.loop.describing.roots import Root, balance, find_roots
from stribeck.loop.describing.tustin import TustinFriction, describing_function, symmetric

__all__ = [
    "CompensatedResidual", "Compensator", "Harmonics", "LinearPart", "Root", "TustinFriction", "balance",
    "describing_function", "find_roots", "harmonic_balance", "linear_part", "symmetric",
]  # fmt: skip
