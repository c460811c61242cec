"""Where cycles begin: the critical compensation ratio, and the ramp below which a joint sticks and slips."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from stribeck.arm import Arm
from stribeck.errors import InputError
from stribeck.loop.exact.ending import answers
from stribeck.loop.exact.engine import RoundsEngine
from stribeck.loop.exact.place import Place
from stribeck.loop.exact.rounds import Rounds
from stribeck.loop.exact.settle import settle_from
from stribeck.loop.exact.shooting import ending_of
from stribeck.loop.exact.starts import starts
from stribeck.simulate import JointLoop, Loop, Reference

_LARGEST = 1e3  # compensation over true friction; beyond it none is sought
_FINE = 1e-5  # of a ratio and of a velocity
_SLOWEST = 1e-2  # of the velocity alpha over which friction bends
_GROW = 1.25  # from one ratio to the next in search of the first that cycles


def k_critical(arm: Arm | RoundsEngine, loop: Loop, joint: str) -> float | None:
    """Return the smallest compensation ratio at which the joint does not come to rest; at larger ones it may again.

    The ratio of Coulomb friction compensated on the measured velocity, with rho = exp(-pi zeta/sqrt(1 - zeta^2)), is 1
    where the law at rest is set-valued, takes the error's sign or sees noise; 2/(1 + rho) where it is zero; and 1/rho
    where it holds the last sign.

    Parameters
    ----------
    arm : Arm
    loop : Loop
        Its ratio is not used.
    joint : str

    Returns
    -------
    float or None
        0 where it does not without compensation either; None where no ratio makes it cycle, or where the compensation
        is not on the measured velocity, so that it cannot.
    """
    entry = _entry(loop, joint)
    if entry.compensation.kind != "feedback":
        return None
    engine = arm if isinstance(arm, RoundsEngine) else RoundsEngine(arm)

    def moves(ratio: float) -> bool:
        changed = replace(entry, compensation=replace(entry.compensation, ratio=ratio))
        return not _rests(engine, _with(loop, changed), joint)

    if moves(0.0):
        return 0.0
    low, high = 0.0, 0.9
    while not moves(high):
        low, high = high, high * _GROW
        if high > _LARGEST:
            return None
    return _bisect(moves, low, high)


def fold_velocity(arm: Arm | RoundsEngine, loop: Loop, joint: str, fastest: float = 1e3) -> float | None:
    """Return the ramp's speed (rad/s) over which the joint, released from standstill, no longer sticks again.

    Parameters
    ----------
    arm : Arm
    loop : Loop
        The joint's reference is replaced by ramps in the same direction; forward where it is none.
    joint : str
    fastest : float
        rad/s, as fast as a loop file's ramps may be; None is returned where it sticks even there, or at no velocity.
    """
    engine = arm if isinstance(arm, RoundsEngine) else RoundsEngine(arm)
    entry = _entry(loop, joint)
    backward = entry.reference.kind == "ramp" and entry.reference.velocity < 0.0

    def slides(speed: float) -> bool:
        reference = Reference("ramp", velocity=-speed if backward else speed)
        rounds = Rounds(engine, _with(loop, replace(entry, reference=reference)), onward=False)
        return answers(rounds, ending_of(rounds, rounds.start({})), alike=False)[joint].verdict != "stick_slip"

    alpha = _bend(engine, joint, backward)
    low, high = _SLOWEST * alpha, 0.25 * alpha
    if slides(low):
        return None
    while not slides(high):
        low, high = high, 2.0 * high
        if high > fastest:
            return None
    return _bisect(slides, low, high)


def _bend(engine: RoundsEngine, joint: str, backward: bool) -> float:
    """Return the speed over which a joint's friction bends in one direction, rad/s."""
    values = engine.arm.joints[engine.arm.names.index(joint)]
    return values.backward.alpha if backward else values.friction.alpha


def _rests(engine: RoundsEngine, loop: Loop, joint: str) -> bool:
    """Tell whether the joint comes to rest from a large and a small start."""
    rounds = Rounds(engine, loop, onward=False)
    places: dict[str, Place] = starts(rounds)
    for name in ("large", "small") if "large" in places else ("own", "small"):
        ending = settle_from(rounds, places[name]) if rounds.noisy else ending_of(rounds, places[name])
        if answers(rounds, ending, alike=False)[joint].verdict not in ("rest", "undetermined"):
            return False
    return True


def _bisect(beyond: Callable[[float], bool], low: float, high: float) -> float:
    while high - low > _FINE * high:
        middle = 0.5 * (low + high)
        if beyond(middle):
            high = middle
        else:
            low = middle
    return 0.5 * (low + high)


def _entry(loop: Loop, joint: str) -> JointLoop:
    for entry in loop.joints:
        if entry.joint == joint:
            return entry
    raise InputError("the loop does not control this joint", repr(joint), f"it controls {_names(loop)}")


def _names(loop: Loop) -> str:
    return ", ".join(entry.joint for entry in loop.joints)


def _with(loop: Loop, entry: JointLoop) -> Loop:
    """Return the loop with one joint's part replaced."""
    return replace(loop, joints=tuple(entry if other.joint == entry.joint else other for other in loop.joints))
