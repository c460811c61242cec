"""The loop's own start where its reference steps: the place at the last step, with all that came before."""

from dataclasses import replace

import pytest

from stribeck.arm import Friction
from stribeck.loop.analyse import _shown
from stribeck.loop.exact.rounds import NONE, Rounds
from stribeck.loop.exact.settle import settle
from stribeck.loop.exact.shooting import shoot
from stribeck.loop.exact.starts import own_start, starts
from stribeck.loop.linear.operating import pose
from stribeck.loop.maps.cells import fits
from stribeck.simulate import JointLoop, Loop, Reference, simulate_loop

from .conftest import A, one_joint, two_links

THERE_AND_BACK = Reference("steps", times=(1.0, 2.004), values=(0.3, 0.0))


def stepping(loop: Loop, reference: Reference, duration: float = 8.0) -> Loop:
    entry = replace(loop.joints[0], reference=reference)
    return replace(loop, duration=duration, joints=(entry,))


@pytest.mark.parametrize("sample_time", [0.0, 0.005])
def test_it_ends_where_the_simulation_does(loop_of, sample_time):
    loop = stepping(loop_of(sample_time=sample_time), THERE_AND_BACK)
    found, ended = settle(one_joint(A), loop)["A"], simulate_loop(one_joint(A), loop).error[-1, 0]
    assert found.verdict == "rest"
    assert found.steady_error == pytest.approx(ended, rel=1e-5)
    assert abs(ended) > 0.01


@pytest.mark.parametrize("coarse", ["encoder_resolution", "encoder_noise"])
def test_the_first_sample_sees_no_velocity(loop_of, coarse):
    """What the encoder adds to the position is no step from where the joint is."""
    loop = loop_of(0.9, zeta=0.4, sample_time=0.005, error=0.3004, **{coarse: 1e-3})
    arm, rounds = one_joint(A), Rounds(one_joint(A), loop)
    after = rounds.run(own_start(rounds), NONE, duration=1.5 * loop.sample_time, quiet=False).place
    command = simulate_loop(arm, loop).command[0, 0]
    assert after.values[rounds.layout.torque][0] == pytest.approx(command, abs=0.2)  # noises differ by their seeds


@pytest.mark.parametrize("sample_time", [0.0, 0.005])
def test_a_cycle_that_a_step_draws_in_is_the_own_one(loop_of, sample_time):
    loop = stepping(loop_of(1.8, "zero", zeta=0.2, sample_time=sample_time), THERE_AND_BACK)
    found = settle(one_joint(A), loop)["A"]
    assert (found.basin["small"], found.basin["own"]) == ("rest", "sliding_cycle")


@pytest.mark.parametrize("scale", [1.0, 1e-4])
def test_a_small_start_is_small_beside_the_error_that_moves_the_joint(loop_of, scale):
    """It stays where it is, and a large one cycles, on an axis that an error of 35 µm moves as well."""
    friction = Friction(scale * A.C0, scale * A.C1, A.C2, scale * A.alpha)
    loop = loop_of(1.27, kp=18.0, zeta=0.64, error=0.3 * scale)
    basin = shoot(one_joint(friction), loop)["A"].basin
    assert basin == {"own": "sliding_cycle", "small": "rest", "large": "sliding_cycle"}


@pytest.mark.parametrize("sample_time", [0.0, 0.005])
def test_two_joints_that_step_at_their_own_times(sample_time):
    steps = (Reference("steps", times=(0.3, 0.602), values=(0.2, 0.1)), Reference("steps", times=(0.5,), values=(0.4,)))
    entries = [JointLoop(name, 60.0, step, ki=5.0) for name, step in zip("AB", steps, strict=True)]
    loop = Loop(sample_time, 1.0, tuple(entries), record_step=0.001)
    place = own_start(Rounds(two_links(), loop))
    seen = simulate_loop(two_links(), replace(loop, duration=place.time))
    assert place.time == pytest.approx(0.605 if sample_time else 0.602)
    state = place.values[Rounds(two_links(), loop).layout.state]
    assert state[:2] == pytest.approx(seen.motion.q[-1], abs=1e-7)
    assert state[2:4] == pytest.approx(seen.motion.dq[-1], abs=1e-6)


def test_steps_that_the_duration_does_not_reach_are_none(loop_of):
    late = Reference("steps", times=(1.0, 8.0), values=(0.3, 1.2))
    loop = stepping(loop_of(), late)
    assert pose(one_joint(A), loop) == [0.3]
    assert pose(one_joint(A), replace(loop, duration=1.0)) == [0.0]
    assert Rounds(one_joint(A), loop).entry("A").start == 0.3
    assert _shown(loop, []).joints[0].reference == Reference("steps", times=(1.0,), values=(0.3,))


def test_the_quick_map_takes_one_step(loop_of):
    assert not fits(Rounds(one_joint(A), stepping(loop_of(), THERE_AND_BACK, 2.0)), "A")
    assert fits(Rounds(one_joint(A), stepping(loop_of(), THERE_AND_BACK)), "A") == "the reference steps more than once"


def test_beside_one_that_regulates_a_ramp_starts_where_its_joint_is():
    """An error at the start is none of a ramp's, whatever its key says."""
    ramp = Reference("ramp", velocity=0.05, initial_error=0.4)
    loop = Loop(0.0, 20.0, (JointLoop("A", 60.0, ramp, start=0.1), JointLoop("B", 30.0, Reference("regulate"))))
    rounds = Rounds(two_links(), loop)
    place = starts(rounds)["large"]
    q = place.values[rounds.layout.state][: rounds.n]
    assert q[0] == pytest.approx(0.1)
    assert abs(q[1]) > 0.1
