"""The paper's procedure: exact on exact readings, and honest about what goes wrong."""

import math

import numpy as np
import pytest

from stribeck.identify.section3 import section3
from stribeck.identify.section3.saddle import alphas_by_velocity

TRUE = (5.0, 1.25, 1.5, 0.05)
SADDLE = -0.05 * math.log(1.5 * 0.05 / 1.25)


def level(speed: np.ndarray, true: tuple[float, ...] = TRUE) -> np.ndarray:
    """Equation (1), written out here."""
    return true[0] + true[1] * np.exp(-speed / true[3]) + true[2] * speed


SPEEDS = np.array([0.0, 0.02, 0.06, SADDLE, 0.3, 1.0, 2.0])


def test_exact_readings_give_the_constants() -> None:
    found = section3(SPEEDS, level(SPEEDS))
    assert found.ok
    assert found.constants == pytest.approx(TRUE, rel=1e-6)
    assert found.condition == pytest.approx(1.5 * 0.05 / 1.25, rel=1e-6)
    assert found.break_away == pytest.approx(6.25)
    assert found.saddle is not None
    assert found.saddle.velocity == pytest.approx(SADDLE)
    assert found.line is not None
    assert (found.line.first, found.line.second) == (2.0, 1.0)


def test_trials_at_one_velocity_are_averaged() -> None:
    speed = np.repeat(SPEEDS, 2)
    torque = level(speed) + np.tile([0.1, -0.1], len(SPEEDS))
    assert section3(speed, torque).constants == pytest.approx(TRUE, rel=1e-6)


def test_velocities_that_follow_closely_are_not_one() -> None:
    """Each is near the next, the first far from the last: what is averaged lies within a tenth of the slowest."""
    speed = np.concatenate([[0.0], np.geomspace(0.02, 2.0, 60)])
    found = section3(speed, level(speed))
    assert not any("there are 1" in remark for remark in found.remarks)
    assert found.line is not None
    assert found.line.second < found.line.first


def test_equation_3_has_two_solutions_at_most() -> None:
    """Both are checked in the equation itself; the tangent case has one, beyond it there is none."""
    pair = alphas_by_velocity(SADDLE, 1.25, 1.5)
    assert len(pair) == 2
    assert pair[0] == pytest.approx(0.05, rel=1e-9)
    for alpha in pair:
        assert -alpha * math.log(1.5 * alpha / 1.25) == pytest.approx(SADDLE, rel=1e-9)
    most = 1.25 / (math.e * 1.5)
    assert alphas_by_velocity(1.001 * most, 1.25, 1.5) == ()
    assert alphas_by_velocity(SADDLE, -1.0, 1.5) == ()


def test_amplification_is_what_an_error_of_the_torque_does() -> None:
    """One per cent more torque at the saddle alone changes alpha by so many per cent."""
    torque = level(SPEEDS)
    plain = section3(SPEEDS, torque)
    torque[3] *= 0.999  # still the lowest reading
    changed = section3(SPEEDS, torque).constants[3] / plain.constants[3] - 1.0
    assert changed == pytest.approx(-0.001 * plain.amplification, rel=1e-6)
    assert plain.amplification == pytest.approx(level(np.array([SADDLE]))[0] / (1.5 * 0.05), rel=1e-6)


@pytest.mark.parametrize(
    ("speed", "torque", "says"),
    [
        ([0.0, 0.5], [6.0, 5.0], "3.1 needs readings at two velocities; there are 1"),
        ([0.1, 0.5, 1.0], [5.2, 5.7, 6.5], "3.2 needs a break-away reading"),
        ([0.0, 0.1, 0.5, 1.0], [6.2, 5.2, 6.5, 6.0], "the torque does not rise with velocity"),
        ([0.0, 0.1, 0.5, 1.0], [4.0, 5.1, 5.5, 6.0], "break-away lies below the line of 3.1"),
        ([0.0, 0.1, 0.5, 1.0], [6.2, 5.2, 5.7, 6.5], "no bend is seen"),
        ([0.0, 0.05, 0.15, 0.5, 1.0], [6.2, 5.6, 4.9, 5.7, 6.5], "the saddle lies below the line of 3.1"),
        ([0.0, 0.05, 0.15, 0.5, 1.0], [6.2, 5.6, 4.9, 5.7, 6.5], "condition (2) does not hold"),
        ([0.0, 0.1, 0.3, 0.5, 1.0], [6.2, 6.0, 5.5, 5.4, 6.5], "not large against the saddle's"),
        ([0.0, 0.1, 0.7], [6.2, 5.3, 6.1], "the line of 3.1 passes through the least torque, at 0.1 rad/s: no alpha"),
    ],
)
def test_pitfalls_are_said(speed: list[float], torque: list[float], says: str) -> None:
    found = section3(np.array(speed), np.array(torque))
    assert any(says in remark for remark in found.remarks), found.remarks


@pytest.mark.parametrize(
    ("speed", "torque", "says"),
    [
        ([0.0, 0.1, 0.5, 1.0], [6.2, 5.2, 6.5, 6.0], "C2 = -1 N s/m by"),
        ([0.0, 0.1, 0.5, 1.0], [0.4, 0.2, 0.5, 1.5], "C0 = -0.5 N by"),
        ([0.0, 0.1, 0.5, 1.0], [4.0, 5.1, 5.5, 6.0], "C1 = -1 N by"),
        ([0.0, 0.1, 0.5, 1.0], [6.2, 5.2, 5.7, 6.5], "slowest velocity, 0.1 m/s; no"),
        ([0.0, 0.05, 0.15, 0.5, 1.0], [6.2, 5.6, 4.7, 5.7, 6.5], "alpha = -0.275 m/s by"),
        ([0.0, 0.1, 0.3, 0.5, 1.0], [6.2, 6.0, 5.5, 5.4, 6.5], "the saddle's, 0.5 m/s"),
    ],
)
def test_on_an_axis_they_are_in_metres(speed: list[float], torque: list[float], says: str) -> None:
    found = section3(np.array(speed), np.array(torque), "prismatic")
    assert any(says in remark for remark in found.remarks), found.remarks
    assert not any("rad" in remark or "N m" in remark for remark in found.remarks)


def test_nothing_is_made_up_for_steps_that_fail() -> None:
    found = section3(np.array([0.5]), np.array([5.0]))
    assert not found.ok
    assert all(math.isnan(value) for value in found.constants)
    found = section3(np.array([0.1, 0.5, 1.0]), np.array([5.2, 5.7, 6.5]))
    assert not found.ok
    assert math.isnan(found.constants[1])
    assert math.isfinite(found.constants[2])
    assert math.isnan(section3(np.array([0.0, 0.1, 0.7]), np.array([6.2, 5.3, 6.1])).constants[3])
    assert not section3(np.array([0.0, 0.0]), np.array([5.0, 5.1])).ok
