"""The law of every effect: nothing at its null value, and exact derivatives, along signals of the independent plant."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stribeck.arm import EffectEntry
from stribeck.effects.placing import placed_effects, vanishes
from stribeck.effects.registry import laws, registry
from stribeck.identify.conditioning import Conditioned
from stribeck.identify.residual import Residual
from stribeck.model.effect import Effect, TransmissionEffect
from stribeck.model.forward import Forward
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath
from stribeck.model.scale import Scale
from stribeck.model.values import Parameter, Signals
from stribeck.simulate.engine import path_of

from .bench import arm_for, clean, everywhere, nominal_arm, smooth, starts

EFFECTS = [pytest.param(effect, id=effect.label) for effect in laws().values()]


def _exact(effect: Effect) -> bool:
    return all(parameter.lower <= parameter.null <= parameter.upper for parameter in effect.parameters)


EXACT = [case for case in EFFECTS if _exact(case.values[0])]
IN_A_LIMIT = [case for case in EFFECTS if not _exact(case.values[0])]
STIFF = {"N m/rad": 1e4, "N m": 1e5}  # stand for infinite: a joint of the bench at 50 Hz, 1000 times its torque
DAMPED = 30.0  # N m s/rad: what is stiff does not ring


# A bristle of 1e4 N m/rad gives way over half a milliradian at each reversal; a stiff joint swings once when it starts
LEFT = {"presliding": 0.05, "joint_flexibility": 0.02, "base_flexibility": 0.02, "backlash": 0.07}


def near_null(effect: Effect, parameter: Parameter) -> float:
    """The null value, or one as near as the bounds allow."""
    if isinstance(effect, TransmissionEffect) and parameter.name == "damping":
        return DAMPED
    value = STIFF.get(parameter.unit, 1e6) if np.isinf(parameter.null) else parameter.null
    return float(np.clip(value, parameter.lower, parameter.upper))


def at_null(effect: Effect) -> list[Placed]:
    values = {parameter.name: near_null(effect, parameter) for parameter in effect.parameters}
    return [Placed(effect, j, values) for j in effect.sites(2)]


def changes(effect: Effect, placed: list[Placed], runs: Sequence[Conditioned]) -> np.ndarray:
    """What placed effects change of the residual, rms (n,), N m: by their law, not by what their observer follows."""
    path, plain = SignalPath(arm_for(effect), placed), SignalPath(arm_for(effect))
    found, expected = (Residual(one, runs, (), observe=False)(values_of(one.entries))[0] for one in (path, plain))
    return np.asarray(np.sqrt(np.mean((found - expected) ** 2, axis=0)))


@pytest.mark.parametrize("effect", EXACT)
def test_cut_at_null(effect: Effect) -> None:
    assert changes(effect, at_null(effect), clean().fit) == pytest.approx([0.0, 0.0], abs=1e-9)


@pytest.mark.parametrize("effect", IN_A_LIMIT)
def test_cut_in_the_limit(effect: Effect) -> None:
    """Near a null that is a limit: what is left of the effect along a smooth motion, in parts of its torque."""
    path = SignalPath(arm_for(effect))
    torque = np.std(Residual(path, [smooth()], ())(values_of(path.entries))[0], axis=0)
    assert (changes(effect, at_null(effect), [smooth()]) < LEFT.get(effect.name, 0.005) * torque).all()


@pytest.mark.parametrize("effect", EXACT)
def test_forward_at_null(effect: Effect) -> None:
    """Random states: at its null the effect changes no acceleration and no break-away margin."""
    path, plain = SignalPath(arm_for(effect), at_null(effect)), SignalPath(arm_for(effect))
    forward, nominal = Forward(path), Forward(plain)
    rng = np.random.default_rng(0)
    for modes in ([1.0, -1.0], [-1.0, 0.0], [0.0, 1.0], [0.0, 0.0]):
        q, u = rng.normal(size=2), 10.0 * rng.normal(size=2)
        dq = np.array(modes) * np.abs(rng.normal(size=2))
        state = 0.3 * rng.random(path.x.numel())
        rates, margins = forward.flow(0.0, [*q, *dq, *state], modes, u, values_of(path.entries))
        expected, left = nominal.flow(0.0, [*q, *dq], modes, u, values_of(plain.entries))
        assert rates.full()[:4] == pytest.approx(expected.full(), rel=1e-9, abs=1e-9)
        assert margins.full() == pytest.approx(left.full(), rel=1e-9, abs=1e-9)


def driven(path: SignalPath) -> np.ndarray:
    """Position and velocity (4,) after both joints have been driven forward for 0.2 s."""
    forward, p, modes, command = Forward(path), values_of(path.entries), np.ones(2), np.array([40.0, 12.0])
    q, dq = [0.1, 0.2], [0.5, 0.5]
    start = np.concatenate([q, dq, forward.settled(q, dq, command, p).full().ravel()])

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        return np.asarray(forward.flow(t, y, modes, command, p)[0]).ravel()

    def slope(t: float, y: np.ndarray) -> np.ndarray:
        return np.asarray(forward.jacobian(t, y, modes, command, p))[:, : len(y)]

    solved = solve_ivp(rates, (0.0, 0.2), start, method="Radau", jac=slope, rtol=1e-6, atol=1e-8)
    assert solved.success
    return np.asarray(solved.y[:4, -1])


@pytest.mark.parametrize("effect", IN_A_LIMIT)
def test_forward_in_the_limit(effect: Effect) -> None:
    """With the effect all but gone the arm moves as the nominal one does."""
    found, expected = (driven(SignalPath(arm_for(effect), placed)) for placed in (at_null(effect), ()))
    assert (expected[:2] > 0.25).all()
    assert found == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("effect", EFFECTS)
def test_engine_leaves_out_what_vanishes(effect: Effect) -> None:
    arm = nominal_arm()
    joints = tuple(arm.names[j] for j in effect.sites(2))
    silent = replace(arm, effects=(EffectEntry(effect.name, joints, law=effect.law or None),))
    assert len(placed_effects(silent)) == len(joints)
    assert path_of(silent).placed == ()
    for j in effect.sites(2):
        for trial in starts(effect, j):
            assert not vanishes(Placed(effect, j, trial))


@pytest.mark.parametrize("part", [pytest.param(False, marks=pytest.mark.slow), True], ids=["all", "part"])
@pytest.mark.parametrize("effect", EFFECTS)
def test_derivatives(effect: Effect, part: bool) -> None:
    """The residual's Jacobian, states and delays included, against central differences: 1e-4 of each column.

    The effect's own columns, and all nominal ones or a quarter, other ones for each effect; all in a transmission.
    """
    placed = everywhere(effect)
    path = SignalPath(arm_for(effect), placed)
    residual, bare = Residual(path, clean().fit), Residual(path, clean().fit, ())
    p = values_of(path.entries)
    exact = residual(p)[1]
    assert np.isfinite(exact).all()
    own = 0
    part = part and not isinstance(effect, TransmissionEffect)  # whose state hangs on every value of the arm
    turn = [law.label for law in laws().values()].index(effect.label)
    for column, i in enumerate(residual.columns):
        if part and not isinstance(path.entries[i].owner, int) and (column + turn) % 4:
            continue
        step = 1e-6 * max(abs(p[i]), 1e-3)
        ahead, behind = p.copy(), p.copy()
        ahead[i] += step
        behind[i] -= step
        difference = (bare(ahead)[0] - bare(behind)[0]) / (2 * step)
        size = float(np.abs(difference).max())
        entry = path.entries[i]
        own += isinstance(entry.owner, int) and size > 0.0
        assert np.abs(exact[:, :, column] - difference).max() <= 1e-4 * size + 1e-10 / step, entry.key
    assert own == 0 if effect.direct else own >= len(effect.parameters)


def test_play_is_damped_as_it_says() -> None:
    """The damper comes in over 0.3 of the gap, by the equation, the parameter's words and the law itself."""
    effect, p = registry()["backlash"], {"gap": 0.02, "stiffness": 3000.0, "damping": 3.0}
    assert r"d\,(\dot\theta - \dot q)\,\frac{|x|}{|x| + 0.3\,\Delta}\ [0\ \text{where that pulls}]" in effect.equation
    assert "pressed in far beyond 0.3 gap" in effect.parameters[2].description
    for x, rate in itertools.product((-0.006, -1e-4, 1e-4, 0.006), (-0.5, 0.0, 0.5)):
        push = 3000.0 * x + 3.0 * rate * abs(x) / (abs(x) + 0.3 * 0.02)
        found = float(effect.transmitted(x + math.copysign(0.01, x), rate, p))
        assert found == pytest.approx(push if push * x > 0.0 else 0.0, rel=1e-4)
    assert float(effect.transmitted(0.0099, 0.5, p)) == 0.0


@pytest.mark.parametrize("damping", [10.0, 100.0])
def test_stiff_contact_does_not_throw_the_link(damping: float) -> None:
    """A contact at 150 Hz and more, driven by a noisy record: large steps across its edge stay bounded."""
    values = {"gap": 0.002, "stiffness": 1e5, "damping": damping}
    path = SignalPath(nominal_arm(), [Placed(registry()["backlash"], j, values) for j in range(2)])
    r = Residual(path, clean().fit, ())(values_of(path.entries))[0]
    torque = np.concatenate([run.command for run in clean().fit])
    assert np.sqrt(np.mean(r**2)) < np.sqrt(np.mean(torque**2))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_stop_with_a_damper_pushes_and_never_pulls(side: float) -> None:
    stop = laws()["contact", "linear"]
    p = {"stiffness": 20.0 * side, "position": 0.3 * side, "damping": 2.0}

    def push(depth: float, rate: float) -> float:
        motion: Any = SimpleNamespace(link_position=side * (0.3 + depth), link_velocity=side * rate)
        return side * float(stop.torque(motion, {}, p))

    assert push(0.1, 0.5) == pytest.approx(20.0 * 0.1 + 2.0 * 0.5)
    assert push(0.1, -0.5) == pytest.approx(20.0 * 0.1 - 2.0 * 0.5)
    assert push(0.1, -5.0) == push(-0.1, 5.0) == 0.0


def aged(law: str, trial: dict[str, float], seconds: float, slide: float, start: Sequence[float]) -> Sequence[float]:
    """States of a law of dwell time after so long at one speed."""
    effect = laws()["dwell_time", law]

    def rate(_: float, x: Sequence[float]) -> list[float]:
        rates = effect.derivatives(SimpleNamespace(slide=slide), dict(zip(effect.states, x, strict=True)), trial)
        return [float(rates[state]) for state in effect.states]

    ends: Sequence[float] = solve_ivp(rate, (0.0, seconds), start, method="LSODA", rtol=1e-8, atol=1e-10).y[:, -1]
    return ends


def test_frozen_dwell_keeps_what_a_rest_has_left() -> None:
    """A rest of 1 s leaves 1 / (1 + T) of the rise, no slide takes it back, and the next rest starts anew."""
    trial, half = {"rise": 1.0, "time": 0.5}, 0.5
    rested = aged("frozen", trial, 1.0, 0.0, [0.0, 0.0])
    assert rested[1] == pytest.approx(1.0 / (1.0 + half), abs=0.01)
    slid = aged("frozen", trial, 2.0, 0.5, rested)
    assert slid[1] == pytest.approx(rested[1], abs=1e-3)
    again = aged("frozen", trial, 0.1, 0.0, slid)
    assert again[1] == pytest.approx(0.1 / (0.1 + half), abs=0.02)


@pytest.mark.parametrize("slide", [0.02, 0.5])
def test_a_contact_that_ages_at_rest_loses_it_by_distance_alone(slide: float) -> None:
    trial = {"rise": 1.0, "time": 0.5, "distance": 0.03}
    (rested,) = aged("at_rest", trial, 0.8, 0.0, [0.0])
    assert rested == pytest.approx(1.0 - np.exp(-0.8 / 0.5))
    (slid,) = aged("at_rest", trial, 0.05 / slide, slide, [rested])
    assert slid == pytest.approx(rested * np.exp(-0.05 / 0.03), rel=1e-3)


@pytest.mark.parametrize(
    ("law", "state", "grown"),
    [
        ("break_away", "age", 0.7),
        ("ageing", "age", 0.7),
        ("at_rest", "age", 0.7),
        ("frozen", "rest", 0.7),
        ("frozen", "grown", 0.7 / 1.2),
    ],
)
def test_a_recording_starts_as_old_as_the_rest_before_it(law: str, state: str, grown: float) -> None:
    """Which no record shows but by its first break-away; what goes on in a recording has just slid."""
    effect, trial = laws()["dwell_time", law], {"rise": 1.0, "time": 0.5, "distance": 0.01, "start": 0.7}
    starts = [effect.initial(Signals(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, lead=lead), trial) for lead in (0.0, 3.0)]
    assert [float(start[state]) for start in starts] == pytest.approx([grown, 0.0])


@pytest.mark.parametrize("speed", [0.4, -1.5])
def test_heat_comes_of_all_of_frictions_power(speed: float) -> None:
    """The viscous part's too, and that of friction as the warmth has made it."""
    arm, trial = nominal_arm(), {"change": -0.02, "time": 6.0, "start": 0.0, "kept": 0.0}
    path = SignalPath(arm, [Placed(laws()["history", "heat"], 0, trial)])
    motion = [Signals(0.0, 0.3, v, 0.0, 0.3, v) for v in (speed, *(0.0,) * (arm.n - 1))]
    rate = ca.Function("rate", [path.x, path.p], path.rates(0, 0.0, motion, [0.0] * arm.n, path.x))
    side = arm.joints[0].friction if speed > 0.0 else arm.joints[0].backward
    level = side.C0 + side.C1 * math.exp(-abs(speed) / side.alpha) + side.C2 * abs(speed)
    for heat in (0.0, 10.0):
        power = level * (1.0 - 0.02 * heat) * abs(speed)
        assert float(rate(heat, values_of(path.entries))) == pytest.approx((power - heat) / 6.0)


def test_a_tilt_turns_gravity_and_makes_no_more_of_it() -> None:
    tilt = laws()["gravity_tilt", ""]
    scale = Scale(torque=10.0, friction=2.0, speed=1.5, travel=2.0, inertia=0.1, sample_time=0.01, gravity=(9.81, 0.0))
    assert tilt.plausible({"x": -0.21, "y": 2.02}, scale)
    assert tilt.plausible({"x": 0.0, "y": -1.22}, scale)  # to first order
    assert tilt.plausible({"x": -19.62, "y": 0.0}, scale)  # the arm file has it upside down
    assert not tilt.plausible({"x": 0.78, "y": 0.0}, scale)
    assert tilt.plausible({"x": 9.81, "y": 0.0}, replace(scale, gravity=(0.0, 0.0)))  # the file leaves it out


def test_heat_that_would_have_no_end_is_not_plausible() -> None:
    effect = laws()["history", "heat"]
    scale = Scale(torque=10.0, friction=2.0, speed=1.5, travel=2.0, inertia=0.1, sample_time=0.01, length=0.3)
    assert effect.plausible({"change": 0.2}, scale)
    assert effect.plausible({"change": -2.0}, scale)
    assert not effect.plausible({"change": 0.3}, scale)
