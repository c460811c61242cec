"""A bristle at rest holds what the torque leaves; in motion, what its own law says."""

import casadi as ca
import numpy as np
import pytest

from stribeck.arm import Arm, Friction, Joint
from stribeck.effects.friction import presliding_maxwell_slip as maxwell_slip
from stribeck.effects.registry import laws
from stribeck.identify.conditioning import Conditioned, condition
from stribeck.identify.residual import Residual
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath
from stribeck.model.values import Signals
from stribeck.run import Run

LEVEL, STIFFNESS, SD, STEP = 2.0, 2000.0, 1e-5, 0.002  # N m, N m/rad, rad, s
LAWS = ["lugre", "maxwell_slip", "elasto_plastic"]


def path_with(law: str, damping: float = 1.0) -> SignalPath:
    friction = Friction(LEVEL, 0.0, 0.0, 0.1)
    joint = Joint("A", "revolute", 0.3, 1.0, (0.0, 0.0), 0.01, 0.0, friction, friction, 10.0, SD)
    place = Placed(laws()["presliding", law], 0, {"stiffness": STIFFNESS, "damping": damping})
    return SignalPath(Arm("one joint", (0.0, 0.0), (joint,)), (place,))


def stopped(held: float) -> Conditioned:
    """A slide of two seconds; a joint that then stands still, where its bristle holds a torque, N m."""
    t = np.arange(0.0, 6.0, STEP)
    position = 0.1 * np.minimum(t, 2.0) + SD * np.random.default_rng(2).standard_normal(len(t))
    command = np.where(t < 2.0, 0.75 * LEVEL, held)
    return condition(
        path_with("lugre").arm, Run("slide and rest", t, position[:, None], command[:, None]), 15.0, np.array([SD])
    )


def residual_of(law: str, run: Conditioned, *, observe: bool = True) -> np.ndarray:
    path = path_with(law)
    return Residual(path, [run], (), observe=observe).stages(run, values_of(path.entries))["residual"][:, 0]


@pytest.mark.parametrize("law", LAWS)
def test_it_holds_what_is_left(law: str) -> None:
    """The joint sprang back by a way that no encoder saw, and its bristle lost most of its torque."""
    run = stopped(0.5)
    rest = run.time > 2.5
    blind, told = (residual_of(law, run, observe=observe)[rest] for observe in (False, True))
    assert np.mean(blind) < -0.5 * LEVEL
    assert abs(np.mean(told)) < 0.02 * LEVEL


@pytest.mark.parametrize("law", LAWS)
def test_it_holds_no_more_than_friction_can(law: str) -> None:
    run = stopped(3.0 * LEVEL)
    assert np.mean(residual_of(law, run)[run.time > 2.5]) == pytest.approx(2.0 * LEVEL, rel=0.05)


@pytest.mark.parametrize("law", LAWS)
def test_in_motion_its_law_holds(law: str) -> None:
    """Whatever the torque says: a wrong command bends no bristle that surely slides, but for how it begins."""
    t = np.arange(0.0, 4.0, STEP)
    position = 0.2 * np.sin(2.0 * np.pi * t)
    path = path_with(law)
    run = condition(path.arm, Run("a sine", t, position[:, None], np.full((len(t), 1), 5.0)), 15.0, np.array([1e-9]))
    assert np.mean(run.sliding) > 0.99
    told, own = (
        Residual(path, [run], (), observe=observe).states(run, values_of(path.entries)) for observe in (True, False)
    )
    begun = t > 0.02  # a way of ten times what it gives
    assert told[begun] == pytest.approx(own[begun], abs=1e-3 * LEVEL)


@pytest.mark.parametrize(("torque", "held"), [(0.3, 0.3), (-1.2, -1.2), (3.0 * LEVEL, LEVEL)])
@pytest.mark.parametrize("law", LAWS)
def test_it_begins_with_what_it_holds(law: str, torque: float, held: float) -> None:
    """An arm that creeps from the first sample on, as its controller pulls up: no noise, and no slide yet."""
    t = np.arange(0.0, 4.0, STEP)
    position, command = np.where(t < 0.5, 1e-5 * t, 1e-5 * t + 0.2 * (t - 0.5) ** 2), np.full((len(t), 1), torque)
    path = path_with(law)
    run = condition(path.arm, Run("a start", t, position[:, None], command), 15.0, np.array([1e-9]))
    states = Residual(path, [run], ()).states(run, values_of(path.entries))[0, : path.x.numel()]
    assert np.sum(states) == pytest.approx(held, abs=1e-3)
    if law == "maxwell_slip":  # what gives way first is at its limit, the others have gone as far
        limits = LEVEL * np.array(maxwell_slip.LEVEL)
        way = states / (STIFFNESS * np.array(maxwell_slip.STIFFNESS))
        at_limit = np.abs(states) > limits - 1e-9
        assert np.all(np.abs(states) <= limits + 1e-9)
        assert np.all(np.diff(at_limit.astype(int)) <= 0)
        assert np.ptp(way[~at_limit]) < 1e-9 if np.sum(~at_limit) > 1 else True
        assert np.all(np.abs(way[at_limit]) <= np.max(np.abs(way)) + 1e-9)


@pytest.mark.parametrize("law", LAWS)
def test_one_that_slides_already_begins_bent_its_way(law: str) -> None:
    """What damps a bristle while it bends is no part of what it holds then."""
    t = np.arange(0.0, 4.0, STEP)
    position, path = 0.2 * np.sin(2.0 * np.pi * t), path_with(law, damping=5.0)
    torque = LEVEL * np.sign(np.cos(2.0 * np.pi * t)) - 0.01 * position * (2.0 * np.pi) ** 2
    run = condition(path.arm, Run("a sine", t, position[:, None], torque[:, None]), 15.0, np.array([1e-9]))
    states = Residual(path, [run], ()).states(run, values_of(path.entries))[0, : path.x.numel()]
    assert np.sum(states) == pytest.approx(LEVEL, rel=0.1)


@pytest.mark.parametrize("law", LAWS)
def test_derivatives(law: str) -> None:
    """The correction goes by the whole residual, and so by every parameter."""
    path, run = path_with(law), stopped(0.5)
    p = values_of(path.entries)
    residual = Residual(path, [run], [i for i, entry in enumerate(path.entries) if entry.sd > 0.0])
    jacobian = residual(p)[1]
    for k, i in enumerate(residual.columns):
        step = 1e-5 * max(abs(p[i]), 1e-3)
        up, down = (residual.value(p + side * step * np.eye(len(p))[i]) for side in (1.0, -1.0))
        assert jacobian[..., k] == pytest.approx((up - down) / (2.0 * step), rel=1e-3, abs=2e-3), path.entries[i].key


def test_noise_at_rest_lowers_the_level_of_no_law() -> None:
    """Asked for at rest, Tustin's constants of the arm and those of an effect are the same friction."""
    friction, with_it = Friction(LEVEL, 0.0, 0.0, 0.1), Friction(LEVEL, 1.5, 0.0, 0.06)
    effect = Placed(laws()["negative_damping", "exponential"], 0, {"amount": 1.5, "velocity": 0.06})
    levels = []
    for own, placed in ((friction, (effect,)), (with_it, ())):
        joint = Joint("A", "revolute", 0.3, 1.0, (0.0, 0.0), 0.01, 0.0, own, own, 10.0, SD)
        path = SignalPath(Arm("one joint", (0.0, 0.0), (joint,)), placed)
        signals = Signals(0.0, 0.0, 0.03, 0.0, 0.0, 0.03)
        told = ca.Function("level", [path.p], [path.level(0, 0.0, 1.0, signals, path.x)])
        levels.append(float(told(values_of(path.entries))))
    assert levels == pytest.approx([LEVEL + 1.5] * 2)
