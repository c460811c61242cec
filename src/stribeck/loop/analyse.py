"""The whole analysis of a loop: exact and approximate methods side by side, joint by joint."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from stribeck.arm import Arm, unit_at
from stribeck.effects.undriven import undriven
from stribeck.errors import StribeckError
from stribeck.loop.answers import Analysis, JointAnswer, Method
from stribeck.loop.approximate import Approximation, approximate
from stribeck.loop.beyond import beyond
from stribeck.loop.cycle import STEADY, STOPPED, WORDS, Cycle
from stribeck.loop.exact.critical import fold_velocity, k_critical
from stribeck.loop.exact.engine import RoundsEngine
from stribeck.loop.exact.rounds import check_autonomous
from stribeck.loop.exact.settle import settle
from stribeck.loop.exact.shooting import shoot
from stribeck.loop.linear import Assembly, assemble, free, kp_max, margins
from stribeck.loop.linear.controller import derivative_gain
from stribeck.loop.ripple import DITHER, GRAVITY, Passage, forced_by, passages
from stribeck.loop.surroundings import Grid, alone, branch_of, locus_of, map_of
from stribeck.loop.watched import watched
from stribeck.simulate import Closed, JointLoop, Loop, close_loop

Floats = NDArray[np.float64]
Told = Callable[[str], None]
T = TypeVar("T")

LONGEST, MOST_ROWS = 2000.0, 200_000  # s and rows of the plain simulation
BRISTLES = "friction with bristles gives way before it slides: no time counts as stuck, however long the joint stands"
ROUNDS = 12.0  # periods that it lasts at least, where that is not too long


def analyse_loop(arm: Arm, loop: Loop, *, grid: Grid | None = None, progress: Told = lambda text: None) -> Analysis:
    """Return what every method says of every controlled joint.

    Cycles are those of the whole arm, its joints coupled. The approximate methods, the critical ratio, branch and map
    are those of each joint with the others held. Whatever is linear, or of one joint, is that of the pose in which the
    loop works: where its references end.

    Parameters
    ----------
    arm : Arm
        With the effects of its file.
    loop : Loop
        Checked (`stribeck.simulate.check_loop`).
    grid : Grid or None
        Of the maps.
    progress : callable
        Is told in words what is being done.

    Raises
    ------
    InputError
        When a reference drives the loop for ever: a limit cycle is what a loop does of itself.
    """
    arm, driven = undriven(arm)
    engine = RoundsEngine(arm)
    check_autonomous(engine, loop)
    grid = Grid() if grid is None else grid
    progress("shooting for cycles")
    exact = shoot(engine, loop)
    if loop.sample_time == 0.0 or any(cycle.verdict == "undetermined" for cycle in exact.values()):
        progress("simulating until it settles")
        settled = settle(engine, loop)
    else:
        settled = exact  # a sampled loop is followed until it settles in any case
    progress("simulating from the loop's own start")
    best = {name: settled[name] if cycle.verdict == "undetermined" else cycle for name, cycle in exact.items()}
    motion = close_loop(engine, _shown(loop, list(best.values())))
    progress("linearising")
    assembly = assemble(arm, loop, free(arm, loop))
    answers, passed = [], passages(arm, loop)
    for entry in loop.joints:
        found = _Found(exact[entry.joint], settled[entry.joint], motion, passed)
        answer = _joint(engine, loop, entry, found, assembly, grid, progress)
        answers.append(replace(answer, notes=(*driven, *answer.notes)))
    indices = tuple(arm.names.index(entry.joint) for entry in loop.joints)
    return Analysis(arm.name, loop.sample_time, loop.duration, loop.seed, tuple(answers), motion, indices)


@dataclass(frozen=True)
class _Found:
    """The exact answers for one joint, by shooting and by simulation; a plain simulation; what may force it."""

    shot: Cycle
    settled: Cycle
    motion: Closed
    passed: tuple[Passage, ...]

    @property
    def best(self) -> Cycle:
        """The one that the others are compared with."""
        return self.settled if self.shot.verdict == "undetermined" else self.shot


def _joint(
    engine: RoundsEngine, loop: Loop, entry: JointLoop, found: _Found, assembly: Assembly, grid: Grid, told: Told
) -> JointAnswer:
    name, best, arm = entry.joint, found.best, engine.arm
    kind = arm.joints[arm.names.index(name)].kind
    inertia, tuned = (float(each[assembly.index(name)]) for each in (assembly.inertia, assembly.tuned))
    told(f"{name}: margins and the largest gain")
    linear, largest = margins(assembly, name), kp_max(assembly, name)
    notes = _notes(loop, entry, inertia, linear.stable, largest.why)
    zones = sorted({place.effect.name for place in engine.path.placed if place.effect.zone})
    if zones:
        notes.append(f"margins and largest gains are those beyond what this loses: {', '.join(zones)}")
    if (wave := forced_by(best.verdict, best.period, found.passed)) is not None:
        notes.append(_rippling(wave, name))
    if engine.forward.bristles[arm.names.index(name)]:
        notes.append(BRISTLES)
    told(f"{name}: describing function and harmonic balance")
    approximation = _approximation(arm, loop, name, best, notes)
    roots = approximation.nyquist.roots if approximation.nyquist else ()
    notes.extend(filter(None, [beyond(engine, loop, name, roots, best)]))
    methods = {
        "describing_function": approximation.describing_function,
        "harmonic_balance": approximation.harmonic_balance,
        "shooting": _exact_method(found.shot, found, entry),
        "simulation": _simulation(found, arm.names.index(name), loop.sample_time > 0.0, entry, unit_at("rad/s", kind)),
    }
    single = alone(arm, loop, name)
    told(f"{name}: critical ratio")
    known = len(notes)
    critical = _tried(lambda: k_critical(engine, single, name), "critical ratio", notes)
    why = _why_none(entry, critical, failed=len(notes) > known)
    fold = _tried(lambda: fold_velocity(engine, single, name), "stick-slip fold", notes) if _moves(entry) else None
    told(f"{name}: branch of cycles")
    branch = _tried(lambda: branch_of(engine, loop, name, largest.stability), "branch of cycles", notes)
    chart = None
    if grid.wanted:
        told(f"{name}: map")
        done = lambda share: told(f"{name}: map, {100.0 * share:.0f} % of its cells")  # noqa: E731
        chart = _tried(lambda: map_of(engine, loop, name, grid, largest.stability, done), "map", notes)
    return JointAnswer(
        name, kind, entry, derivative_gain(entry, entry.kp, tuned),
        0.0 if entry.compensation.kind == "none" else entry.compensation.ratio, inertia, best, methods, critical, fold,
        largest, linear, approximation.nyquist, branch, chart, tuple(notes),
        locus_of(assembly, name, largest.stability), why, found.passed,
    )  # fmt: skip


def _tried(work: Callable[[], T], what: str, notes: list[str]) -> T | None:
    """Return what a part of the analysis gives; where it fails, say so and go on without it."""
    try:
        return work()
    except StribeckError as error:
        notes.append(f"no {what}: {error}")
        return None


def _why_none(entry: JointLoop, critical: float | None, *, failed: bool) -> str:
    """Return why a joint has no critical ratio; "" where it has one."""
    if critical is not None:
        return ""
    if entry.compensation.kind != "feedback":
        return "not sought: it is of a compensation of kind feedback"
    return "not found: the search failed" if failed else "none: no ratio makes it cycle"


def _approximation(arm: Arm, loop: Loop, joint: str, exact: Cycle, notes: list[str]) -> Approximation:
    try:
        return approximate(arm, loop, joint, exact, _damping(arm, loop, joint))
    except StribeckError as error:
        notes.append(f"no describing function: {error}")
        failed = Method("failed", None, False, str(error))
        return Approximation(failed, failed, None)


def _damping(arm: Arm, loop: Loop, joint: str) -> float:
    """Return the smallest damping ratio of a joint's loop without friction, the other joints held."""
    single = alone(arm, loop, joint)
    return margins(assemble(arm, single, free(arm, single)), joint).damping


def _moves(entry: JointLoop) -> bool:
    return entry.reference.kind == "ramp" and entry.reference.velocity != 0.0


def _exact_method(cycle: Cycle, found: _Found, entry: JointLoop) -> Method:
    """Return an exact method's answer, with its distance from the one that the others are compared with."""
    if cycle.verdict == "undetermined":
        return Method("undetermined", None, False, cycle.status)
    if cycle.verdict == "unbounded":
        return Method("unbounded", None, True, "grows without bound")
    why = STEADY if cycle.verdict == "rest" and _moves(entry) else WORDS.get(cycle.verdict, cycle.verdict)
    wave = forced_by(cycle.verdict, cycle.period, found.passed)
    why = why if wave is None else wave.word
    why = why if cycle.status == "ok" else f"{why}: {cycle.status}"
    errors = _errors(cycle.amplitude, cycle.period, found.best)
    return Method("ok", cycle.cycles, True, why, cycle.amplitude, cycle.period, *errors, cycle.stable)


def _errors(amplitude: float | None, period: float | None, reference: Cycle) -> tuple[float | None, float | None]:
    if not (amplitude and period and reference.amplitude and reference.period):
        return None, None
    return amplitude / reference.amplitude - 1.0, period / reference.period - 1.0


def _simulation(found: _Found, joint: int, sampled: bool, entry: JointLoop, unit: str) -> Method:
    """Return what simulation alone says: settled from three starts; a sampled loop as read off a plain record."""
    if not sampled:
        return _exact_method(found.settled, found, entry)
    if found.motion.motion.status != "ok":
        why = STOPPED.get(found.motion.motion.status, found.motion.motion.status)
        return Method(found.motion.motion.status, None, True, f"{why}: from the loop's own start")
    noisy = entry.encoder_noise > 0.0
    seen = watched(found.motion, joint, unit, noisy=noisy)
    start = f"from the loop's own start, second half of {found.motion.ended:.4g} s"
    if seen == "rest":
        return Method("ok", False, True, start)
    if isinstance(seen, str):
        return Method("undetermined", None, False, f"{seen}: {start}")
    return Method("ok", True, True, start, *seen, *_errors(*seen, found.best))


def _notes(loop: Loop, entry: JointLoop, inertia: float, stable: bool, why: str) -> list[str]:
    notes = []
    if not stable:
        more = f" ({why})" if why else ""
        notes.append(f"these gains make no stable loop once friction is overcome{more}")
    late, own = entry.delay_samples * loop.sample_time, 2.0 * math.pi * math.sqrt(inertia / entry.kp)
    if late > own:
        notes.append(f"the delay, {late:.4g} s, is longer than the loop's own period, {own:.4g} s")
    if entry.encoder_noise > 0.0:
        notes.append("with encoder noise nothing repeats exactly: the answer is the mean of a long simulation")
    if len(loop.joints) > 1:
        notes.append("cycles are those of all joints together; the rest is for this joint with the others held")
    return notes


def _rippling(wave: Passage, joint: str) -> str:
    if wave.cause == DITHER:
        whose = "the dither" if wave.joint == joint else f"the dither of {wave.joint}"
        return (
            f"forced by {whose}, whose period of {wave.time:.4g} s sets its own, and no limit cycle: "
            "leave the dither out to see what the loop does of itself"
        )
    what, until = (wave.cause, "a turn") if wave.cause == GRAVITY else ("the arm", f"one wave of {wave.cause}")
    return f"a ripple that {what} forces, and no limit cycle: {until} takes the ramp as long, {wave.time:.4g} s"


def _shown(loop: Loop, cycles: list[Cycle]) -> Loop:
    """Return the loop over a time in which its cycles can be seen, without steps that its own time does not reach."""
    kept = (replace(entry, reference=entry.reference.within(loop.duration)) for entry in loop.joints)
    loop = replace(loop, joints=tuple(kept))
    longest = max((cycle.period or 0.0 for cycle in cycles), default=0.0)
    most = min(LONGEST, MOST_ROWS * loop.sample_time) if loop.sample_time > 0.0 else LONGEST
    duration = max(loop.duration, min(ROUNDS * longest, most))
    if loop.sample_time > 0.0:
        return replace(loop, duration=duration)
    return replace(loop, duration=duration, record_step=max(loop.record_step, duration / MOST_ROWS))
