"""Readings off recordings: right where friction is known, and none where there is nothing to read."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import EffectEntry, Friction
from stribeck.identify.beyond import Beyond
from stribeck.identify.conditioning import condition
from stribeck.identify.curve import Point, read_points
from stribeck.identify.residual import Residual
from stribeck.model.layout import values_of
from stribeck.run import Run
from stribeck.simulate import path_of

from .bench import BACKWARD, FORWARD, breaking, joint, sliding
from .conftest import recorded


def read(run: Run, gravity: float = 0.0, *effects: EffectEntry) -> tuple[Point, ...]:
    arm = replace(joint(gravity=gravity), effects=effects)
    path = path_of(arm)
    return read_points(path, values_of(path.entries), [condition(arm, run, 20.0)])


def level(friction: Friction, speed: float) -> float:
    return friction.C0 + friction.C1 * float(np.exp(-speed / friction.alpha)) + friction.C2 * speed


@pytest.mark.parametrize("gravity", [0.0, 9.81])
@pytest.mark.parametrize("speed", [0.02, -0.02, 0.3, -1.0])
def test_steady_sliding_reads_friction(speed: float, gravity: float) -> None:
    """In a vertical plane too, where the command holds the weight as well."""
    points = [point for point in read(sliding(speed, gravity), gravity) if point.speed > 0.0]
    assert len(points) == 1
    (point,) = points
    assert point.direction == np.sign(speed)
    assert point.speed == pytest.approx(abs(speed), rel=0.01)
    assert point.torque == pytest.approx(level(FORWARD if speed > 0 else BACKWARD, abs(speed)), rel=0.01)
    assert point.samples > 200


@pytest.mark.parametrize("rate", [0.8, 1.6, 3.2])
@pytest.mark.parametrize(("way", "friction"), [(1, FORWARD), (-1, BACKWARD)])
def test_break_away_is_read_back_to_where_it_began(way: int, friction: Friction, rate: float) -> None:
    points = [point for point in read(breaking(way, rate=rate)) if point.speed == 0.0]
    assert len(points) == 1
    assert points[0].direction == way
    assert points[0].torque == pytest.approx(friction.C0 + friction.C1, rel=5e-3)


def stated(effect: str, **values: float) -> EffectEntry:
    return EffectEntry(effect, ("A",), {"A": values}, "one_wave" if effect.startswith("position") else None)


@pytest.mark.parametrize("way", [1, -1])
def test_what_laws_of_the_arm_file_add_is_taken_off(way: int) -> None:
    """Of the same recordings as much less is read as the law says, where a joint slides and where it breaks away."""
    laws = stated("asymmetric_friction", coulomb=0.8, viscous=0.1), stated("quadratic_damping", coefficient=1.5)
    for run, speed in ((sliding(0.3 * way), 0.3), (breaking(way), 0.0)):
        (plain,) = (point for point in read(run) if (point.speed > 0.0) == (speed > 0.0))
        (bare,) = (point for point in read(run, 0.0, *laws) if (point.speed > 0.0) == (speed > 0.0))
        added = 0.8 * way + 0.1 * speed * way + 1.5 * speed**2
        assert plain.torque - bare.torque == pytest.approx(added, rel=0.01, abs=2e-3)


@pytest.mark.parametrize(
    ("effect", "apart"),
    [
        (stated("asymmetric_friction", coulomb=0.8, viscous=0.1), True),
        (stated("load_dependent_friction", ratio=0.2), True),
        (stated("presliding", stiffness=2000.0, damping=5.0), True),
        (stated("position_dependent_friction", sine=0.2, cosine=0.0, harmonic=2.0), False),
        (stated("frictional_lag", time=0.05), False),
    ],
)
def test_a_law_that_goes_with_friction_cannot_be(effect: EffectEntry, apart: bool) -> None:
    arm = replace(joint(), effects=(effect,))
    path, runs = path_of(arm), [condition(arm, sliding(0.3), 20.0)]
    assert Beyond(Residual(path, runs, ())).apart(values_of(path.entries), runs) == (apart,)


def test_a_fast_rise_is_no_reading() -> None:
    """At 20 N m/s the torque at which the joint leaves is anyone's guess."""
    assert [point for point in read(breaking(1, rate=20.0)) if point.speed == 0.0] == []


def test_a_staircase_is_one_trial_a_step() -> None:
    parts = [sliding(speed) for speed in (0.1, 0.4)]
    q = np.concatenate([parts[0].q, parts[0].q[-1] + parts[1].q])
    t = 0.005 * np.arange(len(q))
    both = Run("stairs", t, q, np.concatenate([part.tau for part in parts]))
    speeds = sorted(point.speed for point in read(both) if point.speed > 0.0)
    assert speeds == pytest.approx([0.1, 0.4], rel=0.02)


def test_no_readings_without_steady_motion() -> None:
    """Two sines of 0.5 and 1.3 Hz never keep a velocity for half a second; a resting joint has no friction to read."""
    run = recorded(rate=250.0, noise=1e-5)
    assert [point for point in read(run) if point.speed > 0.0] == []
    rng = np.random.default_rng(0)
    still = 1e-5 * rng.standard_normal((1000, 1))
    assert read(Run("still", 0.005 * np.arange(1000), still, np.zeros((1000, 1)))) == ()


def test_constant_acceleration_is_not_steady() -> None:
    t = 0.005 * np.arange(800)
    q = 0.5 * t**2
    run = Run("faster", t, q[:, None], np.full((800, 1), 6.0))
    found = [point for point in read(replace(run)) if point.speed > 0.0]
    # near the top speed the velocity changes by little within half a second: whatever is read there has inertia off
    assert all(point.torque == pytest.approx(6.0 - 1.0, rel=0.02) for point in found)
