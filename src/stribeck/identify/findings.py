"""What an identification found, as values: one joint's directions, the joints, and the arm that follows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stribeck.arm import Arm
from stribeck.identify.asymmetry import CLEAR
from stribeck.identify.curve import Point
from stribeck.identify.run_fit import RunFit
from stribeck.identify.section3 import Section3
from stribeck.identify.tustin_fit import CurveFit

Floats = NDArray[np.float64]

WAYS = {1: "forward", -1: "backward"}


@dataclass(frozen=True)
class Direction:
    """What the recordings say of one joint's friction in one direction.

    Attributes
    ----------
    points : tuple of Point
        The readings.
    section3 : Section3 or None
        The paper's procedure; None where no steady sliding was recorded.
    curve : CurveFit
        IPOPT on the readings.
    runs : array (3, 4)
        IPOPT on the whole recordings: values, lower and upper ends of the 95 % intervals of C0, C1, C2, alpha.
    runs_identified : array (4,) of bool
        Which of these the recordings tell to half their tolerance.
    source : str
        Where ``fitted.toml`` has its constants from: ``curve``, ``runs`` or, where the readings do not determine all
        and the recordings not even C2, ``other direction`` or ``nominal``.
    """

    points: tuple[Point, ...]
    section3: Section3 | None
    curve: CurveFit
    runs: Floats
    runs_identified: NDArray[np.bool_]
    source: str

    @property
    def sliding(self) -> int:
        """Number of trials of steady sliding."""
        return sum(point.speed > 0.0 for point in self.points)


@dataclass(frozen=True)
class JointFriction:
    """One joint: what was found for each direction it moved in (``forward``, ``backward``), and what is taken.

    Attributes
    ----------
    name : str
        Of the joint.
    directions : dict of str to Direction
        Those in which it moved.
    common : CurveFit or None
        The curve fitted to both directions' readings; None where only one has a curve.
    asymmetry : float or None
        Probability that equal directions differ as much as these; None where it cannot be told.
    """

    name: str
    directions: dict[str, Direction]
    common: CurveFit | None
    asymmetry: float | None

    @property
    def asymmetric(self) -> bool:
        """Whether the directions clearly differ."""
        return self.asymmetry is not None and self.asymmetry < CLEAR


@dataclass(frozen=True)
class Identification:
    """The result: the nominal and the fitted ``arm``, one entry a joint, the fit to whole runs, and what to mind."""

    nominal: Arm
    arm: Arm
    joints: tuple[JointFriction, ...]
    whole: RunFit
    runs: tuple[str, ...]
    notes: tuple[str, ...]
    warnings: tuple[str, ...]
