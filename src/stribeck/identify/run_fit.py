"""Tustin's constants from whole recordings, steady or not: the maximum a posteriori fit with IPOPT.

Inertial values are fitted along, within the tolerances that the arm file states. Friction starts from the recordings
themselves and not from the arm file, whose constants may be anyone's guess.

What the filters blur counts less (:mod:`.blur`), and noise in the acceleration is no reason for less inertia
(:mod:`.added`). Near a reversal noise hides the sign of the velocity, and least squares bend friction more steeply
there: intervals reach to where it would be without (:mod:`.noise_pull`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from stribeck.arm import Arm, Friction, Tolerance
from stribeck.identify.added import Added
from stribeck.identify.blocks import BLOCK, block_of_rows, correlation_rows, over_neighbours
from stribeck.identify.blur import blur
from stribeck.identify.conditioning import Conditioned
from stribeck.identify.confidence import Intervals, intervals
from stribeck.identify.fitted import arm_with
from stribeck.identify.map_fit import Fit, fit
from stribeck.identify.noise_pull import louder, noise_pull
from stribeck.identify.problem import Weights
from stribeck.identify.residual import Residual
from stribeck.model.layout import FRICTION, values_of
from stribeck.simulate.engine import path_of

Floats = NDArray[np.float64]

FRICTION_TOLERANCE = 2.0  # relative, of the constants read off the recordings, as a prior; three times that is reached
ALPHAS = np.geomspace(0.003, 0.3, 25)  # of the fastest velocity, tried for the start
EVALUATIONS = 250  # a decay that the recordings hardly show takes many
MANY_RUNS = 12  # from so many on each run is a block of its own
LEAST_SD = 1e-9  # N m
NEIGHBOURS = 7  # rows, over which what is blurred is averaged
LEAST = {"C0": 0.3, "C1": 0.1, "C2": 0.1}  # of the friction there is: a start at zero would have no tolerance at all


@dataclass(frozen=True)
class RunFit:
    """A fit to whole recordings: ``arm`` with its values, the ``fit``, ``intervals``, residual ``rms`` (n,) in N m."""

    arm: Arm
    fit: Fit
    intervals: Intervals
    rms: Floats


def fit_runs(arm: Arm, runs: Sequence[Conditioned], moved: Sequence[tuple[bool, bool]], cutoff: float) -> RunFit:
    """Fit an arm's friction, and within tolerance its inertial values, to recordings.

    Parameters
    ----------
    arm : Arm
        Effects of its file are kept as they are.
    runs : sequence of Conditioned
    moved : sequence of (bool, bool)
        Whether each joint was recorded moving forward, and backward; both gives constants for each direction.
    cutoff : float
        Analysis cutoff of the runs, Hz.
    """
    start = _started(arm, runs, moved)
    path = path_of(start)
    free = [i for i, entry in enumerate(path.entries) if entry.sd > 0.0 and isinstance(entry.owner, str)]
    residual = Residual(path, runs, free)
    known, weights = _settled(residual, values_of(path.entries), cutoff)
    # friction that differs from trial to trial does not average out within one: whole runs are the blocks, where many
    block = block_of_rows(runs, np.inf if len(runs) >= MANY_RUNS else BLOCK)
    friction = np.array([known.entries[i].owner == "friction" for i in known.free])  # of the rest it is taken off
    found = intervals(known, weights, block, pull=friction * noise_pull(known, weights, residual, cutoff))
    return RunFit(arm_with(start, known), known, found, np.asarray(np.sqrt(np.mean(known.residual**2, axis=0))))


def _settled(residual: Residual, p: Floats, cutoff: float) -> tuple[Fit, Weights]:
    """Return the fit from values (p,) on, and its weights; a round that fails leaves what the one before found."""
    weights = _weights(residual, p, cutoff)
    known = fit(residual, weights, p, evaluations=EVALUATIONS)
    for last in (False, True):
        newer = _weights(residual, known.p, cutoff)
        noise = Added(residual, known.p, louder(residual, cutoff)) if last else None
        found = fit(residual, newer, known.p, added=noise, evaluations=EVALUATIONS)
        if found.ok:
            known, weights = found, newer
    return known, weights


def _weights(residual: Residual, p: Floats, cutoff: float) -> Weights:
    """Return weights from what values (p,) leave, and what filters blur of it."""
    plain = Residual(residual.path, residual.runs, ())
    rest = plain.value(p)
    blurred = over_neighbours(blur(plain, p, cutoff) ** 2, residual.runs, NEIGHBOURS)
    sd = np.sqrt(np.mean(rest**2, axis=0) + blurred + LEAST_SD**2)
    return Weights(sd, correlation_rows(rest / sd, residual.runs))


def _started(arm: Arm, runs: Sequence[Conditioned], moved: Sequence[tuple[bool, bool]]) -> Arm:
    """Return the arm with friction as the moving samples of the recordings roughly have it."""
    path = path_of(arm)
    p = values_of(path.entries)
    residual = Residual(path, runs, ())
    stages = [residual.stages(run, p) for run in runs]
    joints = []
    for j, joint in enumerate(arm.joints):
        friction = np.concatenate([(s["actuator"] - s["rotor"] - s["load"])[:, j] for s in stages])
        velocity = np.concatenate([run.velocity[:, j] for run in runs])
        sure = np.concatenate([np.abs(run.velocity[:, j]) > 3.0 * run.velocity_sd[:, j] for run in runs])
        rough = rough_friction(velocity[sure], friction[sure], joint.friction)
        # equal constants are one set of parameters; ever so slightly different ones are two
        other = replace(rough, C0=float(np.nextafter(rough.C0, np.inf))) if all(moved[j]) else rough
        stated = {key: sd for key, sd in joint.tolerance.items() if key not in FRICTION}  # not of a rough reading
        joints.append(replace(joint, friction=rough, backward=other, tolerance=stated))
    tolerance = Tolerance(arm.tolerance.inertial, max(arm.tolerance.friction, FRICTION_TOLERANCE))
    return replace(arm, joints=tuple(joints), tolerance=tolerance)


def rough_friction(velocity: Floats, torque: Floats, fallback: Friction) -> Friction:
    """Return constants that go about through samples of velocity and friction (S,); the fallback for too few samples.

    Non-negative least squares in C0, C1, C2 for each of some alphas.
    """
    if len(velocity) < 20:
        return fallback
    thin = slice(None, None, max(1, len(velocity) // 20_000))
    speed, level = np.abs(velocity[thin]), torque[thin] * np.sign(velocity[thin])
    best: tuple[float, Floats, float] = (np.inf, np.zeros(3), 1.0)
    for alpha in ALPHAS * float(speed.max()):
        design = np.stack([np.ones_like(speed), np.exp(-speed / alpha), speed], axis=1)
        linear, rest = nnls(design, level)
        if rest < best[0]:
            best = (float(rest), linear, float(alpha))
    C0, C1, C2 = (float(value) for value in best[1])
    size, fastest = max(float(np.median(np.abs(level))), 1e-9), float(speed.max())
    least = {name: share * size for name, share in LEAST.items()}
    return Friction(max(C0, least["C0"]), max(C1, least["C1"]), max(C2, least["C2"] / fastest), best[2])
