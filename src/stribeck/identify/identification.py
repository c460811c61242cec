"""Identification of an arm's friction: the paper's Section 3 and two IPOPT fits, side by side on the same data."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stribeck.arm import Arm, doubtful_values
from stribeck.effects.undriven import undriven
from stribeck.errors import InputError
from stribeck.grid import uniform
from stribeck.identify.asymmetry import common_curve, compare_curves
from stribeck.identify.beyond import Beyond
from stribeck.identify.commanded import doubtful_commands, doubtful_torques
from stribeck.identify.conditioning import Conditioned, condition
from stribeck.identify.curve import Point, read_points
from stribeck.identify.cutoff import cutoff_frequency
from stribeck.identify.doubts import left_open
from stribeck.identify.findings import WAYS, Direction, Identification, JointFriction
from stribeck.identify.noise import doubtful_resolutions, encoder_noise, noise_of_run
from stribeck.identify.residual import Residual
from stribeck.identify.run_fit import RunFit, fit_runs
from stribeck.identify.section3 import section3
from stribeck.identify.stretches import between_gaps, shortened
from stribeck.identify.taken import taken_arm
from stribeck.identify.tustin_fit import NAMES, fit_curve
from stribeck.model.layout import values_of
from stribeck.run import Run, check_apart
from stribeck.run.checks import FEWEST_ROWS
from stribeck.run.turns import in_one_turn
from stribeck.simulate.engine import Engine, path_of

Floats = NDArray[np.float64]

LEAST_SAMPLES = 50  # of a recording
SURE = 3.0  # deviations of velocity beyond which a joint moves
FAR = 200.0  # deviations of position that it must cover in one go, for friction in that direction to be asked for


def identify_friction(
    arm: Arm, runs: Sequence[Run], progress: Callable[[str], None] = lambda text: None
) -> Identification:
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
        When a recording has too few samples, or is there twice, or has the name of another, or all are too short for
        the filters between their gaps.
    """
    check_apart(runs)
    notes: list[str] = []
    stated = arm.effects
    arm, driven = undriven(arm)  # no file says at what phase a run meets a disturbance
    even = between_gaps(_even(runs, notes), notes)
    for run in even:
        if len(run.t) < FEWEST_ROWS:
            found = f"{len(run.t)} samples between missing ones"
            raise InputError(f"{run.name}: too short to identify from", found, "leave it out, or lose fewer rows")
    engine = Engine(path_of(arm))
    inertia = engine.moved_inertia(np.median(np.concatenate([run.q for run in even]), axis=0))
    noise = encoder_noise(arm, even, runs)
    cutoff = cutoff_frequency(arm, even, inertia, noise)
    notes.append(f"analysed up to {cutoff:.3g} Hz")
    progress("fitting whole recordings")
    thin = [condition(arm, run, cutoff, noise_of_run(arm, run, noise), thin=True) for run in shortened(even, notes)]
    _check_filtered(thin, cutoff)
    moved = _moved(thin, arm.n)
    whole = fit_runs(arm, thin, moved, cutoff)
    progress("reading the friction curve")
    body = path_of(whole.arm if whole.fit.ok else arm)
    p, full = values_of(body.entries), [condition(arm, run, cutoff, noise_of_run(arm, run, noise)) for run in even]
    points = read_points(body, p, full)
    apart = Beyond(Residual(body, full, ())).apart(p, full)
    joints = tuple(_joint(arm, j, moved[j], points, whole, apart=apart[j]) for j in range(arm.n))
    doubts = dict.fromkeys(f"{run.name}: {text}" for run in even for text in run.warnings)
    warnings = [*driven, *doubtful_values(arm), *doubts]
    warnings += doubtful_resolutions(arm, even, runs)
    warnings += doubtful_torques(arm, even, noise) + doubtful_commands(engine.path, engine.p, thin)
    warnings += left_open(joints, whole)
    names = tuple(run.name for run in runs)
    nominal, taken = (replace(one, effects=stated) for one in (arm, taken_arm(arm, joints, whole)))
    return Identification(nominal, taken, joints, whole, names, tuple(notes), tuple(warnings))


def _even(runs: Sequence[Run], notes: list[str]) -> list[Run]:
    out = []
    for run in in_one_turn(runs, notes):
        even, said = uniform(run)
        notes.extend(said)
        if len(even.t) < LEAST_SAMPLES:
            what = f"{run.name}: too short to identify from"
            raise InputError(what, f"{len(even.t)} samples", f"record at least {LEAST_SAMPLES}")
        out.append(even)
    return out


def _check_filtered(runs: Sequence[Conditioned], cutoff: float) -> None:
    if any(len(run.analysis_index) for run in runs):
        return
    longest = max(runs, key=lambda run: float(np.ptp(run.time)))
    found = f"the longest stretch without a gap, of {longest.name}, takes {np.ptp(longest.time):.3g} s"
    takes = longest.sample_time * len(longest.taps)
    do = f"the filter for {cutoff:.3g} Hz takes {takes:.3g} s: record longer, or lose fewer rows"
    raise InputError("too short to identify from", found, do)


def _moved(runs: Sequence[Conditioned], n: int) -> list[tuple[bool, bool]]:
    """Return whether each joint moved forward and backward: a stretch at a sure velocity that left the noise behind."""

    def travel(run: Conditioned, j: int, way: int) -> float:
        sure = way * run.velocity[:, j] > SURE * run.velocity_sd[:, j]
        edges = np.flatnonzero(np.diff(np.concatenate([[0], sure.astype(int), [0]])))
        spans = [run.position[last - 1, j] - run.position[first, j] for first, last in edges.reshape(-1, 2)]
        return max((way * span for span in spans), default=0.0) / float(run.noise[j])

    return [tuple(any(travel(run, j, way) > FAR for run in runs) for way in (1, -1)) for j in range(n)]  # type: ignore[misc]


def _joint(
    arm: Arm, j: int, moved: tuple[bool, bool], points: Sequence[Point], whole: RunFit, *, apart: bool
) -> JointFriction:
    """Return what was found at a joint; its readings are taken where what its laws add is ``apart`` from Tustin's.

    A level that the recordings leave open is taken all the same: it bears what the fitted masses do not. Friction that
    they do not show to grow with speed is not, since it would be carried on to speeds that they do not hold.
    """
    directions = {}
    for way, flag in zip((1, -1), moved, strict=True):
        if flag:
            own = tuple(point for point in points if point.joint == j and point.direction == way)
            one = _direction(own, arm.joints[j].kind, *_of_runs(arm.names[j], way, all(moved), whole))
            by_curve = apart and one.curve.ok and bool(one.curve.identified.all())
            by_runs = whole.fit.ok and bool(one.runs_identified[NAMES.index("C2")])
            source = "curve" if by_curve else "runs" if by_runs else "none"
            directions[WAYS[way]] = replace(one, source=source)
    sources = {one.source for one in directions.values()}
    if "none" in sources:
        other = "nominal" if sources == {"none"} else "other direction"
        directions = {
            way: replace(one, source=other) if one.source == "none" else one for way, one in directions.items()
        }
    curves = [one for one in directions.values() if one.source == "curve"]
    if len(curves) < 2:
        return JointFriction(arm.names[j], directions, None, None)
    readings = [_readings(one.points) for one in curves]
    common, chance = common_curve(readings), compare_curves(readings)
    return JointFriction(arm.names[j], directions, common, chance)


def _direction(points: tuple[Point, ...], kind: str, runs: Floats, identified: NDArray[np.bool_]) -> Direction:
    speed, torque = _readings(points)
    by_hand = section3(speed, torque, kind) if (speed > 0.0).any() else None
    return Direction(points, by_hand, fit_curve(speed, torque), runs, identified, "none")


def _readings(points: Sequence[Point]) -> tuple[Floats, Floats]:
    """Return the absolute velocities (P,), rad/s, and the friction (P,), N m, of readings."""
    return np.array([point.speed for point in points]), np.array([point.torque for point in points])


def _of_runs(name: str, way: int, both: bool, whole: RunFit) -> tuple[Floats, NDArray[np.bool_]]:
    side = "backward" if both and way < 0 else "friction"
    keys = [entry.key for entry in whole.fit.entries]
    index = [keys.index(f"{name}.{side}.{key}") for key in NAMES]
    low = np.maximum(whole.intervals.low[index], 0.0)  # no constant lies below
    values = np.stack([whole.fit.p[index], low, whole.intervals.high[index]])
    return values, whole.intervals.identified[index]
