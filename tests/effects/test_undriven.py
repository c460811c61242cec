"""A joint that no drive moves has neither a drive's gain nor a load: both would fit whatever its model leaves."""

from dataclasses import replace

import pytest

from stribeck.effects.registry import laws
from stribeck.model.effect import ActuatorEffect, Effect, FrictionEffect
from stribeck.model.scale import Scale

DRIVEN = Scale(torque=2.0, friction=1.0, speed=1.0, travel=9.0, inertia=0.1, sample_time=1e-3, covered=9.0)


def needs_a_drive(effect: Effect) -> bool:
    if isinstance(effect, FrictionEffect):
        return effect.uses_load
    return isinstance(effect, ActuatorEffect) and type(effect).command_scale is not ActuatorEffect.command_scale


NEED = {key: effect for key, effect in laws().items() if needs_a_drive(effect)}


def test_gains_and_loads_need_a_drive() -> None:
    assert {effect.name for effect in NEED.values()} == {"torque_gain", "torque_ripple", "load_dependent_friction"}


@pytest.mark.parametrize("effect", NEED.values(), ids=lambda effect: f"{effect.name}-{effect.law}")
def test_without_a_drive_they_stand_for_something_else(effect: Effect) -> None:
    for start in effect.starts(DRIVEN):
        assert effect.plausible(start, DRIVEN)
        assert not effect.plausible(start, replace(DRIVEN, driven=False))
