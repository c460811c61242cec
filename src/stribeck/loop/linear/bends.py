"""What kind of function of torque and motion an effect is: one that bends, one that only adds."""

from __future__ import annotations

import casadi as ca

from stribeck.model.effect import ActuatorEffect, Effect, ExternalEffect, TransmissionEffect
from stribeck.model.layout import Placed
from stribeck.model.values import Expression, Parameters, Signals, States


def bends(place: Placed) -> bool:
    """Tell whether the torque of a drive, transmission or outside effect is no linear function of torque and motion."""
    effect = place.effect
    if effect.everywhere and isinstance(effect, ExternalEffect):
        return True  # a wall against the tip
    s, seen, states, values = _symbols(place)
    found = _torque(effect, s, states, values)
    if found is None:
        return False
    rates = effect.derivatives(s, states, values)
    return not ca.is_linear(ca.vertcat(found, *rates.values()), ca.vertcat(seen, *states.values()))


def adds(place: Placed) -> bool:
    """Tell whether a drive's effect adds to the command what the motion alone decides, as slots do."""
    effect = place.effect
    if not isinstance(effect, ActuatorEffect) or effect.states or effect.delays:
        return False
    s, _, states, values = _symbols(place)
    return bool(ca.jacobian(effect.torque(s.torque, s, states, values), s.torque).is_one())


def _symbols(place: Placed) -> tuple[Signals, Expression, States, Parameters]:
    """Return what an effect may depend on, the same as one vector, its states and its values."""
    effect, seen = place.effect, ca.SX.sym("seen", 5)
    position, velocity, link_position, link_velocity, torque = ca.vertsplit(seen)
    s = Signals(0.0, position, velocity, 0.0, link_position, link_velocity, torque=torque)
    states = {name: ca.SX.sym(name) for name in effect.states}
    return s, seen, states, {each.name: place.values.get(each.name, each.null) for each in effect.parameters}


def _torque(effect: Effect, s: Signals, x: States, p: Parameters) -> Expression | None:
    if isinstance(effect, ActuatorEffect):
        return effect.torque(s.torque, s, x, p)
    if isinstance(effect, TransmissionEffect):
        return effect.transmitted(s.position - s.link_position, s.velocity - s.link_velocity, p)
    return effect.torque(s, x, p) if isinstance(effect, ExternalEffect) else None
