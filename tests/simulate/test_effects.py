"""Effects in the engine: delays to the instant, stiff and discontinuous laws, extremes that must end in a status."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import EffectEntry, Friction
from stribeck.effects.registry import laws
from stribeck.errors import InputError
from stribeck.model.effect import Effect
from stribeck.model.layout import Placed
from stribeck.model.path import SignalPath
from stribeck.model.scale import Scale
from stribeck.simulate import Engine, path_of
from stribeck.simulate.engine import left_at_null, left_out

from .conftest import entry, two_links
from .reference import Reference

TIMES = 0.005 * np.arange(401)
COMMAND = np.stack([12.0 * np.sin(3.0 * TIMES) + 5.0, 5.0 * np.sin(4.1 * TIMES)], axis=1)


@pytest.fixture(scope="module")
def late() -> Engine:
    """A delay that is no whole number of samples."""
    return Engine(path_of(two_links(entry("delay", ("A", "B"), time=0.0173))))


def test_delay_shifts_events_exactly(level_arm: Engine, late: Engine) -> None:
    """It moves every event by itself."""
    command = COMMAND.copy()
    command[:2] = 0.0
    found, plain = (e.run(e.p, np.zeros(4), TIMES, command, tolerance=1e-10) for e in (late, level_arm))
    shifted = plain.events["time"][plain.events["time"] + 0.0173 < TIMES[-1]] + 0.0173
    assert len(shifted) > 5
    assert found.events["time"][: len(shifted)] == pytest.approx(shifted, abs=1e-8)


def test_window_looks_back_for_its_delay(late: Engine) -> None:
    whole = late.run(late.p, np.zeros(4), TIMES, COMMAND, tolerance=1e-10)
    assert whole.modes[200].all()
    part = late.windows(late.p, whole.state[[200]], TIMES, COMMAND, [200], [201], tolerance=1e-10)
    assert part.q == pytest.approx(whole.q[200:], abs=1e-8)


@pytest.mark.parametrize(
    "effect",
    [
        entry("presliding", ("A", "B"), stiffness=1500.0, damping=5.0),
        entry("presliding", ("A", "B"), stiffness=1e5, damping=0.0),
        entry("backlash", ("B",), gap=0.02, stiffness=1e4, damping=5.0),
        pytest.param(entry("actuator_lag", ("A",), time_constant=1e-5), marks=pytest.mark.slow),
        pytest.param(entry("joint_flexibility", ("B",), stiffness=1e6, damping=50.0), marks=pytest.mark.slow),
    ],
    ids=lambda effect: effect.effect,
)
def test_stiff_effects_converge(effect: EffectEntry) -> None:
    engine = Engine(path_of(two_links(effect)))
    start = engine.start(engine.p, np.zeros(2), np.zeros(2), COMMAND[0])
    rough, fine = (engine.run(engine.p, start, TIMES, COMMAND, tolerance=tolerance) for tolerance in (1e-6, 1e-9))
    assert rough.ok
    assert fine.ok
    assert np.abs(rough.q - fine.q).max() < 1e-3
    assert rough.steps < 100_000


def test_tiny_lag_is_no_lag(level_arm: Engine) -> None:
    engine = Engine(path_of(two_links(entry("actuator_lag", ("A", "B"), time_constant=1e-5))))
    start = engine.start(engine.p, np.zeros(2), np.zeros(2), COMMAND[0])
    found = engine.run(engine.p, start, TIMES, COMMAND)
    plain = level_arm.run(level_arm.p, np.zeros(4), TIMES, COMMAND)
    assert np.abs(found.q - plain.q).max() < 1e-3


def test_effects_at_null_are_left_out() -> None:
    unset = entry("presliding", ("A",), stiffness=np.inf, damping=3.0)
    arm = two_links(unset, entry("actuator_lag", ("A",)), entry("delay", ("B",)))
    assert path_of(arm).placed == ()
    told = left_at_null(arm)
    assert [line.split(" is at its null value")[0] for line in told] == ["A: presliding", "A: actuator_lag", "B: delay"]


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3, 1e6])
def test_random_commands_end_in_a_status(hanging_arm: Engine, scale: float) -> None:
    """Whatever the torque: finite rows up to the end, or up to where the status says."""
    rng = np.random.default_rng(int(scale * 1000) % 97)
    for _ in range(10):
        command = scale * rng.standard_cauchy((200, 2))
        found = hanging_arm.run(hanging_arm.p, rng.normal(size=4), TIMES[:200], command, tolerance=1e-6)
        assert found.status in ("ok", "unbounded", "too_many_steps")
        assert np.isfinite(found.q[: found.filled]).all()
        assert (found.filled == 200) == found.ok


def test_bad_states_are_said(level_arm: Engine) -> None:
    found = level_arm.run(level_arm.p, np.array([0.0, np.nan, 0.0, 0.0]), TIMES, COMMAND)
    assert found.status == "not_finite"
    command = COMMAND.copy()
    command[50, 0] = np.nan
    broken = level_arm.run(level_arm.p, np.zeros(4), TIMES, command)
    assert broken.status in ("not_finite", "step_too_small")
    assert broken.filled <= 51


def test_frictionless_joint_reverses() -> None:
    """Without Coulomb friction each reversal is an event that changes nothing: a pendulum keeps its energy."""
    none = Friction(0.0, 0.0, 0.0, 0.05)
    arm = two_links(gravity=(9.81, 0.0))
    arm = replace(arm, joints=tuple(replace(joint, friction=none, backward=none) for joint in arm.joints))
    engine = Engine(path_of(arm))
    times = 0.01 * np.arange(1001)
    found = engine.run(engine.p, np.array([0.5, 0.0, 0.0, 0.0]), times, np.zeros((1001, 2)), tolerance=1e-10)
    reference = Reference(arm)
    energy = np.array([reference.energy(y) for y in found.state])
    assert found.ok
    assert np.ptp(energy) < 1e-7


SCALE = Scale(torque=8.0, friction=4.0, speed=1.0, travel=2.0, inertia=0.4, sample_time=0.005, length=0.3)


@pytest.mark.slow
@pytest.mark.parametrize("effect", [pytest.param(e, id=e.label) for e in laws().values()])
def test_every_effect_runs(effect: Effect) -> None:
    """Compiled, simulated, and converged, whatever the registry holds."""
    placed = [Placed(effect, joint, effect.starts(SCALE)[0]) for joint in effect.sites(2)]
    engine = Engine(SignalPath(two_links(gravity=(9.81, 0.0)), placed))
    start = engine.start(engine.p, np.array([0.2, -0.1]), np.zeros(2), COMMAND[0])
    rough, fine = (engine.run(engine.p, start, TIMES, COMMAND, tolerance=tolerance) for tolerance in (1e-6, 1e-9))
    assert rough.ok
    assert fine.ok
    assert rough.event_count == fine.event_count
    assert np.abs(rough.q - fine.q).max() < 1e-5


def test_effects_that_records_alone_show_are_told_to_be_left_out() -> None:
    seen = entry("velocity_filter", ("B",), time=0.03), entry("encoder_quantisation", ("A",), resolution=0.0)
    (told,) = left_out(two_links(*seen, entry("delay", ("A",), time=0.01)))
    assert told.startswith("B: velocity_filter is of records alone and left out here")


def test_a_spring_between_motor_and_link_needs_a_motor() -> None:
    """Without inertia it would have none to turn: a simulation ended at once, and an analysis of a loop never."""
    arm = two_links(entry("joint_flexibility", ("B",), stiffness=300.0, damping=1.0))
    (first, second) = arm.joints
    light = replace(arm, joints=(first, replace(second, rotor_inertia=0.0)))
    with pytest.raises(InputError, match=r"needs a rotor between motor and link: found B\.rotor_inertia = 0"):
        path_of(light)
    assert path_of(replace(light, effects=())).n == 2
    assert path_of(arm).flexible == (1,)


def test_inertia_is_that_of_the_pose_which_the_sensors_mean() -> None:
    """An encoder that is off by a quarter turn has the arm outstretched where it reads a right angle."""
    plain = Engine(path_of(two_links()))
    off = Engine(path_of(two_links(entry("encoder_offset", ("B",), offset=0.5 * np.pi))))
    pose = np.array([0.3, 0.0])
    assert off.moved_inertia(off.measured(np.append(pose, np.zeros(2)))) == pytest.approx(plain.moved_inertia(pose))
    assert off.moved_inertia(pose)[0] != pytest.approx(plain.moved_inertia(pose)[0], rel=0.05)
