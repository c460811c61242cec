"""All of Section 3 for one joint and one direction, with condition (2) checked and every pitfall said."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stribeck.arm import unit_at
from stribeck.identify.section3.readings import Readings, average
from stribeck.identify.section3.saddle import Saddle, alpha_at, alphas_by_velocity, amplification, lowest_reading
from stribeck.identify.section3.viscous import Line, viscous_line

Floats = NDArray[np.float64]
Constants = tuple[float, float, float, float]

LARGE = 3.0  # a velocity this many times that of the saddle is "relatively large": the decay is over by then


@dataclass(frozen=True)
class Section3:
    """What the procedure gave, and how far it can be believed.

    Attributes
    ----------
    constants : tuple of 4 floats
        C0, C1 (N m), C2 (N m s/rad), alpha (rad/s); not a number where a step could not be made.
    line, saddle : Line, Saddle or None
        Of steps 3.1 and 3.3.
    break_away : float or None
        Mean reading, N m (step 3.2).
    condition : float
        C2 alpha / C1, which condition (2) wants between 0 and 1.
    alphas_by_velocity : tuple of float
        What equation (3) would give in place of (12), rad/s.
    amplification : float
        Relative error of alpha for a relative error of the torque at the saddle.
    remarks : tuple of str
        Each step that failed or cannot be trusted, in words.
    """

    constants: Constants
    line: Line | None
    saddle: Saddle | None
    break_away: float | None
    condition: float
    alphas_by_velocity: tuple[float, ...]
    amplification: float
    remarks: tuple[str, ...]

    @property
    def ok(self) -> bool:
        """Whether all four constants were found and make a Tustin curve with a bend."""
        found = all(math.isfinite(value) for value in self.constants)
        return found and min(self.constants) > 0.0 and 0.0 < self.condition < 1.0


def section3(speed: Floats, torque: Floats, kind: str = "revolute") -> Section3:
    """Follow Section 3 for one direction of one joint.

    Parameters
    ----------
    speed, torque : array (P,)
        Of every trial, rad/s and N m, both positive; a speed of 0 is a break-away reading.
    kind : str
        Of the joint, whose units the remarks have.
    """
    readings = average(np.asarray(speed, dtype=float), np.asarray(torque, dtype=float))
    line, saddle = viscous_line(readings), lowest_reading(readings)
    C0, C2 = (line.C0, line.C2) if line else (math.nan, math.nan)
    C1 = math.nan if readings.break_away is None else readings.break_away - C0  # equation (9)
    apart = saddle is not None and line is not None and saddle.velocity not in (line.first, line.second)
    alpha = alpha_at(saddle, C0, C2) if saddle and apart else math.nan
    constants = C0, C1, C2, alpha
    return Section3(
        constants=constants,
        line=line,
        saddle=saddle,
        break_away=readings.break_away,
        condition=_condition(constants),
        alphas_by_velocity=alphas_by_velocity(saddle.velocity, C1, C2) if saddle else (),
        amplification=amplification(saddle, C2, alpha) if saddle and apart else math.inf,
        remarks=tuple(_remarks(readings, line, saddle, constants, kind)),
    )


def _condition(constants: Constants) -> float:
    _, C1, C2, alpha = constants
    return C2 * alpha / C1 if C1 else math.nan


def _remarks(
    readings: Readings, line: Line | None, saddle: Saddle | None, constants: Constants, kind: str
) -> list[str]:
    C0, C1, C2, alpha = constants
    torque, speed, viscous = (unit_at(unit, kind) for unit in ("N m", "rad/s", "N m s/rad"))
    condition = _condition(constants)
    said = []
    if line is None:
        said.append(f"3.1 needs readings at two velocities; there are {len(readings.speed)}")
    elif C2 <= 0.0:
        said.append(f"3.1: C2 = {C2:.3g} {viscous} by equation (8); the torque does not rise with velocity")
    elif C0 <= 0.0:
        said.append(f"3.1: C0 = {C0:.3g} {torque} by equation (7)")
    if readings.break_away is None:
        said.append("3.2 needs a break-away reading; there is none")
    elif C1 <= 0.0:
        said.append(f"3.2: C1 = {C1:.3g} {torque} by equation (9); break-away lies below the line of 3.1")
    if saddle and not saddle.bent:
        said.append(f"3.3: the least torque is at the slowest velocity, {saddle.velocity:.3g} {speed}; no bend is seen")
    if line and saddle and min(line.first, line.second) < LARGE * saddle.velocity:
        said.append(f"3.1: the velocities are not large against the saddle's, {saddle.velocity:.3g} {speed}")
    if saddle and line and saddle.velocity in (line.first, line.second):
        said.append(f"3.3: the line of 3.1 passes through the least torque, at {saddle.velocity:.3g} {speed}: no alpha")
    elif math.isfinite(alpha) and alpha <= 0.0:
        said.append(f"3.3: alpha = {alpha:.3g} {speed} by equation (12); the saddle lies below the line of 3.1")
    elif saddle and math.isfinite(alpha) and C2 > 0.0:
        factor = amplification(saddle, C2, alpha)
        said.append(f"3.3: one per cent of torque at the saddle is {factor:.3g} per cent of alpha")
    if math.isfinite(condition) and not 0.0 < condition < 1.0:
        said.append(f"condition (2) does not hold: C2 alpha / C1 = {condition:.3g}")
    return said
