"""Cases of the user's own arm and motions: what the experiment shows if this or that is hidden in the arm."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import BPoly, make_interp_spline
from scipy.signal import butter, sosfiltfilt

from stribeck.arm import Arm
from stribeck.errors import InputError, StribeckError
from stribeck.run import Run
from stribeck.withheld.arms import misinformed
from stribeck.withheld.bench import Bench
from stribeck.withheld.cases import only_place, place_of
from stribeck.withheld.hide import Case, Plot, hide
from stribeck.withheld.injections import KNOWN
from stribeck.withheld.motions import Curve, Motion, hold
from stribeck.withheld.plan import Plan
from stribeck.withheld.plant import Array
from stribeck.withheld.recorded import encoder_count, encoder_noise, held_joints, made_even, usual_rate

BANDWIDTH = 3.0  # Hz, of the controller: a recording does not tell it
KNOTS = 200.0  # Hz, of the curve that is tracked
TRACKED = 8.0  # Hz, up to which a recorded motion is tracked where there is no reference
SHORTEST = 1.0  # s, of a motion
LONGEST = 60.0  # s, of one motion
LEAD = 1.0  # s, from rest to the state in which a recording begins
TELLING = 3  # motions on which effects are sized: a slow one, a fast one, one in between
SURE = (0.1, 0.3)  # the arm is off by its stated tolerance (inertial, friction), but by no more than these


@dataclass(frozen=True)
class Tracked:
    """What is tracked of a recording for so many seconds: angles (N, n) every 5 ms, rad; ``held`` joints stay."""

    name: str
    duration: float
    angles: Array
    held: tuple[int, ...]


@dataclass(frozen=True)
class OwnMaker:
    """Makes cases of one arm and its recordings; can be given to other processes.

    Attributes
    ----------
    arm : Arm
        The nominal arm. The arm that records is drawn from it within its tolerance, anew for each case.
    motions : tuple of Tracked
    bench : Bench
        The laboratory, as far as recordings tell of it.
    resolution : tuple of float
        Of the encoders, rad.
    notes : tuple of str
        What was done to the recordings.
    """

    arm: Arm
    motions: tuple[Tracked, ...]
    bench: Bench
    resolution: tuple[float, ...]
    notes: tuple[str, ...] = ()

    @property
    def driven(self) -> tuple[str, ...]:
        """Joints that are driven in some motion."""
        return tuple(n for k, n in enumerate(self.arm.names) if any(k not in m.held for m in self.motions))

    def programme(self) -> list[Motion]:
        """Return the motions as the recorder takes them."""
        return [Motion(m.name, m.duration, _curves(m.angles, m.held), held=m.held) for m in self.motions]

    def effects(self, wanted: Sequence[str] = ()) -> tuple[str, ...]:
        """Return the effects to hide: those that are ``wanted``, or else all that can be.

        Raises
        ------
        InputError
            For one that is wanted and would not show in these recordings, whatever the arm does.
        """
        if not wanted:
            return tuple(name for name in possible(self.arm) if self._lacks(name) is None)
        for name in wanted:
            lacks = self._lacks(name)
            if lacks is not None:
                raise InputError(f"{name} {lacks[0]}", lacks[1], f"record it so, or leave {name} out")
        return tuple(wanted)

    def _lacks(self, name: str) -> tuple[str, str] | None:
        """Return what the recordings must have for an effect to show, and what they have; None where they have it."""
        if name == "velocity_filter" and "dq" not in self.bench.channels:
            every = ", ".join(f"dq{k + 1}" for k in range(self.arm.n))
            return f"needs {every} in the recordings", "not in all of them"
        place = only_place(name, self.arm)
        if place is not None and place not in self.driven:
            return f"needs joint {place} driven", "held in all recordings"
        return None

    def __call__(self, seed: int, plan: Plan) -> Case:
        """Return the case of a seed and a plan; raise `StribeckError` where it cannot be recorded."""
        rng = np.random.default_rng([seed, 2028])
        inertial, friction = min(self.arm.tolerance.inertial, SURE[0]), min(self.arm.tolerance.friction, SURE[1])
        true = replace(misinformed(self.arm, rng, inertial, friction), tolerance=self.arm.tolerance)
        joints = zip(true.joints, self.resolution, strict=True)
        true = replace(true, joints=tuple(replace(j, encoder_resolution=r) for j, r in joints))
        motions = self.programme()
        places = tuple(place_of(rng, name, true, self.driven) for name in plan.effects)
        for name, place in zip(plan.effects, places, strict=True):
            if name == "negative_damping" and true.joints[true.names.index(place)].friction.C1 > 0.0:
                raise StribeckError("negative_damping is no news to this arm", f"C1 of {place}", "leave it out")
        plot = Plot(plan.effects, places, plan.level, int(rng.integers(2**31)), plan.disturbed)
        telling = _telling(motions, [true.names.index(place) for place in places or self.driven])
        return hide(true, self.arm, motions, telling, self.bench, plot, seed)


def own_maker(arm: Arm, runs: Sequence[Run]) -> OwnMaker:
    """Return the maker of cases of one's own arm and motions.

    The reference is tracked where there is one, else the recorded motion, put on a uniform clock as for a diagnosis.
    Rate, channels, encoders and their noise are taken from the recordings, and which joints are held by a brake; the
    controller, which they do not tell, has a natural frequency of 3 Hz. It adds gravity, and all of its own model where
    a recorded motion is tracked, which is to be met and not only approached.

    Parameters
    ----------
    arm : Arm
        Nominal, without effects of its own.
    runs : sequence of Run

    Raises
    ------
    InputError
        For an arm whose file names effects, which the recording plant does not know, too short a run, or a joint that
        moves without a torque.
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
    notes: list[str] = []
    read, runs = made_even(runs, notes)
    resolution = tuple(encoder_count(arm, read, k) for k in range(arm.n))
    noise = tuple(encoder_noise(runs, k, resolution[k]) for k in range(arm.n))
    held = held_joints(arm, runs, noise, resolution)
    rate = usual_rate(runs, notes)
    channels = tuple(c for c in ("dq", "q_ref", "dq_ref", "tau_meas") if all(getattr(r, c) is not None for r in runs))
    bench = Bench(
        rate=rate, bits=0, noise=noise, bandwidth=min(BANDWIDTH, rate / 50.0), damping=0.8, integral=0.15,
        forward=_forward(arm, runs), velocity_filter=max(1.0 / rate, 0.005),
        duration=max(min(run.duration, LONGEST) for run in runs), kinds=(), one_by_one=False, channels=channels,
    )  # fmt: skip
    motions = tuple(_tracked(run, joints) for run, joints in zip(runs, held, strict=True))
    maker = OwnMaker(arm, motions, bench, resolution)
    return replace(maker, notes=(*notes, *_left_out(maker, runs)))


def _left_out(maker: OwnMaker, runs: Sequence[Run]) -> list[str]:
    """Return notes on what of the recordings is not tracked, and in which joints nothing is hidden."""
    long = [run for run in runs if run.duration > LONGEST]
    said = [f"{run.name}: its first {LONGEST:g} s are tracked, of {run.duration:.4g}" for run in long]
    idle = ", ".join(name for name in maker.arm.names if name not in maker.driven)
    return [*said, *([f"held in all recordings, at a constant torque: nothing is hidden in {idle}"] if idle else [])]


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


def _tracked(run: Run, held: tuple[int, ...]) -> Tracked:
    """Return what is tracked, every 1 / KNOTS s; a recorded motion is smoothed first, noise is not tracked."""
    seen = run.t - run.t[0] <= LONGEST
    t = run.t[seen] - run.t[0]
    grid = np.arange(0.0, t[-1], 1.0 / KNOTS)
    given = run.q if run.q_ref is None else run.q_ref
    angles = np.stack([np.interp(grid, t, given[seen, k]) for k in range(run.n)], axis=1)
    sos = butter(2, TRACKED, fs=KNOTS, output="sos")  # a stepped reference would ask for infinite torque as well
    angles = np.asarray(sosfiltfilt(sos, angles, axis=0))
    angles[:, list(held)] = np.mean(run.q[:, list(held)], axis=0)
    return Tracked(run.name, float(grid[-1]) + LEAD, angles, held)


def _curves(angles: Array, held: Collection[int]) -> tuple[Curve, ...]:
    """Return one curve a joint: from rest into the tracked motion, which may begin at speed; of a ``held`` one none."""
    t = LEAD + np.arange(len(angles)) / KNOTS
    joints = range(angles.shape[1])
    return tuple(hold(float(angles[0, k])) if k in held else _curve(t, angles[:, k]) for k in joints)


def _curve(t: Array, angle: Array) -> Curve:
    spline = make_interp_spline(t, angle, k=5)
    q, dq, ddq = (float(spline(LEAD, d)) for d in range(3))
    lead = BPoly.from_derivatives([0.0, LEAD], [[q - 0.5 * LEAD * dq, 0.0, 0.0], [q, dq, ddq]])

    def curve(at: Array) -> tuple[Array, Array, Array]:
        before, after = np.clip(at, 0.0, LEAD), np.clip(at, LEAD, t[-1])
        parts = [np.where(at < LEAD, lead(before, d), spline(after, d)) for d in range(3)]
        return parts[0], parts[1], parts[2]

    return curve


def _telling(motions: Sequence[Motion], joints: Sequence[int]) -> list[Motion]:
    """Return the slowest, the fastest and the middle motion that drive one of the joints, and one for each joint."""

    def pace(motion: Motion) -> float:
        return float(np.sqrt(np.mean(motion.sample(np.arange(0.0, motion.duration, 0.01))[1] ** 2)))

    ranked = sorted((motion for motion in motions if set(joints) - set(motion.held)), key=pace)
    told = ranked if len(ranked) <= TELLING else [ranked[0], ranked[len(ranked) // 2], ranked[-1]]
    for k in joints:
        if all(k in motion.held for motion in told):
            told.append(next(motion for motion in ranked[::-1] if k not in motion.held))
    return told
