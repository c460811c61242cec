"""Sampled loops whose motion repeats after whole samples: their fixed points and multipliers."""

import math
from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import EffectEntry
from stribeck.loop.exact.ending import answers
from stribeck.loop.exact.repeat import DIES, _Motion, repeated
from stribeck.loop.exact.rounds import NONE, Rounds
from stribeck.loop.exact.settle import settle, settle_from
from stribeck.loop.exact.shooting import shoot
from stribeck.loop.exact.starts import starts
from stribeck.loop.exact.strobe import INTEGRAL

from .conftest import A, one_joint

STEP = 0.0125
LOOPS = {
    "delay": {"ratio": 1.265, "at_zero": "zero", "zeta": 0.17, "delay_samples": 2},
    "set-valued": {"ratio": 1.3, "zeta": 0.5},
    "lag": {"ratio": 1.5, "at_zero": "hold", "zeta": 0.15, "actuator_lag": 0.005},
}
THREE = {"ratio": 1.6, "at_zero": "error_sign", "zeta": 0.2, "actuator_lag": 0.01, "delay_samples": 1}  # rounds


@pytest.mark.parametrize("settings", [*LOOPS.values(), THREE])
def test_it_repeats_to_the_last_digit(joint_a, loop_of, settings):
    rounds = Rounds(joint_a, loop_of(sample_time=STEP, **settings))
    found = repeated(rounds, settle_from(rounds, starts(rounds)["own"]))
    samples = round(found.repeat / STEP)
    assert samples > 0, found.status
    after = rounds.run(found.place, NONE, duration=(samples + 0.5) * STEP, quiet=False).place
    for part in (rounds.layout.state, rounds.layout.memory):  # position and velocity; the last position
        assert after.values[part][:2] == pytest.approx(found.place.values[part][:2], abs=1e-8)
    assert after.past[0] == pytest.approx(found.place.past[0], abs=1e-6)


@pytest.mark.parametrize("name", LOOPS)
def test_the_multiplier_is_how_fast_the_motion_settles(joint_a, loop_of, name):
    """Against plain simulation: what is left of the way to the cycle shrinks by it from one repeat to the next."""
    rounds = Rounds(joint_a, loop_of(sample_time=STEP, **LOOPS[name]))
    found = repeated(rounds, settle_from(rounds, starts(rounds)["own"]))
    lead = max(abs(root) for root in found.multipliers)
    values = found.place.values.copy()
    values[rounds.layout.state][1] *= 1.0 + 1e-4
    places = [replace(found.place, values=values), found.place]
    ways = []
    for _ in range(6):
        places = [rounds.run(p, NONE, duration=found.repeat + 0.5 * STEP, quiet=False).place for p in places]
        ways.append(abs(np.subtract(*(place.values[rounds.layout.state][1] for place in places))))
    assert lead < 1.0
    if lead > 0.1:
        assert ways[-1] / ways[-2] == pytest.approx(lead, rel=0.01)
    else:
        assert ways[-1] < 1e-9


def test_fast_sampling_has_the_multipliers_of_the_continuous_loop(coulomb, loop_of):
    """rho^2 a round, with rho what is left of half a swing."""
    zeta = 0.2
    found = shoot(coulomb, loop_of(1.3, zeta=zeta, sample_time=0.001))["A"]
    rho = math.exp(-math.pi * zeta / math.sqrt(1.0 - zeta**2))
    assert max(abs(root) for root in found.multipliers) == pytest.approx(rho**2, rel=0.05)


def test_averages_and_the_fixed_point_agree(joint_a, loop_of):
    loop = loop_of(1.3, zeta=0.5, sample_time=STEP)
    exact, mean = shoot(joint_a, loop)["A"], settle(joint_a, loop)["A"]
    assert "repeats every" in exact.status
    assert (exact.amplitude, exact.period) == pytest.approx((mean.amplitude, mean.period), rel=1e-3)
    assert exact.multipliers
    assert not mean.multipliers


@pytest.mark.parametrize(
    ("settings", "lead"), [({"zeta": 0.4564}, 0.80), ({"ratio": 0.9, "at_zero": "zero"}, 1.64)], ids=["dies", "grows"]
)
def test_hunting_has_the_multiplier_with_which_its_integral_forgets(joint_a, loop_of, settings, lead):
    """A joint that sticks lets go at a sample: between two of them a disturbance goes by it, as long as it is tiny."""
    rounds = Rounds(joint_a, loop_of(ki=60.0, sample_time=STEP, **settings))
    found = repeated(rounds, settle_from(rounds, starts(rounds)["own"]))
    answer = answers(rounds, found)["A"]
    assert max(abs(root) for root in found.multipliers) == pytest.approx(lead, rel=0.01)
    assert (answer.verdict, answer.stable) == ("hunting", lead < 1.0)
    values = found.place.values.copy()
    values[rounds.layout.memory][INTEGRAL] += 1e-9
    places, ways = [replace(found.place, values=values), found.place], []
    for _ in range(6):
        places = [rounds.run(p, NONE, duration=answer.period + 0.5 * STEP, quiet=False).place for p in places]
        ways.append(abs(np.subtract(*(place.values[rounds.layout.memory][INTEGRAL] for place in places))))
    assert (ways[5] / ways[0]) ** 0.2 == pytest.approx(lead, rel=0.03)


@pytest.mark.long
def test_hunting_whose_differences_hang_on_their_step_has_no_multipliers(joint_a, loop_of):
    """Some of its rounds let go right at a sample."""
    found = shoot(joint_a, loop_of(zeta=0.4564, ki=30.0, sample_time=STEP))["A"]
    assert (found.verdict, found.multipliers, found.stable) == ("hunting", (), None)


@pytest.mark.slow
def test_hunting_under_a_compensation(joint_a, loop_of):
    found = shoot(joint_a, loop_of(0.9, "zero", ki=30.0, sample_time=STEP))["A"]
    assert found.verdict == "hunting"
    assert found.amplitude == pytest.approx(0.091, rel=0.01)
    assert found.multipliers


def test_a_period_that_the_least_step_sets_is_told(joint_a, loop_of):
    """Over-damped, the velocity falls to nothing before the law's rule for rest turns the joint round."""
    rounds = Rounds(joint_a, loop_of(1.8, "error_sign", zeta=1.0, sample_time=STEP))
    found = repeated(rounds, settle_from(rounds, rounds.start({})))
    assert found.status.startswith("repeats every")
    assert found.status.endswith(DIES)
    assert max(abs(root) for root in found.multipliers) < 1e-3
    held = shoot(joint_a, loop_of(1.3, "zero", zeta=1.0, sample_time=STEP))["A"]
    assert held.verdict == "rest"


def test_the_period_does_not_hang_on_how_it_is_integrated(joint_a, loop_of):
    """Where the velocity dies out before it turns, rounding would set the period, but for the least step."""
    loop = loop_of(1.8, "error_sign", zeta=1.0, sample_time=STEP)
    periods = []
    for rtol in (1e-8, 1e-10, 1e-12):
        rounds = Rounds(joint_a, loop, rtol=rtol)
        place = rounds.run(rounds.start({}), NONE, duration=100.0, quiet=False).place
        turns = rounds.run(place, NONE, most=50, duration=300.0, quiet=False).turns
        periods.append(np.diff(turns["time"]).mean())
    assert periods == pytest.approx([periods[0]] * 3, rel=1e-6)


def test_a_stretch_that_ends_quiet_goes_on_as_if_it_had_not(joint_a, loop_of):
    """The sample at which it stops is taken once, not twice: else the velocity would seem to be zero there."""
    rounds = Rounds(joint_a, loop_of(1.8, "error_sign", zeta=1.0, sample_time=STEP))
    quiet = rounds.run(rounds.start({}), NONE, duration=60.0)
    assert quiet.why == "quiet"
    on = rounds.run(quiet.place, NONE, duration=60.0 - quiet.place.time, quiet=False).place
    whole = rounds.run(rounds.start({}), NONE, duration=60.0, quiet=False).place
    assert on.values[rounds.layout.state] == pytest.approx(whole.values[rounds.layout.state], abs=1e-9)


def test_an_encoder_with_steps_is_left_as_it_is(joint_a, loop_of):
    loop = loop_of(1.3, zeta=0.5, sample_time=STEP)
    coarse = replace(loop, joints=(replace(loop.joints[0], encoder_resolution=1e-5),))
    rounds = Rounds(joint_a, coarse)
    ending = settle_from(rounds, rounds.start({}))
    assert repeated(rounds, ending) is ending


@pytest.mark.long
def test_a_record_that_is_late_is_a_late_command(loop_of):
    """What the controller sees late it answers late: the same cycle, and the same multipliers."""
    loop, found = loop_of(ratio=1.265, at_zero="zero", zeta=0.17, sample_time=STEP), []
    for effect in ("delay", "time_shift"):
        stated = EffectEntry(effect, ("A",), {"A": {"time": 0.025}})
        found.append(shoot(replace(one_joint(A), effects=(stated,)), loop)["A"])
    for name in ("verdict", "amplitude", "period", "multipliers"):
        assert getattr(found[0], name) == getattr(found[1], name), name
    assert found[0].multipliers


def test_a_stretch_in_which_all_stands_has_a_place(joint_a, loop_of):
    """As of a joint that sticks for longer than the rounds before took."""
    standing = Rounds(joint_a, loop_of(sample_time=0.0125))
    place = standing.start({"A": 0.0})
    assert _Motion(standing, place, 0.1, 1.0).place == place
