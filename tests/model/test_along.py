"""The laws of a stage are composed in one order, whichever was found first, and undone where they must be."""

from itertools import permutations

import casadi as ca
import numpy as np
import pytest

from stribeck.effects.friction.presliding_maxwell_slip import LEVEL, NAMES
from stribeck.effects.registry import effect_named
from stribeck.model.effect import Along, FrictionEffect, Upon
from stribeck.model.forward import Forward
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath
from stribeck.model.values import Signals

from ..effects.bench import nominal_arm

DRIVE = (
    ("delay", {"time": 0.01}),
    ("torque_dead_zone", {"width": 0.5}),
    ("torque_saturation", {"limit": 2.0}),
    ("actuator_lag", {"time_constant": 0.01}),
    ("torque_ripple", {"sine": 0.3, "cosine": 0.1, "harmonic": 5.0}),
    ("torque_offset", {"offset": 0.4}),
    ("cogging", {"sine": 0.2, "cosine": -0.1, "harmonic": 4.0}),
)


def test_every_place_along_a_drive_is_taken() -> None:
    assert [effect_named(name).along for name, _ in DRIVE] == list(Along)  # type: ignore[attr-defined]


ORDERS = list(permutations(range(len(DRIVE))))[::211]  # as many as there are of four, each law at every place


@pytest.mark.parametrize("order", ORDERS)
def test_the_order_in_which_effects_are_placed_is_none(order: tuple[int, ...]) -> None:
    """The limit clips what the amplifier leaves, the lag trails that, the ripple turns with the shaft."""
    path = SignalPath(nominal_arm(), [Placed(effect_named(DRIVE[i][0]), 0, DRIVE[i][1]) for i in order])
    lag = order.index(3)
    trailing, position = 1.2, 0.3
    s = Signals(0.0, position, 0.0, 0.0, position, 0.0)
    x = ca.SX.sym("x", len(path.state_names))
    entries, u = [path.parameter(entry.key) for entry in path.entries], ca.SX.sym("u")
    law = ca.Function("law", [x, u, *entries], [path.actuated(0, u, s, x), *path.rates(lag, u, [s], [0.0], x)])
    pull = 0.2 * np.sin(4.0 * position) - 0.1 * np.cos(4.0 * position)
    wave = 0.3 * np.sin(5.0 * position) + 0.1 * np.cos(5.0 * position)
    for command, limited in ((7.0, 2.0), (2.3, 1.8)):
        torque, rate = law(trailing, command, *values_of(path.entries))
        assert float(torque) == pytest.approx(trailing * (1.0 + wave) + 0.4 + pull)
        assert float(rate) == pytest.approx((limited - trailing) / 0.01)


@pytest.mark.parametrize("law", ["one_pole", "two_poles", "magnitude_optimum"])
@pytest.mark.parametrize("first", [0, 1])
def test_a_recording_starts_with_what_the_amplifier_leaves(law: str, first: int) -> None:
    """Long after a step of the command its lag is over: none of what is cut off has come through."""
    drive = [Placed(effect_named("actuator_lag", law), 0, {"time_constant": 0.01})]
    drive.insert(first, Placed(effect_named("torque_saturation"), 0, {"limit": 2.0}))
    path = SignalPath(nominal_arm(), drive)
    forward, p = Forward(path), values_of(path.entries)
    states = forward.settled(np.zeros(2), np.zeros(2), [7.0, 0.0], p).full().ravel()
    rates, _ = forward.flow(0.0, np.concatenate([np.zeros(4), states]), np.zeros(2), [7.0, 0.0], p)
    assert states == pytest.approx(2.0)
    assert rates.full()[4:] == pytest.approx(0.0)


FRICTION = (
    ("asymmetric_friction", "", {"coulomb": 0.5, "viscous": 0.0}),
    ("position_dependent_friction", "one_wave", {"sine": 0.5, "cosine": 0.0, "harmonic": 3.0}),
    ("load_dependent_friction", "proportional", {"ratio": 0.2}),
    ("history", "warm_up", {"change": 0.4, "time": 5.0, "start": 0.0, "kept": 0.0}),
)


def test_every_kind_of_friction_law_is_tried() -> None:
    assert [effect_named(name, law).upon for name, law, _ in FRICTION] == list(Upon)  # type: ignore[attr-defined]


@pytest.mark.parametrize("order", list(permutations(range(len(FRICTION)))))
def test_friction_by_place_load_and_history_builds_up_in_one_order(order: tuple[int, ...]) -> None:
    path = SignalPath(nominal_arm(), [Placed(effect_named(FRICTION[i][0], FRICTION[i][1]), 0) for i in order])
    p = ca.vertcat(*[v for i in order for v in _values(FRICTION[i])])
    own = len(path.entries) - p.numel()
    x, speed, load, place = ca.SX.sym("x", len(path.state_names)), 0.7, 3.0, 0.4
    s = Signals(0.0, place, speed, 0.0, place, speed, load=load)
    level = ca.Function("level", [x, path.p], [path.level(0, speed, 1.0, s, x)])
    warmth = 0.5
    friction = path.arm.joints[0].friction
    curve = friction.C0 + friction.C1 * np.exp(-speed / friction.alpha) + 0.5
    expected = (curve * (1.0 + 0.5 * np.sin(3.0 * place)) + 0.2 * load) * (1.0 + 0.4 * warmth)
    values = ca.vertcat(*values_of(path.entries)[:own], p)
    assert float(level(warmth, values)) == pytest.approx(expected)


def _values(law: tuple[str, str, dict[str, float]]) -> list[float]:
    name, which, values = law
    return [values[parameter.name] for parameter in effect_named(name, which).parameters]


@pytest.mark.parametrize("steepness", [0.1, 0.5, 0.95])
def test_what_a_sensor_recorded_is_undone(steepness: float) -> None:
    """At every place of a turn, with velocity and acceleration, up to where two places are recorded alike."""
    wave, turn = {"sine": 0.8 * steepness / 8.0, "cosine": 0.6 * steepness / 8.0, "harmonic": 8.0}, np.pi / 4.0
    path = SignalPath(nominal_arm(), [Placed(effect_named("encoder_eccentricity", "one_wave"), 0, wave)])
    at = ca.SX.sym("at")
    slope, curve = path.sensed(0, at)
    both = ca.Function("both", [at, path.p], [path.true_position(0, path.measured(0, at)), slope, curve])
    p = values_of(path.entries)
    for place in np.linspace(0.0, turn, 101):
        found, first, second = (float(v) for v in both(place, p))
        assert found == pytest.approx(place, abs=1e-9)
        phase = 8.0 * place
        assert first == pytest.approx(1.0 + 8.0 * (wave["sine"] * np.cos(phase) - wave["cosine"] * np.sin(phase)))
        assert second == pytest.approx(-64.0 * (wave["sine"] * np.sin(phase) + wave["cosine"] * np.cos(phase)))


@pytest.mark.parametrize("law", ["one_wave", "two_waves"])
def test_whatever_sensor_an_arm_file_may_have_is_undone(law: str) -> None:
    """Waves of any shape up to where two places are recorded alike, at any rate, behind them a zero of the counter."""
    effect, rng = effect_named("encoder_eccentricity", law), np.random.default_rng(4)
    path = SignalPath(nominal_arm(), [Placed(effect, 0), Placed(effect_named("encoder_offset"), 0)])
    at = ca.SX.sym("at")
    there = ca.Function("there", [at, path.p], [path.true_position(0, path.measured(0, at))])
    names = [parameter.name for parameter in effect.parameters]
    own, tried = len(path.entries) - len(names) - 1, 0
    while tried < 100:
        rate = 10.0 ** rng.uniform(0.0, 6.0)
        waves = np.clip(rng.uniform(-0.95, 0.95, len(names) - 1) / rate, -0.3, 0.3)
        if effect.folds(dict(zip(names, [*waves, rate], strict=True))):
            continue
        tried += 1
        p = [*values_of(path.entries)[:own], *waves, rate, rng.uniform(-3.0, 3.0)]
        place = rng.uniform(-1.0, 1.0) + np.linspace(0.0, 2.0 * np.pi / rate, 51)
        found = there(place[None, :], np.tile(np.array(p)[:, None], (1, 51))).full().ravel()
        np.testing.assert_allclose(found, place, rtol=0.0, atol=1e-6 / rate + 1e-14)


def test_a_zero_of_the_counter_is_behind_its_disc() -> None:
    placed = [
        Placed(effect_named("encoder_offset"), 0, {"offset": 0.3}),
        Placed(effect_named("encoder_eccentricity", "one_wave"), 0, {"sine": 0.05, "cosine": 0.0, "harmonic": 3.0}),
    ]
    for order in (placed, placed[::-1]):
        path = SignalPath(nominal_arm(), order)
        seen = ca.Function("seen", [path.p], [path.measured(0, ca.SX(0.2))])
        assert float(seen(values_of(path.entries))) == pytest.approx(0.2 + 0.05 * np.sin(0.6) + 0.3)


def test_a_bristle_turned_back_unloads_along_its_spring() -> None:
    """Though the level is half as high that way: it was loaded to the other one."""
    effect = effect_named("presliding", "maxwell_slip")
    assert isinstance(effect, FrictionEffect)
    x = {name: ca.DM(2.0 * share) for name, share in zip(NAMES, LEVEL, strict=True)}
    p = {"stiffness": 800.0, "damping": 0.0}

    def torque(distance: float, level: float = 1.0) -> float:
        moved = effect.bristle_moved(ca.DM(level), ca.DM(distance), x, p)
        assert moved is not None
        return float(sum(moved.values()))

    assert torque(-1e-9) == pytest.approx(2.0 - 800e-9, abs=1e-12)
    assert torque(-1.0) == pytest.approx(-1.0)
    assert torque(1e-9) == pytest.approx(1.0)  # ahead it gives way at once
    assert torque(0.0) == pytest.approx(2.0)
