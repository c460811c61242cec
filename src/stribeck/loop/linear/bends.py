"""Which effects a linear model can only take for linear."""

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
    seen, x = ca.SX.sym("seen", 5), ca.SX.sym("x", len(effect.states))
    position, velocity, link_position, link_velocity, torque = ca.vertsplit(seen)
    s = Signals(0.0, position, velocity, 0.0, link_position, link_velocity, torque=torque)
    states = dict(zip(effect.states, ca.vertsplit(x), strict=True)) if effect.states else {}
    values = {each.name: place.values.get(each.name, each.null) for each in effect.parameters}
    found = _torque(effect, s, states, values)
    if found is None:
        return False
    rates = effect.derivatives(s, states, values)
    return not ca.is_linear(ca.vertcat(found, *rates.values()), ca.vertcat(seen, x))


def _torque(effect: Effect, s: Signals, x: States, p: Parameters) -> Expression | None:
    if isinstance(effect, ActuatorEffect):
        return effect.torque(s.torque, s, x, p)
    if isinstance(effect, TransmissionEffect):
        return effect.transmitted(s.position - s.link_position, s.velocity - s.link_velocity, p)
    return effect.torque(s, x, p) if isinstance(effect, ExternalEffect) else None
