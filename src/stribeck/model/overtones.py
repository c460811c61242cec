"""A wave over position together with its first overtone, as laws of periodic effects share it."""

from __future__ import annotations

import math
from collections.abc import Mapping

import casadi as ca

from stribeck.model.values import Expression, Parameters


def two_waves(phase: Expression, p: Parameters) -> Expression:
    """Return the sum of both waves at a phase (rad) of the slower one."""
    slow = p["sine"] * ca.sin(phase) + p["cosine"] * ca.cos(phase)
    return slow + p["second_sine"] * ca.sin(2.0 * phase) + p["second_cosine"] * ca.cos(2.0 * phase)


def slower_wave(sine: float, cosine: float, harmonic: float) -> dict[str, float]:
    """Return values from which a fit starts: a single wave, taken for the slower of the two."""
    return {"sine": sine, "cosine": cosine, "second_sine": 0.0, "second_cosine": 0.0, "harmonic": harmonic}


def faster_wave(sine: float, cosine: float, harmonic: float) -> dict[str, float]:
    """Return the same with the wave taken for the faster one."""
    return {"sine": 0.0, "cosine": 0.0, "second_sine": sine, "second_cosine": cosine, "harmonic": harmonic / 2.0}


def size_of(values: Mapping[str, float]) -> float:
    """Return the amplitude of all waves of a law together, in whatever unit their sines and cosines are."""
    return math.hypot(*(value for name, value in values.items() if name != "harmonic"))
