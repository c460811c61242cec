"""What every method of the side-by-side comparison answers to a case."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from stribeck.arm import Arm

CONSTANTS = ("C0", "C2")  # Coulomb and viscous friction: in every method's model


@dataclass(frozen=True)
class Answer:
    """One method's answer.

    ``named`` are (effect, joint), the likeliest first; ``confidence`` in the first one, or in none, 0 to 1 where the
    method states it; ``friction`` rows of joint, constant, value and ends of the 95 % interval (None where it has
    none); ``says`` its own words, ``ended`` those on how the fit ended; ``alike`` are the names that it states as
    alternatives to the first one.
    """

    named: tuple[tuple[str, str], ...]
    confidence: float | None
    friction: tuple[dict[str, Any], ...]
    says: str
    ended: str = ""
    alike: tuple[str, ...] = ()


def friction_intervals(arm: Arm, rows: Sequence[tuple[float, float | None]]) -> tuple[dict[str, Any], ...]:
    """Return rows of friction from (value, half width), joint by joint in the order of CONSTANTS."""
    halves = [math.nan if half is None else half for _, half in rows]
    return friction_ends(arm, [(value, value - h, value + h) for (value, _), h in zip(rows, halves, strict=True)])


def friction_ends(arm: Arm, rows: Sequence[tuple[float, float, float]]) -> tuple[dict[str, Any], ...]:
    """Return rows of friction from (value, low, high), joint by joint in the order of CONSTANTS."""
    keys = [(joint, constant) for joint in arm.names for constant in CONSTANTS]
    return tuple(
        {"joint": joint, "constant": constant, "value": float(value), "low": _finite(low), "high": _finite(high)}
        for (joint, constant), (value, low, high) in zip(keys, rows, strict=True)
    )


def _finite(end: float) -> float | None:
    return float(end) if math.isfinite(end) else None
