"""Identification of an arm's friction: the paper's Section 3 and two IPOPT fits, side by side on the same data."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from stribeck.arm import Arm, Friction, Joint
from stribeck.errors import InputError
from stribeck.grid import uniform
from stribeck.identify.conditioning import Conditioned, condition, cutoff_frequency
from stribeck.identify.curve import Point, read_points
from stribeck.identify.run_fit import RunFit, fit_runs
from stribeck.identify.section3 import Section3, section3
from stribeck.identify.stretches import shortened
from stribeck.identify.tustin_fit import NAMES, CurveFit, fit_curve
from stribeck.model.layout import values_of
from stribeck.run import Run
from stribeck.simulate.engine import Engine, path_of

Floats = NDArray[np.float64]

LEAST_SAMPLES = 50  # of a recording: fewer do not fill the filters
SURE = 3.0  # deviations of velocity beyond which a joint moves
FAR = 200.0  # deviations of position that it must cover in one go, for friction in that direction to be asked for
CLEAR = 0.01  # probability under which directions that differ so much by chance are taken to differ
UNEXPLAINED = 0.1  # share of the break-away torque that the fit to whole runs may leave unremarked
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
        Which of these the recordings determine.
    source : str
        Where ``fitted.toml`` has its constants from: ``curve``, ``runs`` or, where neither is determined,
        ``other direction`` or ``nominal``.
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


def identify(arm: Arm, runs: Sequence[Run], progress: Callable[[str], None] = lambda text: None) -> Identification:
    """Identify the friction of an arm's joints from recordings.

    Parameters
    ----------
    arm : Arm
        Its rigid body is used, and re-tuned within its tolerances; its friction constants are not.
    runs : sequence of Run
    progress : callable
        Told what is being done.

    Raises
    ------
    InputError
        When a recording has too few samples.
    """
    notes: list[str] = []
    even = _even(runs, notes)
    engine = Engine(path_of(arm))
    inertia = engine.moved_inertia(np.median(np.concatenate([run.q for run in even]), axis=0))
    cutoff = cutoff_frequency(arm, even, inertia)
    notes.append(f"analysed up to {cutoff:.3g} Hz")
    progress("fitting whole recordings")
    thin = [condition(arm, run, cutoff, thin=True) for run in shortened(even, notes)]
    moved = _moved(thin, arm.n)
    whole = fit_runs(arm, thin, moved)
    progress("reading the friction curve")
    body = path_of(whole.arm if whole.fit.ok else arm)
    points = read_points(body, values_of(body.entries), [condition(arm, run, cutoff) for run in even])
    joints = tuple(_joint(arm, j, moved[j], points, whole) for j in range(arm.n))
    warnings = [f"{run.name}: {text}" for run in even for text in run.warnings] + _warnings(joints, whole)
    names = tuple(run.name for run in runs)
    return Identification(arm, _taken(arm, joints, whole), joints, whole, names, tuple(notes), tuple(warnings))


def _even(runs: Sequence[Run], notes: list[str]) -> list[Run]:
    out = []
    for run in runs:
        even, said = uniform(run)
        notes.extend(said)
        if len(even.t) < LEAST_SAMPLES:
            what = f"{run.name}: too short to identify from"
            raise InputError(what, f"{len(even.t)} samples", f"record at least {LEAST_SAMPLES}")
        out.append(even)
    return out


def _moved(runs: Sequence[Conditioned], n: int) -> list[tuple[bool, bool]]:
    """Return whether each joint moved forward and backward: a stretch at a sure velocity that left the noise behind."""

    def travel(run: Conditioned, j: int, way: int) -> float:
        sure = way * run.velocity[:, j] > SURE * run.velocity_sd[j]
        edges = np.flatnonzero(np.diff(np.concatenate([[0], sure.astype(int), [0]])))
        spans = [run.position[last - 1, j] - run.position[first, j] for first, last in edges.reshape(-1, 2)]
        return max((way * span for span in spans), default=0.0) / float(run.noise[j])

    return [tuple(any(travel(run, j, way) > FAR for run in runs) for way in (1, -1)) for j in range(n)]  # type: ignore[misc]


def _joint(arm: Arm, j: int, moved: tuple[bool, bool], points: Sequence[Point], whole: RunFit) -> JointFriction:
    directions = {}
    for way, flag in zip((1, -1), moved, strict=True):
        if flag:
            own = tuple(point for point in points if point.joint == j and point.direction == way)
            directions[WAYS[way]] = _direction(own, *_of_runs(arm.names[j], way, all(moved), whole), whole.fit.ok)
    sources = {one.source for one in directions.values()}
    if "none" in sources:
        other = "nominal" if sources == {"none"} else "other direction"
        directions = {
            way: replace(one, source=other) if one.source == "none" else one for way, one in directions.items()
        }
    curves = [one for one in directions.values() if one.source == "curve"]
    common, chance = _compare(curves) if len(curves) == 2 else (None, None)
    return JointFriction(arm.names[j], directions, common, chance)


def _direction(points: tuple[Point, ...], runs: Floats, identified: NDArray[np.bool_], ok: bool) -> Direction:
    speed, torque = (np.array([getattr(point, key) for point in points]) for key in ("speed", "torque"))
    by_hand = section3(speed, torque) if (speed > 0.0).any() else None
    curve = fit_curve(speed, torque)
    by_curve = curve.ok and bool(curve.identified.all())
    source = "curve" if by_curve else "runs" if ok and bool(identified[[0, 2]].all()) else "none"
    return Direction(points, by_hand, curve, runs, identified, source)


def _of_runs(name: str, way: int, both: bool, whole: RunFit) -> tuple[Floats, NDArray[np.bool_]]:
    side = "backward" if both and way < 0 else "friction"
    keys = [entry.key for entry in whole.fit.entries]
    index = [keys.index(f"{name}.{side}.{key}") for key in NAMES]
    low = np.maximum(whole.intervals.low[index], 0.0)  # no constant lies below
    values = np.stack([whole.fit.p[index], low, whole.intervals.high[index]])
    return values, whole.intervals.identified[index]


def _compare(directions: Sequence[Direction]) -> tuple[CurveFit, float]:
    """Fit both directions as one; return that, and the probability of a loss as large by chance."""
    apart = [
        (np.array([point.speed for point in one.points]), np.array([point.torque for point in one.points]))
        for one in directions
    ]
    speed, torque = (np.concatenate(parts) for parts in zip(*apart, strict=True))
    return fit_curve(speed, torque), compare_curves(apart)


def compare_curves(readings: Sequence[tuple[Floats, Floats]]) -> float:
    """Return the probability that equal curves differ as much as those of two sets of readings (F test).

    Parameters
    ----------
    readings : sequence of two (speed, torque)
        Absolute velocity (P,), rad/s, and friction (P,), N m, of each set.
    """
    speed, torque = (np.concatenate(parts) for parts in zip(*readings, strict=True))
    together = fit_curve(speed, torque).chi2
    apart = sum(fit_curve(*one).chi2 for one in readings)
    spare = len(speed) - 8
    if spare < 1 or not apart > 0.0:
        return math.nan
    return float(stats.f.sf(max(together - apart, 0.0) / 4.0 / (apart / spare), 4, spare))


def _taken(arm: Arm, joints: Sequence[JointFriction], whole: RunFit) -> Arm:
    """Return the fitted arm: inertial values of the whole runs, friction of each joint's source."""
    body = whole.arm if whole.fit.ok else arm
    fitted = [_with(own, nominal, one) for own, nominal, one in zip(body.joints, arm.joints, joints, strict=True)]
    return replace(body, joints=tuple(fitted), tolerance=arm.tolerance)


def _with(joint: Joint, nominal: Joint, found: JointFriction) -> Joint:
    """Return a joint of the fitted body with the friction of each direction's source."""
    if found.common is not None and found.common.ok and not found.asymmetric:
        friction = Friction(*found.common.constants.tolist())
        return replace(joint, friction=friction, backward=friction)
    own: dict[str, Friction] = {}
    for way, one in found.directions.items():
        if one.source in ("curve", "runs"):
            constants = one.curve.constants if one.source == "curve" else one.runs[0]
            own[way] = Friction(*constants.tolist())
    if not own:
        return replace(joint, friction=nominal.friction, backward=nominal.backward)
    forward = own.get("forward") or own["backward"]
    return replace(joint, friction=forward, backward=own.get("backward", forward))


def _warnings(joints: Sequence[JointFriction], whole: RunFit) -> list[str]:
    said = []
    if not whole.fit.ok:
        said.append(f"the fit to whole recordings failed ({whole.fit.status}): its values are not used")
    for joint in joints:
        if not joint.directions:
            said.append(f"{joint.name}: it never moved; its friction stays as the arm file has it")
        for way, one in joint.directions.items():
            if one.sliding == 0:
                said.append(f"{joint.name}, {way}: it never slides steadily; only the fit to whole recordings is given")
            elif not one.curve.ok:
                why = one.curve.status.replace("_", " ")
                said.append(f"{joint.name}, {way}: no curve through {one.curve.points} readings ({why})")
            elif not one.curve.identified.all():
                open_ended = [name for name, sure in zip(NAMES, one.curve.identified, strict=True) if not sure]
                said.append(f"{joint.name}, {way}: the readings do not determine {', '.join(open_ended)}")
            if one.source == "runs" and not one.runs_identified.all():
                unsure = [name for name, sure in zip(NAMES, one.runs_identified, strict=True) if not sure]
                said.append(f"{joint.name}, {way}: the recordings do not determine {', '.join(unsure)}")
    for joint, own, rms in zip(joints, whole.arm.joints, whole.rms, strict=True):
        share = float(rms) / max(own.friction.C0 + own.friction.C1, 1e-12)
        if joint.directions and share > UNEXPLAINED:
            what = f"{joint.name}: friction and rigid body leave {rms:.3g} rms, {share:.0%} of its break-away torque"
            said.append(f"{what}, unexplained; try stribeck diagnose")
    said += [f"{key}: the recordings want more than three tolerances" for key in whole.fit.at_limit]
    return said
