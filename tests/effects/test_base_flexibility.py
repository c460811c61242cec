"""On a light base the law is that of a compliant joint, and is not taken for a base."""

from stribeck.effects.registry import registry
from stribeck.effects.rigid_body.base_flexibility import DAMPED, LIGHTEST
from stribeck.model.values import Scale

SCALE = Scale(torque=5.0, friction=0.5, speed=1.0, travel=2.0, inertia=0.4, sample_time=0.005, length=0.3)


def test_a_base_as_heavy_as_the_arm_can_be_meant_and_a_light_one_not() -> None:
    base, values = registry()["base_flexibility"], {"stiffness": 300.0, "damping": 1.0}
    assert base.plausible({**values, "inertia": SCALE.inertia}, SCALE)
    assert not base.plausible({**values, "inertia": 0.5 * LIGHTEST * SCALE.inertia}, SCALE)


def test_what_hardly_rings_is_no_stand() -> None:
    """A shaft's ringing that noise blurs would pass for one."""
    base, values = registry()["base_flexibility"], {"stiffness": 300.0, "inertia": 3.0}
    scale = Scale(torque=1.0, friction=0.1, speed=1.0, travel=1.0, inertia=1.0, sample_time=1e-3, length=0.5)
    critical = 60.0  # N m s/rad
    assert base.plausible({**values, "damping": 0.9 * DAMPED * critical}, scale)
    assert not base.plausible({**values, "damping": 1.1 * DAMPED * critical}, scale)
