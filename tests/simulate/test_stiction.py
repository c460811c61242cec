"""True stiction: break-away exactly at C0 + C1, and no creep below it."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.simulate import Compensation, Engine, JointLoop, Loop, path_of, simulate_loop
from stribeck.simulate import Reference as Asked

from .conftest import A, entry, one_joint, two_links
from .reference import Reference


def mode_at_start(engine: Engine, state: np.ndarray, command: np.ndarray) -> np.ndarray:
    found = engine.run(engine.p, state, np.array([0.0, 1e-6]), np.tile(command, (2, 1)))
    assert found.ok
    assert ((found.modes != 0.0) | (found.dq == 0.0)).all()
    return found.modes[0]


@pytest.mark.parametrize("speed", [0.0, 0.7])
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("joint", [0, 1])
def test_break_away_level(hanging_arm: Engine, joint: int, sign: float, speed: float) -> None:
    """Also where the other joint moves, which pulls at this one."""
    reference = Reference(hanging_arm.path.arm)
    state = np.array([0.4, -0.8, 0.0, 0.0])
    state[2 + (1 - joint)] = speed
    level = reference.level(joint, 0.0)
    command = np.array([1.0, 0.5])
    modes = [0, 0]
    modes[1 - joint] = int(speed > 0.0)
    if not speed:
        command[1 - joint] = reference.bias(state)[1 - joint]  # the other joint rests as well
    held = reference.accelerations(state, command, tuple(modes))[1][joint]
    for share, expected in ((1 - 1e-9, 0.0), (1 + 1e-6, sign)):
        trial = command.copy()
        trial[joint] += sign * level * share - held
        assert mode_at_start(hanging_arm, state, trial)[joint] == expected


def test_no_drift(level_arm: Engine) -> None:
    times = 0.0125 * np.arange(80_001)
    rng = np.random.default_rng(5)
    command = np.array([6.25, 2.8]) * (1 - 1e-9) * np.sign(rng.normal(size=(len(times), 2)))
    found = level_arm.run(level_arm.p, np.array([0.3, -1.0, 0.0, 0.0]), times, command)
    assert found.t[-1] == 1000.0
    assert found.ok
    assert (found.q == found.q[0]).all()
    assert (found.dq == 0.0).all()
    assert found.event_count == 0


def test_no_drift_while_the_other_joint_moves(hanging_arm: Engine) -> None:
    """A stuck joint's position is the same number until it breaks away."""
    times = 0.01 * np.arange(3001)
    command = np.stack([np.full(len(times), 1.0), 5.0 * np.sin(2.0 * times)], axis=1)
    found = hanging_arm.run(hanging_arm.p, np.zeros(4), times, command)
    assert (found.modes[:, 1] != 0.0).mean() > 0.5
    throughout = np.abs(np.diff(found.stuck_time[:, 0]) - 0.01) < 1e-12
    assert throughout.sum() > 100
    assert (np.diff(found.q[:, 0])[throughout] == 0.0).all()


def test_break_away_with_effects() -> None:
    """The level is that of the effects: load-dependent, position-dependent and asymmetric friction together."""
    arm = two_links(
        entry("load_dependent_friction", "A", ratio=0.3),
        entry("position_dependent_friction", "A", sine=0.2, harmonic=3.0),
        entry("asymmetric_friction", "A", coulomb=0.4, viscous=0.1),
        gravity=(9.81, 0.0),
    )
    engine = Engine(path_of(arm))
    q = np.array([0.5, 0.2, 0.0, 0.0])
    load = float(Reference(two_links(gravity=(9.81, 0.0))).bias(q)[0])
    still = np.array([0.0, Reference(two_links(gravity=(9.81, 0.0))).bias(q)[1]])
    modulation = 1 + 0.2 * np.sin(3.0 * q[0])
    for sign in (1.0, -1.0):
        level = (6.25 + sign * 0.4) * modulation + 0.3 * abs(load)
        for share, expected in ((1 - 1e-9, 0.0), (1 + 1e-6, sign)):
            command = still + np.array([load + sign * level * share, 0.0])
            assert mode_at_start(engine, q, command)[0] == expected


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_friction_that_goes_with_the_motor_s_torque_breaks_away_later(sign: float) -> None:
    """At rest without load C0 + C1 + 0.3 u = u: a command of (C0 + C1) / 0.7."""
    slower = replace(entry("load_dependent_friction", "A", ratio=0.3), law="motor")
    engine = Engine(path_of(two_links(slower)))
    for share, expected in ((1.0 - 1e-6, 0.0), (1.0 + 1e-6, sign)):
        command = np.array([sign * 6.25 / 0.7 * share, 0.0])
        assert mode_at_start(engine, np.array([0.3, 0.2, 0.0, 0.0]), command)[0] == expected


@pytest.mark.parametrize("sample_time", [0.0, 0.0125, 0.05])
def test_a_stuck_joint_is_shaken_loose_between_two_commands(sample_time: float) -> None:
    """A wave of 12 N m on a break-away of 6.25 N m lets go and is caught twice a period; samples fall on its zeros."""
    arm = replace(one_joint(A), effects=(entry("input_disturbance", "A", sine=12.0, cosine=0.0, frequency=80.0),))
    held = JointLoop("A", 1e-3, Asked("regulate"), kv=0.0)
    found = simulate_loop(arm, Loop(sample_time, 0.5, (held,), record_step=0.05)).motion
    assert found.event_count == 80
    assert found.stuck_time[-1].item() < 0.003 * 0.5


def test_a_stuck_joint_is_shaken_loose_by_its_own_command() -> None:
    law = Compensation("dither", amplitude=6.3, frequency=80.0)
    held = JointLoop("A", 1e-3, Asked("regulate"), kv=0.0, compensation=law)
    moved = JointLoop("A", 30.0, Asked("sine", amplitude=0.21, frequency=80.0), kv=0.0)
    for joint in (held, moved):
        found = simulate_loop(one_joint(A), Loop(0.0, 0.5, (joint,), record_step=0.05)).motion
        assert found.event_count in (159, 160)
