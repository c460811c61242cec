"""Cycles followed along k, Kp and the delay; folds; sampled loops; bad input."""

import math
from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import EffectEntry
from stribeck.effects.undriven import undriven
from stribeck.errors import InputError
from stribeck.loop.analyse import analyse_loop
from stribeck.loop.exact.branch import continue_in
from stribeck.loop.exact.settle import settle
from stribeck.loop.exact.shooting import shoot
from stribeck.loop.surroundings import Grid
from stribeck.simulate import Compensation, JointLoop, Loop, Reference


def test_branch_in_k_follows_the_coth_law(coulomb, loop_of):
    ratios = np.linspace(1.05, 1.6, 5)
    found = continue_in(coulomb, loop_of(1.0, zeta=0.4), "A", "k", ratios)
    law = (ratios - 1.0) * 5.0 / 30.0 / math.tanh(math.pi * 0.4 / (2.0 * math.sqrt(1.0 - 0.16)))
    assert [cycle.amplitude for cycle in found] == pytest.approx(law.tolist(), rel=1e-7)
    assert all(cycle.stable for cycle in found)


def test_branch_ends_where_the_cycle_does(coulomb, loop_of):
    """Down through the critical ratio of the rule that is zero at rest: a cycle of a finite size is lost."""
    rho = math.exp(-math.pi * 0.3 / math.sqrt(1.0 - 0.09))
    critical = 2.0 / (1.0 + rho)
    found = continue_in(coulomb, loop_of(1.0, "zero", zeta=0.3), "A", "k", [critical * s for s in (1.1, 1.01, 0.99)])
    assert [cycle.verdict for cycle in found] == ["sliding_cycle", "sliding_cycle", "rest"]
    assert found[1].amplitude > 0.01


def test_branch_in_kp_is_that_of_single_shots(joint_a, loop_of):
    loop = loop_of(0.9, "zero", ki=30.0)
    gains = (25.0, 30.0, 40.0)
    found = continue_in(joint_a, loop, "A", "kp", gains)
    assert all(cycle.verdict == "hunting" for cycle in found)
    assert found[1].amplitude == pytest.approx(shoot(joint_a, loop)["A"].amplitude, rel=1e-8)


def test_branch_in_delay(joint_a, loop_of):
    found = continue_in(joint_a, loop_of(1.3, "set_valued", zeta=0.5, sample_time=0.0125), "A", "delay", (0, 1, 2))
    sizes = [cycle.amplitude for cycle in found]
    assert sizes == sorted(sizes)
    assert sizes[0] == pytest.approx(0.0757, rel=0.01)  # the continuous loop's, nearly


def test_where_the_large_start_is_lost_the_own_one_answers(joint_a, loop_of):
    """Adaptation at a low Kp: from far out it grows without bound, from the loop's own start it comes to rest."""
    loop = loop_of(0.7, "error_sign", kind="adaptive", kp=5.0, error=0.3, sample_time=0.0125)
    single = shoot(joint_a, loop)["A"]
    assert (single.verdict, single.basin["large"]) == ("rest", "unbounded")
    (found,) = continue_in(joint_a, loop, "A", "kp", [5.0])
    assert (found.verdict, found.steady_error) == ("rest", single.steady_error)


@pytest.mark.parametrize(
    ("parameter", "values", "text"),
    [
        ("k", (-0.1,), "k is out of range: found -0.1"),
        ("kp", (0.0,), "kp is out of range: found 0"),
        ("kp", (float("nan"),), "kp is out of range: found nan"),
        ("delay", (1,), "a delay in samples needs a sampled controller"),
    ],
)
def test_values_out_of_range_are_one_line(joint_a, loop_of, parameter, values, text):
    with pytest.raises(InputError) as caught:
        continue_in(joint_a, loop_of(1.0), "A", parameter, values)
    assert str(caught.value).startswith(text)


def test_a_driven_loop_has_no_cycle_of_its_own(joint_a):
    entry = JointLoop("A", 30.0, Reference("sine", amplitude=0.1, frequency=1.0))
    for method in (shoot, settle):
        with pytest.raises(InputError, match="what a loop does of itself"):
            method(joint_a, Loop(0.0, 10.0, (entry,)))


@pytest.mark.parametrize("sample_time", [0.0, 0.0125])
def test_an_arm_that_is_shaken_has_no_cycle_of_its_own(joint_a, loop_of, sample_time):
    wave = {"A": {"sine": 12.0, "cosine": 0.0, "frequency": 2.0}}
    shaken = replace(joint_a.arm, effects=(EffectEntry("input_disturbance", ("A",), wave),))
    for method in (shoot, settle):
        with pytest.raises(InputError, match="an effect drives it in time: found input_disturbance/one_wave"):
            method(shaken, loop_of(sample_time=sample_time))


def test_what_drives_an_arm_in_time_is_left_out_with_a_warning(joint_a):
    bristles = EffectEntry("presliding", ("A",), {"A": {"stiffness": 1e4, "damping": 10.0}})
    wave = EffectEntry("input_disturbance", ("A",), {"A": {"sine": 12.0, "cosine": 0.0, "frequency": 2.0}})
    alone, warnings = undriven(replace(joint_a.arm, effects=(wave, bristles)))
    assert alone == replace(joint_a.arm, effects=(bristles,))
    assert warnings == ("A: input_disturbance drives the arm in time, at its own phase: left out here",)
    assert undriven(joint_a.arm) == (joint_a.arm, ())


@pytest.mark.long
def test_an_analysis_tells_what_it_left_out(joint_a, loop_of):
    wave = EffectEntry("input_disturbance", ("A",), {"A": {"sine": 12.0, "cosine": 0.0, "frequency": 2.0}})
    given, no_map = loop_of(error=0.1), Grid(wanted=False)
    found = analyse_loop(replace(joint_a.arm, effects=(wave,)), given, grid=no_map)
    assert found.joints[0].notes[0] == undriven(replace(joint_a.arm, effects=(wave,)))[1][0]
    assert found.joints[0].cycle == analyse_loop(joint_a.arm, given, grid=no_map).joints[0].cycle


def test_steps_end_in_regulation(joint_a, loop_of):
    steps = Reference("steps", times=(0.0, 1.0), values=(0.2, 0.5))
    law = Compensation("feedback", 1.3, "set_valued")
    entry = JointLoop("A", 30.0, steps, kv=math.sqrt(30.0), compensation=law)
    found = shoot(joint_a, Loop(0.0, 10.0, (entry,)))["A"]
    assert found.amplitude == pytest.approx(shoot(joint_a, loop_of(1.3, zeta=0.5))["A"].amplitude, rel=1e-6)


def test_gains_that_make_no_stable_loop_and_delays_over_the_period_are_labelled(joint_a, loop_of):
    unstable = loop_of(sample_time=0.0125, kp=5000.0)
    late = loop_of(sample_time=0.0125, delay_samples=200)
    for loop in (unstable, late):
        for method in (shoot, settle):
            assert method(joint_a, loop)["A"].verdict == "unbounded"
