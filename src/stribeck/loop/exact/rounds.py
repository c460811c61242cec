"""Rounds of a loop: run it from a place to a joint's next turns, event by event, and go on from there.

A joint turns where it is furthest ahead of its reference: where it stops or reverses in regulation, where it falls
behind the reference's velocity along a ramp. The turns are the section of the return map. Their deviations q - r are
counted in the direction of the reference, so that a turn is a largest one whichever way a ramp goes.
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from copy import copy
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stribeck.arm import Arm
from stribeck.effects.placing import placed_effects
from stribeck.errors import InputError
from stribeck.loop.exact.engine import RoundsEngine
from stribeck.loop.exact.place import Layout, Place, Stretch
from stribeck.loop.exact.wish import TURN, Wish
from stribeck.simulate import JointLoop, Loop, Reference
from stribeck.simulate.axis import axes_of, start_position
from stribeck.simulate.closed import BOUND
from stribeck.simulate.engine import pointer
from stribeck.simulate.motion import STATUS

Floats = NDArray[np.float64]

WHY = {**dict(enumerate(STATUS)), 20: "quiet", 21: "enough", 22: "end"}
ANY, NONE = -1, -2  # joints whose turns are counted
_QUIET, _QUIET_SLIDE = 1e-10, 1e-6  # rad/s, rad/s^2, and the controller's own rates
_MOST_SAMPLES = 4_000_000


class Rounds:
    """A loop around an arm, ready to run.

    Parameters
    ----------
    arm : Arm or RoundsEngine
        With the effects of its file; an engine may serve many loops.
    loop : Loop
        References must be ramps, or at rest in the end: a limit cycle is what a loop does of itself. Steps are at their
        last one within the duration, before which `stribeck.loop.exact.starts` runs the loop under the others.
    rtol, atol : float
        Of one step's error.
    onward : bool
        Whether it counts what a ramp leads to later; else only how the joint moves where it is.

    Raises
    ------
    InputError
        When a reference or an effect drives the loop for ever.
    """

    def __init__(
        self, arm: Arm | RoundsEngine, loop: Loop, *, rtol: float = 1e-10, atol: float = 1e-13, onward: bool = True
    ) -> None:
        self.engine = arm if isinstance(arm, RoundsEngine) else RoundsEngine(arm)
        check_autonomous(self.engine, loop)
        self.arm, self.given, self.onward = self.engine.arm, loop, onward
        self.loop = replace(loop, joints=tuple(_autonomous(entry, loop.duration) for entry in loop.joints))
        self.n, self.p, self.rtol, self.atol = self.engine.n, self.engine.p, rtol, atol
        self.layout = Layout(self.engine.n, self.engine.size)
        self.home = start_position(self.arm, self.loop)
        self.inertia = self.engine.moved_inertia(self.home)
        self.axes, self._tables = axes_of(self.arm, self.loop, self.inertia)
        self.history = _history(self.arm, loop)
        self._rng = np.random.default_rng(loop.seed)

    @property
    def sampled(self) -> bool:
        """Whether the controller is sampled."""
        return self.loop.sample_time > 0.0

    @property
    def noisy(self) -> bool:
        """Whether an encoder has noise."""
        return any(entry.encoder_noise > 0.0 for entry in self.loop.joints)

    def entry(self, joint: str) -> JointLoop:
        """Return a joint's part of the loop."""
        return next(entry for entry in self.loop.joints if entry.joint == joint)

    def index(self, joint: str) -> int:
        """Return a joint's place in the arm."""
        return self.arm.names.index(joint)

    def break_away(self, j: int) -> float:
        """Return the torque, N m, that moves joint j from rest in either direction: C0 + C1, the larger."""
        friction = self.axes[j].friction
        return max(float(level[0] + level[1]) for level in (friction[:4], friction[4:]))

    def rate(self, j: int) -> float:
        """Return the velocity of a joint's reference, rad/s."""
        axis = self.axes[j]
        return float(axis.reference[1]) if axis.controlled else 0.0

    @property
    def passes(self) -> bool:
        """Whether a ramp leads a joint past places that resist it differently, so that its motion need not last."""
        return self.onward and any(self.engine.varies[j] for j in range(self.n) if self.rate(j) != 0.0)

    def aiming(self, positions: Mapping[str, float]) -> Rounds:
        """Return the same loop with references that stand at other positions (rad), of the joints that are named."""
        other = copy(self)
        entries = (replace(entry, start=positions.get(entry.joint, entry.start)) for entry in self.loop.joints)
        other.loop = replace(self.loop, joints=tuple(entries))
        other.axes, other._tables = axes_of(self.arm, other.loop, self.inertia)
        return other

    def start(self, errors: Mapping[str, float], rates: Mapping[str, float] | None = None) -> Place:
        """Return the place at time 0 with an error (rad) of each joint that is named, and its velocity (rad/s).

        Joints that are not named start as the loop file says, at rest.
        """
        q = self.home.copy()
        for entry in self.loop.joints:
            if entry.joint in errors:
                q[self.index(entry.joint)] = entry.start - errors[entry.joint]
        theta = np.array([[axis.ratio * axis.friction[i] for i in range(3)] for axis in self.axes])
        dq = np.array([(rates or {}).get(name, 0.0) for name in self.arm.names])
        state = self.engine.start(self.p, q, dq)
        return Place(self.layout.start(state, theta, self.sampled), np.zeros((2, self.history, self.n)))

    def run(
        self, place: Place, watch: int, *, most: int = 1, duration: float = 1e9, rows: int = 0, step: float = 0.0,
        quiet: bool = True,
    ) -> Stretch:  # fmt: skip
        """Run until joint ``watch`` has turned ``most`` times, for ``duration`` s at most.

        Parameters
        ----------
        place : Place
        watch : int
            Joint; `ANY`; or `NONE`, to run on for the whole duration.
        most : int
            Turns; those of every joint are returned, up to a few times as many.
        duration : float
        rows, step : int, float
            Rows of a record and the time between them, s; a sampled loop records its samples.
        quiet : bool
            Whether to stop where nothing moves any more.
        """
        wish = Wish(rtol=self.rtol, atol=self.atol, bound=BOUND, sample=self.loop.sample_time)
        wish.quiet, wish.quiet_slide = (_QUIET, _QUIET_SLIDE) if quiet else (0.0, 0.0)
        wish.watch, wish.most, wish.size = watch, most, min(self.n * (most + 4) * 4, 1_000_000)
        if self.sampled:
            return self._run_sampled(wish, place, duration, rows)
        wish.end, wish.rows, wish.record_step = place.values[0] + duration, rows, step
        return self._call(wish, place, np.zeros(1), None, np.zeros((2, 1, self.n)), rows)

    def _run_sampled(self, wish: Wish, place: Place, duration: float, rows: int) -> Stretch:
        ts, h = self.loop.sample_time, self.history
        samples = rows if rows > 0 else max(int(min(duration / ts, _MOST_SAMPLES)), 1)
        wish.first, wish.count, wish.calm = h, h + samples, 20 + h
        times = ts * (place.sample + np.arange(-h, samples + 1, dtype=np.float64))
        commands = np.zeros((2, h + samples + 1, self.n))
        commands[:, :h] = place.past
        noise = None
        if self.noisy:
            noise = self._rng.standard_normal((h + samples + 1, self.n))
            sd = {self.index(entry.joint): entry.encoder_noise for entry in self.loop.joints}
            noise *= [sd.get(j, 0.0) for j in range(self.n)]
        return self._call(wish, place, times, noise, commands, rows)

    def _call(
        self, wish: Wish, place: Place, times: Floats, noise: Floats | None, commands: Floats, rows: int
    ) -> Stretch:
        values, turns, out = place.values.copy(), np.zeros(wish.size, TURN), np.zeros(3, dtype=np.int64)
        record = np.full((rows, 3, self.n), np.nan)
        computed, issued = commands
        seen = np.zeros_like(issued)
        code = self.engine.rounds_library.sb_run_rounds(
            ctypes.byref(wish), pointer(self.p), self.axes, pointer(values), pointer(times), pointer(noise),
            pointer(issued), pointer(computed), pointer(seen), pointer(turns), pointer(record if rows else None),
            pointer(out),
        )  # fmt: skip
        past, sample = place.past, place.sample
        if self.sampled:
            reached = int(out[1])
            past, sample = commands[:, reached - self.history : reached].copy(), place.sample + reached - self.history
            values[0] = times[reached]
        return Stretch(WHY[int(code)], turns[: int(out[0])].copy(), Place(values, past, sample), record)

    def slopes(self, place: Place) -> tuple[Floats, Floats]:
        """Return a continuous loop's rate of change (s,) at a place and its slopes (s, s), in its present modes."""
        size = self.layout.ny
        rate, matrix = np.zeros(size), np.zeros((size, size))
        self.engine.rounds_library.sb_place_slopes(
            pointer(self.p), self.axes, pointer(place.values), pointer(rate), pointer(matrix)
        )
        return rate, matrix


def _history(arm: Arm, loop: Loop) -> int:
    """Return how many past commands may still come through."""
    if loop.sample_time == 0.0:
        return 1
    times = [place.values.get("time", 0.0) for place in placed_effects(arm) if place.effect.delays]
    late = int(np.ceil(sum(times) / loop.sample_time)) + 1
    return max(entry.delay_samples for entry in loop.joints) + late + 1


def check_autonomous(engine: RoundsEngine, loop: Loop) -> None:
    """Raise `InputError` where a reference, or an effect of the arm, drives the loop for ever."""
    for entry in loop.joints:
        if entry.reference.kind not in ("ramp", "regulate", "steps"):
            what = f"joint {entry.joint}: a limit cycle is what a loop does of itself, and this reference drives it"
            raise InputError(what, repr(entry.reference.kind), "use the reference kind regulate or ramp")
    if engine.driven:
        laws = {place.effect.label for place in engine.path.placed if place.effect.waves}
        what = f"arm {engine.arm.name!r}: a limit cycle is what a loop does of itself, and an effect drives it in time"
        raise InputError(what, ", ".join(sorted(laws)), "leave the effect out of the arm file")


def _autonomous(entry: JointLoop, duration: float) -> JointLoop:
    """Return a joint's loop with a reference that leaves it to itself: that of its last step within the duration."""
    if entry.reference.kind != "steps":
        return entry
    last = (entry.start, *entry.reference.within(duration).values)[-1]
    return replace(entry, start=last, reference=Reference("regulate", initial_error=last - entry.start))
