"""Whether an effect of another package declares what every use of it needs: asked once, as it is loaded.

What is not told here comes up in the middle of a diagnosis, in the words of CasADi, and names no package.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection
from importlib.metadata import EntryPoint
from numbers import Real
from typing import Any, get_args

import numpy as np

from stribeck.arm import Arm, Friction, Joint, is_unit
from stribeck.errors import InputError
from stribeck.model.effect import (
    ActuatorEffect,
    Effect,
    ExternalEffect,
    FrictionEffect,
    RigidBodyEffect,
    SensingEffect,
    Shows,
    StandEffect,
    TransmissionEffect,
)
from stribeck.model.forward import DELAYED, Forward
from stribeck.model.layout import Placed
from stribeck.model.path import SignalPath
from stribeck.model.scale import Scale
from stribeck.model.values import Parameter

STAGES = (
    ActuatorEffect, ExternalEffect, FrictionEffect, RigidBodyEffect, SensingEffect, StandEffect, TransmissionEffect
)  # fmt: skip
CHANNELS = ("friction", "actuator", "transmission", "sensing", "rigid_body", "external")
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*")
_USUAL = Scale(
    torque=20.0, friction=3.0, speed=1.0, travel=2.0, inertia=0.5, sample_time=4e-3, length=0.35, distance=40.0,
    covered=2.0, needed=20.0,
)  # fmt: skip


def declared(point: EntryPoint, known: Collection[tuple[str, str]]) -> Effect:
    """Return the effect of an entry point.

    Parameters
    ----------
    point : EntryPoint
    known : collection of (str, str)
        Names and laws that are taken.

    Raises
    ------
    InputError
        One line: the entry point and its package, what is wrong with the declaration and what to do.
    """
    package = f"the package {point.dist.name}" if point.dist else "a package"
    try:
        effect = _made(point)
        check(effect, known)
    except InputError as error:
        what = f"entry point {point.name!r} ({point.value}) of {package}, in the group stribeck.effects: {error.what}"
        raise InputError(what, error.found, f"correct {package}, or uninstall it") from error
    return effect


def _made(point: EntryPoint) -> Effect:
    kind = _told("cannot be imported", point.load)
    if not callable(kind):
        raise InputError("is no class of an effect", repr(kind))
    effect = _told("cannot be made without arguments", kind)
    if not isinstance(effect, STAGES):
        stages = ", ".join(stage.__name__ for stage in STAGES)
        raise InputError(f"is no effect of a stage; its class must be one of {stages}", type(effect).__name__)
    return effect


def check(effect: Effect, known: Collection[tuple[str, str]] = ()) -> None:
    """Raise `InputError`, which says no more than what is wrong, for a faulty declaration."""
    for key in ("name", "channel", "equation", "symptom", "source"):
        _text(key, getattr(effect, key, None))
    _name("name", effect.name)
    if effect.law:
        _name("law", effect.law)
    _among("channel", effect.channel, CHANNELS)
    _among("shows", effect.shows, get_args(Shows))
    _among("delays", effect.delays, DELAYED)
    _check_parameters(effect)
    _check_states(effect)
    if (effect.name, effect.law) in known:
        raise InputError("its name and law are taken", effect.label)
    if not effect.law and effect.name in {name for name, _ in known}:
        raise InputError("its name is taken, and it is no law of its own of that name", effect.name)
    _check_starts(effect)
    _check_law(effect)


def _check_parameters(effect: Effect) -> None:
    parameters = getattr(effect, "parameters", None)
    if not isinstance(parameters, tuple) or not all(isinstance(one, Parameter) for one in parameters) or not parameters:
        raise InputError("parameters must be a tuple of Parameter; one alone needs a comma behind it", repr(parameters))
    names = [one.name for one in parameters]
    if len(set(names)) < len(names):
        raise InputError("two parameters have one name", ", ".join(map(str, names)))
    for one in parameters:
        _name("the name of a parameter", one.name)
        where = f"parameter {one.name}"
        _text(f"the description of {where}", one.description)
        if not isinstance(one.unit, str) or not is_unit(one.unit):
            raise InputError(f"the unit of {where} is not known", repr(one.unit))
        numbers = (one.null, one.lower, one.upper)
        if not all(isinstance(number, Real) and not math.isnan(number) for number in numbers):
            raise InputError(f"null, lower and upper of {where} must be numbers", repr(numbers))
        if not one.lower < one.upper:
            raise InputError(f"the bounds of {where} are not in order", f"{one.lower:g} to {one.upper:g}")
        if one.log and one.lower <= 0.0:
            raise InputError(f"{where} is fitted in its logarithm; its lower bound must be positive", f"{one.lower:g}")
    for needed, why in (("time", effect.delays), ("frequency", effect.waves)):
        if why and needed not in names:
            raise InputError(f"{'delays' if needed == 'time' else 'waves'} needs a parameter {needed!r}", str(names))


def _check_states(effect: Effect) -> None:
    if not isinstance(effect.states, tuple):
        raise InputError("states must be a tuple of names", repr(effect.states))
    for state in effect.states:
        _name("the name of a state", state)
        unit = effect.state_units.get(state, "1")
        if not isinstance(unit, str) or not is_unit(unit):
            raise InputError(f"the unit of the state {state} is not known", repr(unit))


def _check_starts(effect: Effect) -> None:
    """Raise `InputError` for starts that no fit can take: such a candidate would silently never be one."""
    starts = _told("its starts raise an error", effect.starts, _USUAL)
    if not isinstance(starts, tuple) or not starts or not all(isinstance(start, dict) for start in starts):
        raise InputError("starts must return a tuple of dicts, one at least", repr(starts))
    names = {one.name for one in effect.parameters}
    for start in starts:
        if set(start) != names:
            raise InputError(f"its starts must give a value for each of {', '.join(sorted(names))}", repr(start))
        if not all(isinstance(value, Real) and math.isfinite(value) for value in start.values()):
            raise InputError("its starts are not finite", repr(start))


def _check_law(effect: Effect) -> None:
    """Put the law into a path and look at what it gives for a motion."""
    arm = _usual_arm()
    sites = _told("its sites raise an error", effect.sites, arm.n)
    if not sites or not _told("its applies raises an error", effect.applies, arm, sites[0]):
        return
    start = effect.starts(_USUAL)[0]
    found = _told("its law raises an error", _motion, arm, Placed(effect, sites[0], start))
    if not np.isfinite(found).all():
        raise InputError("its law gives values that are not finite at its starts", repr(start))


def _motion(arm: Arm, place: Placed) -> Any:
    """Return all that the equations of an arm give where it moves."""
    forward = Forward(SignalPath(arm, [place]))
    position, velocity, command = np.array([0.3, -0.4]), np.array([0.5, -0.2]), np.array([8.0, -3.0])
    values = [place.values[one.name] if isinstance(one.owner, int) else one.value for one in forward.path.entries]
    states = forward.settled(position, velocity, command, values).full().ravel()
    inputs = (0.1, np.concatenate([position, velocity, states]), np.array([1.0, -1.0]), command, values)
    given = (*forward.flow(*inputs), *forward.outputs(*inputs))
    return np.concatenate([states, *(part.full().ravel() for part in given)])


def _usual_arm() -> Arm:
    friction = Friction(3.0, 1.0, 1.0, 0.05)
    joints = [Joint(name, "revolute", 0.35, 3.0, (0.15, 0.01), 0.05, 0.1, friction, friction) for name in "AB"]
    return Arm("usual", (9.81, 0.0), tuple(joints))


def _told(what: str, work: Callable[..., Any], *given: Any) -> Any:
    """Call what somebody else has written; turn whatever it raises into a line."""
    try:
        return work(*given)
    except Exception as error:
        raise InputError(what, f"{type(error).__name__}: {error}") from error


def _text(key: str, value: object) -> None:
    if value is None:
        raise InputError(f"{key} is missing")
    if not isinstance(value, str) or not value.strip():
        raise InputError(f"{key} must be a text", repr(value))


def _name(key: str, value: object) -> None:
    if not isinstance(value, str) or not _NAME.fullmatch(value):
        raise InputError(f"{key} must be letters and digits, words joined by _", repr(value))


def _among(key: str, value: object, known: Collection[object]) -> None:
    if value not in known:
        raise InputError(f"{key} must be one of {', '.join(map(str, known))}", repr(value))
