"""Section 3.1: C0 and C2 from two large velocities, equations (7) and (8)."""

from __future__ import annotations

from dataclasses import dataclass

from stribeck.identify.section3.readings import Readings

HALF = 0.5  # the second velocity is the one nearest to this share of the largest


@dataclass(frozen=True)
class Line:
    """The straight part of the curve: ``C0`` (N m), ``C2`` (N m s/rad), and the velocities (rad/s) that gave it."""

    C0: float
    C2: float
    first: float
    second: float


def viscous_line(readings: Readings) -> Line | None:
    """Return the line through the readings at two large velocities; None where there are not two.

    Steps 1 to 3 of Section 3.1 take any two. Here they are the largest, and the one nearest to half of it: close
    together they would share the noise out on a short base, far apart the slower one would lie in the bend.

    Notes
    -----
    C2 = (tau_1 - tau_2) / (|dq_1| - |dq_2|) (8), and C0 = tau_1 - C2 |dq_1| (7).
    """
    if len(readings.speed) < 2:
        return None
    top = len(readings.speed) - 1
    other = min(range(top), key=lambda i: abs(readings.speed[i] - HALF * readings.speed[top]))
    slope = (readings.torque[top] - readings.torque[other]) / (readings.speed[top] - readings.speed[other])
    offset = readings.torque[top] - slope * readings.speed[top]
    return Line(float(offset), float(slope), float(readings.speed[top]), float(readings.speed[other]))
