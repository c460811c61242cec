"""The sampled loop around a plant from outside, against the loop inside the engine: the plant here is the engine."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from stribeck.errors import InputError, StribeckError
from stribeck.simulate import Compensation, Engine, JointLoop, Loop, Reference, close_loop
from stribeck.simulate.around import Reading, close_around

from .conftest import two_links


class EnginePlant:
    """The engine, one sample at a time."""

    shows_velocity = True

    def __init__(self, engine: Engine) -> None:
        self.engine, self.breaks, self.shows_mode = engine, np.inf, True

    def most_steps(self, sample_time: float) -> int:
        return 1000

    def start(self, q: np.ndarray) -> Reading:
        self.state, self.mode = self.engine.start(self.engine.p, q), np.zeros(self.engine.n)
        self.mode[:] = 0.0
        return Reading(q, np.zeros(self.engine.n), self.mode, np.zeros(self.engine.n))

    def step(self, time: float, step: float, torque: np.ndarray) -> Reading:
        if time > self.breaks:
            raise StribeckError("the plant broke")
        times, command = np.array([time, time + step]), np.tile(torque, (2, 1))
        moved = self.engine.run(self.engine.p, self.state, times, command, modes=self.mode)
        self.state, self.mode = moved.state[-1], moved.modes[-1]
        shown = self.mode if self.shows_mode else np.full(self.engine.n, np.nan)
        return Reading(moved.q[-1], moved.dq[-1], shown, moved.friction[-1])


class Counting(EnginePlant):
    """The engine, which takes so many steps in a sample time."""

    def __init__(self, engine: Engine, most: int) -> None:
        super().__init__(engine)
        self.most, self.taken = most, 0

    def most_steps(self, sample_time: float) -> int:
        return self.most

    def step(self, time: float, step: float, torque: np.ndarray) -> Reading:
        self.taken += 1
        return super().step(time, step, torque)


class Blinded(EnginePlant):
    """The engine, whose velocities are no numbers from a time on."""

    def step(self, time: float, step: float, torque: np.ndarray) -> Reading:
        seen = super().step(time, step, np.nan_to_num(torque))
        return replace(seen, dq=np.full_like(seen.dq, np.nan)) if time > 1.0 else seen


def joint(name: str, **values: object) -> JointLoop:
    settings = {"kp": 60.0, "ki": 20.0, "reference": Reference("sine", amplitude=0.2, frequency=0.6)}
    return JointLoop(name, **(settings | values))  # type: ignore[arg-type]


def both(*joints: JointLoop) -> Loop:
    return Loop(0.0125, 2.0, joints)


CASES = {
    "feedforward": both(
        joint("A", compensation=Compensation("feedforward"), reference=Reference("ramp", velocity=0.05)), joint("B")
    ),
    "feedback": both(joint("A", compensation=Compensation("feedback", at_zero="hold")), joint("B", velocity="true")),
    "adaptive": both(joint("A", compensation=Compensation("adaptive", ratio=0.7)), joint("B")),
    "robust": both(joint("B", compensation=Compensation("robust", inner=1e-3)), joint("A", start=0.3)),
    "delayed": both(joint("A", delay_samples=2, velocity_filter=0.02), joint("B", delay_samples=1)),
    "noisy": both(joint("A", encoder_noise=2e-5), joint("B", encoder_resolution=6e-6)),
    "steps": both(joint("A", reference=Reference("steps", times=(0.5, 1.0), values=(0.1, -0.1))), joint("B")),
    "regulate": both(joint("A", reference=Reference("regulate", initial_error=0.2)), joint("B")),
}


@pytest.mark.parametrize("name", CASES)
def test_same_as_the_loop_inside(level_arm: Engine, name: str) -> None:
    loop, arm = CASES[name], level_arm.path.arm
    inside, outside = close_loop(level_arm, loop, tolerance=1e-9), close_around(EnginePlant(level_arm), arm, loop)
    assert inside.motion.event_count > 0
    assert outside.motion.status == "ok"
    assert_allclose(outside.measured, inside.measured, rtol=0.0, atol=2e-8)
    assert_allclose(outside.command, inside.command, rtol=0.0, atol=2e-5)
    assert_array_equal(outside.reference, inside.reference)
    assert_array_equal(outside.reference_rate, inside.reference_rate)
    assert outside.sees_velocity is inside.sees_velocity


def test_lag_of_the_drive_is_followed_to_second_order(level_arm: Engine, monkeypatch: pytest.MonkeyPatch) -> None:
    loop = both(joint("A", actuator_lag=0.02), joint("B"))
    inside = close_loop(level_arm, loop, tolerance=1e-9)
    errors = []
    for steps in (10, 20, 40):
        monkeypatch.setattr("stribeck.simulate.around._LAG_STEPS", steps)
        outside = close_around(EnginePlant(level_arm), level_arm.path.arm, loop)
        errors.append(np.abs(outside.measured - inside.measured).max())
    assert errors[1] < 1e-4
    assert errors[2] < 0.35 * errors[1] < 0.35 * 0.35 * errors[0] * 1.5


@pytest.mark.parametrize(("most", "steps"), [(1000, 40), (9, 8), (1, 1)])
def test_a_short_lag_wants_no_more_steps_than_the_plant_takes(level_arm: Engine, most: int, steps: int) -> None:
    """Two lags, each followed in up to 20 steps of one sample, but in one at least."""
    loop = replace(both(joint("A", actuator_lag=1e-4), joint("B", actuator_lag=2e-3)), duration=0.5)
    plant = Counting(level_arm, most)
    outside = close_around(plant, level_arm.path.arm, loop)
    assert outside.motion.status == "ok"
    assert plant.taken <= 40 * steps
    inside = close_loop(level_arm, loop, tolerance=1e-9)
    assert_allclose(outside.measured, inside.measured, rtol=0.0, atol={1000: 2e-5, 9: 1e-3, 1: 2e-3}[most])


def test_time_stuck_and_failures(level_arm: Engine) -> None:
    arm = level_arm.path.arm
    still = both(joint("A", kp=1.0, reference=Reference("regulate", initial_error=0.5)), joint("B", kp=1.0))
    still = both(still.joints[0], joint("B", kp=1.0, ki=0.0, reference=Reference("regulate")))
    found = close_around(EnginePlant(level_arm), arm, still)
    assert_allclose(found.motion.stuck_time[-1, 1], 2.0)
    shy = EnginePlant(level_arm)
    shy.shows_mode = False
    assert_allclose(close_around(shy, arm, still).motion.stuck_time[-1, 1], 2.0)
    plant = EnginePlant(level_arm)
    plant.breaks = 1.0
    broken = close_around(plant, arm, CASES["feedforward"])
    assert broken.motion.status == "the plant broke"
    assert broken.ended == pytest.approx(1.0125)
    assert np.isnan(broken.measured[broken.motion.filled :]).all()
    assert np.isfinite(broken.run("x").q).all()


def test_a_velocity_that_is_no_number_is_no_torque_at_its_limit(level_arm: Engine) -> None:
    loop = both(joint("A", velocity="true", kv=8.0, velocity_filter=0.0), joint("B"))
    found = close_around(Blinded(level_arm), level_arm.path.arm, loop)
    times = np.arange(len(found.command)) * loop.sample_time
    late = times > 1.05
    assert late.sum() > 50
    assert np.isfinite(found.command[times < 1.0]).all()
    assert np.isnan(found.command[late, 0]).all()
    assert np.isfinite(found.command[late, 1]).all()  # which takes differences of positions


def test_what_cannot_be_closed_from_outside(level_arm: Engine) -> None:
    plant, arm = EnginePlant(level_arm), two_links()
    with pytest.raises(InputError, match="continuous controller"):
        close_around(plant, arm, Loop(0.0, 2.0, (joint("A"), joint("B"))))
    with pytest.raises(InputError, match="hold a joint still: found B"):
        close_around(plant, arm, both(joint("A")))
    plant.shows_velocity = False
    with pytest.raises(InputError, match="needs the output dq"):
        close_around(plant, arm, both(joint("A", velocity="true"), joint("B")))
