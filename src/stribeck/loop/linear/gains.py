"""The closed loop's poles against Kp, and the largest Kp."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import bisect

from stribeck.loop.linear.assemble import Assembly
from stribeck.loop.linear.margins import frequencies, sensitivity_peak

MS_LIMIT = 2.0  # Åström & Hägglund: 1.2 to 2.0 is a robust loop
LOWEST, HIGHEST, PER_DECADE = 1e-4, 1e10, 8  # of the gains that are searched, relative to the inertia, 1/s^2


MOST_STATES = 400  # of a loop whose poles are still sought gain by gain

NO_LIMIT = "no gain is too high for this linear model"
NONE_HOLDS = "no gain makes this loop stable"
TOO_LATE = "the delay is too many samples long for the poles to be followed"


@dataclass(frozen=True)
class KpMax:
    """The largest Kp, N m/rad: for stability, and for Ms <= 2.

    None is no value; ``why`` then says whether no gain is too high, none is low enough, or they were not sought.
    """

    stability: float | None
    ms2: float | None
    why: str = ""


def kp_max(assembly: Assembly, joint: str, ms_limit: float = MS_LIMIT) -> KpMax:
    """Return the largest Kp of a joint below which every smaller one, down to the lowest that holds, does as well.

    Parameters
    ----------
    assembly : Assembly
        Every other joint keeps its gains. A ``kv`` that the loop leaves open stays critical, 2 sqrt(Kp J); a number
        stays that number.
    joint : str
    ms_limit : float
        Largest sensitivity peak that ``ms2`` allows.
    """
    if assembly.plant.nstates > MOST_STATES:
        return KpMax(None, None, TOO_LATE)
    inertia = float(assembly.inertia[assembly.index(joint)])
    count = int(PER_DECADE * np.log10(HIGHEST / LOWEST)) + 1
    grid = inertia * np.geomspace(LOWEST, HIGHEST, count)

    def robust(kp: float) -> bool:
        if not assembly.is_stable(joint, kp):
            return False
        return sensitivity_peak(assembly.broken(joint, kp), frequencies(assembly, joint, kp)) <= ms_limit

    stability, why = _upper_end(lambda kp: assembly.is_stable(joint, kp), grid)
    if why == NONE_HOLDS:
        return KpMax(None, None, why)
    ms2, robust_why = _upper_end(robust, grid if stability is None else grid[grid < 1.2 * stability])
    return KpMax(stability, ms2, why or (f"no gain keeps Ms under {ms_limit:g}" if robust_why == NONE_HOLDS else ""))


def root_locus(
    assembly: Assembly, joint: str, gains: Sequence[float] | NDArray[np.float64]
) -> list[NDArray[np.complex128]]:
    """Return the poles of the closed loop for each Kp of a joint, 1/s for a continuous loop, z for a sampled one.

    Unlike `control.root_locus` it lets kv follow Kp where the loop asks for critical damping.
    """
    return [assembly.poles(joint, kp) for kp in gains]


def _upper_end(holds: Callable[[float], bool], grid: NDArray[np.float64]) -> tuple[float | None, str]:
    """Return the upper end of the first stretch of gains that holds, and why there is none."""
    first = next((k for k, kp in enumerate(grid) if holds(kp)), None)
    if first is None:
        return None, NONE_HOLDS
    last = next((k for k in range(first, len(grid)) if not holds(grid[k])), None)
    if last is None:
        return None, NO_LIMIT
    sign = {True: 1.0, False: -1.0}
    end = bisect(lambda x: sign[holds(np.exp(x))], np.log(grid[last - 1]), np.log(grid[last]), xtol=1e-9)
    return float(np.exp(end)), ""
