"""Cases of the user's own arm and motions: what the experiment shows if this or that is hidden in the arm."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import BPoly, make_interp_spline
from scipy.signal import butter, sosfiltfilt

from stribeck.arm import Arm
from stribeck.errors import InputError, StribeckError
from stribeck.run import Run
from stribeck.withheld.arms import misinformed
from stribeck.withheld.bench import Bench
from stribeck.withheld.cases import place_of
from stribeck.withheld.hide import Case, Plot, hide
from stribeck.withheld.injections import KNOWN
from stribeck.withheld.motions import Curve, Motion
from stribeck.withheld.plan import Plan
from stribeck.withheld.plant import Array

BANDWIDTH = 3.0  # Hz, of the controller: a recording does not tell it
KNOTS = 200.0  # Hz, of the curve that is tracked
TRACKED = 8.0  # Hz, up to which a recorded motion is tracked where there is no reference
SHORTEST = 1.0  # s, of a motion
LONGEST = 60.0  # s, of one motion
LEAD = 1.0  # s, from rest to the state in which a recording begins
TELLING = 3  # motions on which effects are sized: a slow one, a fast one, one in between
SURE = (0.1, 0.3)  # the arm is off by its stated tolerance (inertial, friction), but by no more than these


@dataclass(frozen=True)
class OwnMaker:
    """Makes cases of one arm and its recordings; can be given to other processes.

    Attributes
    ----------
    arm : Arm
        The nominal arm. The arm that records is drawn from it within its tolerance, anew for each case.
    motions : tuple of (name, duration, angles (N, n))
        What is tracked: angles every 5 ms, rad.
    bench : Bench
        The laboratory, as far as recordings tell of it.
    resolution : tuple of float
        Of the encoders, rad.
    """

    arm: Arm
    motions: tuple[tuple[str, float, Array], ...]
    bench: Bench
    resolution: tuple[float, ...]

    def programme(self) -> list[Motion]:
        """Return the motions as the recorder takes them."""
        return [Motion(name, duration, _curves(angles)) for name, duration, angles in self.motions]

    def __call__(self, seed: int, plan: Plan) -> Case:
        """Return the case of a seed and a plan; raise `StribeckError` where it cannot be recorded."""
        rng = np.random.default_rng([seed, 2028])
        inertial, friction = min(self.arm.tolerance.inertial, SURE[0]), min(self.arm.tolerance.friction, SURE[1])
        true = replace(misinformed(self.arm, rng, inertial, friction), tolerance=self.arm.tolerance)
        joints = zip(true.joints, self.resolution, strict=True)
        true = replace(true, joints=tuple(replace(j, encoder_resolution=r) for j, r in joints))
        motions = self.programme()
        places = tuple(place_of(rng, name, true) for name in plan.effects)
        for name, place in zip(plan.effects, places, strict=True):
            if name == "negative_damping" and true.joints[true.names.index(place)].friction.C1 > 0.0:
                raise StribeckError("negative_damping is no news to this arm", f"C1 of {place}", "leave it out")
        plot = Plot(plan.effects, places, plan.level, int(rng.integers(2**31)), plan.disturbed)
        return hide(true, self.arm, motions, _telling(motions), self.bench, plot, seed)


def own_maker(arm: Arm, runs: Sequence[Run]) -> OwnMaker:
    """Return the maker of cases of one's own arm and motions.

    The reference is tracked where there is one, else the recorded motion. Rate, channels, encoders and their noise
    are taken from the recordings; the controller, which they do not tell, has a natural frequency of 3 Hz. It adds
    gravity, and all of its own model where a recorded motion is tracked, which is to be met and not only approached.

    Parameters
    ----------
    arm : Arm
        Nominal, without effects of its own.
    runs : sequence of Run

    Raises
    ------
    InputError
        For an arm whose file names effects, which the recording plant does not know, or too short a run.
    """
    if arm.effects:
        what = "an arm with effects of its own cannot be recorded"
        raise InputError(what, arm.effects[0].effect, "give the nominal arm, without [[effects]]")
    for run in runs:
        if run.duration < SHORTEST:
            what = f"{run.name}: too short to track"
            raise InputError(what, f"{run.duration:.3g} s", f"record {SHORTEST:g} s or more")
    if arm.n > 4:
        raise InputError("the recording plant takes at most 4 joints", str(arm.n), "give a shorter chain")
    resolution = tuple(_resolution(arm, runs, k) for k in range(arm.n))
    noise = max(_noise(run, k, resolution[k]) for run in runs for k in range(arm.n))
    rate = float(f"{1.0 / np.median([run.sample_time for run in runs]):.6g}")
    channels = tuple(c for c in ("dq", "q_ref", "dq_ref", "tau_meas") if all(getattr(r, c) is not None for r in runs))
    bench = Bench(
        rate=rate, bits=0, noise=noise, bandwidth=min(BANDWIDTH, rate / 50.0), damping=0.8, integral=0.15,
        forward=_forward(arm, runs), velocity_filter=max(1.0 / rate, 0.005),
        duration=max(min(run.duration, LONGEST) for run in runs), kinds=(), one_by_one=False, channels=channels,
    )  # fmt: skip
    return OwnMaker(arm, tuple(_tracked(run) for run in runs), bench, resolution)


def _forward(arm: Arm, runs: Sequence[Run]) -> str:
    if any(run.q_ref is None for run in runs):
        return "inertial"
    return "gravity" if math.hypot(*arm.gravity) > 0.0 else "none"


def possible(arm: Arm) -> tuple[str, ...]:
    """Return the known effects that can be hidden in an arm as it is."""
    falling = any(joint.friction.C1 != 0.0 for joint in arm.joints)
    slides = any(joint.kind == "prismatic" for joint in arm.joints)
    never = {"negative_damping": falling, "base_flexibility": slides}
    return tuple(name for name in KNOWN if not never.get(name))


def _tracked(run: Run) -> tuple[str, float, Array]:
    """Return name, duration and angles every 1 / KNOTS s; a recorded motion is smoothed first, noise is not tracked."""
    seen = run.t - run.t[0] <= LONGEST
    t = run.t[seen] - run.t[0]
    grid = np.arange(0.0, t[-1], 1.0 / KNOTS)
    given = run.q if run.q_ref is None else run.q_ref
    angles = np.stack([np.interp(grid, t, given[seen, k]) for k in range(run.n)], axis=1)
    sos = butter(2, TRACKED, fs=KNOTS, output="sos")  # a stepped reference would ask for infinite torque as well
    return run.name, float(grid[-1]) + LEAD, np.asarray(sosfiltfilt(sos, angles, axis=0))


def _curves(angles: Array) -> tuple[Curve, ...]:
    """Return one curve a joint: from rest into the tracked motion, which may begin at speed."""
    t = LEAD + np.arange(len(angles)) / KNOTS
    return tuple(_curve(t, angles[:, k]) for k in range(angles.shape[1]))


def _curve(t: Array, angle: Array) -> Curve:
    spline = make_interp_spline(t, angle, k=5)
    q, dq, ddq = (float(spline(LEAD, d)) for d in range(3))
    lead = BPoly.from_derivatives([0.0, LEAD], [[q - 0.5 * LEAD * dq, 0.0, 0.0], [q, dq, ddq]])

    def curve(at: Array) -> tuple[Array, Array, Array]:
        before, after = np.clip(at, 0.0, LEAD), np.clip(at, LEAD, t[-1])
        parts = [np.where(at < LEAD, lead(before, d), spline(after, d)) for d in range(3)]
        return parts[0], parts[1], parts[2]

    return curve


def _telling(motions: Sequence[Motion]) -> list[Motion]:
    """Return at most three motions: the slowest, the fastest and the middle one."""

    def pace(motion: Motion) -> float:
        return float(np.sqrt(np.mean(motion.sample(np.arange(0.0, motion.duration, 0.01))[1] ** 2)))

    ranked = sorted(motions, key=pace)
    return ranked if len(ranked) <= TELLING else [ranked[0], ranked[len(ranked) // 2], ranked[-1]]


def _resolution(arm: Arm, runs: Sequence[Run], k: int) -> float:
    """Return the encoder count, rad: the arm file's, or the smallest step where all steps are multiples of it."""
    stated = arm.joints[k].encoder_resolution
    if stated is not None:
        return stated
    steps = np.abs(np.concatenate([np.diff(run.q[:, k]) for run in runs]))
    steps = steps[steps > 1e-12]
    if len(steps) == 0:
        return 0.0
    count = float(steps.min())
    off = np.abs(steps / count - np.round(steps / count))
    return count if float(np.quantile(off, 0.99)) < 0.05 and float(np.median(steps)) < 1e3 * count else 0.0


def _noise(run: Run, k: int, resolution: float) -> float:
    """Return the encoder's noise beyond its rounding, rad, from fourth differences, in which no motion is left."""
    fourth = np.diff(run.q[:, k], 4)
    total = 1.4826 * float(np.median(np.abs(fourth))) / math.sqrt(70.0)
    return math.sqrt(max(total**2 - resolution**2 / 12.0, 0.0))
