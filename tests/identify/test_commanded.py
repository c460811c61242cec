"""A joint that moves without a torque, or with more than its drive has, is told of; one at rest is not."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import Arm
from stribeck.identify.commanded import commands_beside, doubtful_torques
from stribeck.identify.identification import identify_friction
from stribeck.run import Run

from .conftest import PENDULUM, pendulum, recorded


def limited(limit: float | None, kind: str = "revolute") -> Arm:
    joint = replace(PENDULUM, torque_limit=limit, kind=kind)
    return replace(pendulum(), joints=(joint,))


def told(arm: Arm, runs: list[Run]) -> list[str]:
    return doubtful_torques(arm, runs, np.full(1, 1e-5))


def test_a_joint_that_moves_without_any_torque_is_told_of_in_one_line() -> None:
    runs = [replace(run := recorded(noise=1e-5, seed=k), name=f"run {k}", tau=0.0 * run.tau) for k in range(2)]
    (text,) = told(pendulum(), runs)
    assert text.startswith("A: it moves, but its torque is zero in every recording: give what was commanded as tau1")
    assert text in identify_friction(pendulum(), runs).warnings
    assert told(pendulum(), [runs[0], recorded(noise=1e-5)]) == []


def test_a_joint_at_rest_needs_no_torque() -> None:
    run = recorded(noise=1e-5)
    noise = 1e-5 * np.random.default_rng(0).standard_normal(run.q.shape)
    assert told(pendulum(), [replace(run, q=0.3 + noise, tau=0.0 * run.tau)]) == []


@pytest.mark.parametrize(
    ("factor", "told"), [(-1.0, "signs"), (0.02, "unit"), (1000.0, "unit"), (0.5, None), (1.5, None), (0.0, None)]
)
def test_a_factor_that_no_drive_has(factor: float, told: str | None) -> None:
    rng = np.random.default_rng(0)
    needed = rng.normal(size=(500, 2))
    asked = needed * [1.0, factor] + 0.3 * abs(factor) * rng.normal(size=needed.shape)
    found = commands_beside(asked, needed, ("A", "B"))
    assert len(found) == (told is not None)
    assert all(text.startswith("B: ") and told in text for text in found)


def test_what_is_unlike_is_no_multiple() -> None:
    asked, needed = np.random.default_rng(0).normal(size=(2, 500, 1))
    assert commands_beside(-9.0 * asked, needed, ("A",)) == []


def test_a_wrong_sign_is_told_of_where_friction_is_identified() -> None:
    run = recorded(noise=1e-5)
    assert not any("the command is" in text for text in identify_friction(pendulum(), [run]).warnings)
    wrong = identify_friction(pendulum(), [replace(run, tau=-run.tau)]).warnings
    assert any("check the signs of its torque and position" in text for text in wrong)


@pytest.mark.parametrize(("kind", "unit"), [("revolute", "N m"), ("prismatic", "N")])
def test_more_torque_than_the_limit_is_told_of_with_both(kind: str, unit: str) -> None:
    run = recorded(noise=1e-5)
    run = replace(run, tau=run.tau / np.max(np.abs(run.tau)) * 12.5)
    (text,) = told(limited(5.0, kind), [run])
    assert text.startswith(f"A: 12.5 {unit} recorded, beyond its torque_limit of 5 {unit}: check the limit")
    for limit in (12.5, 80.0, None):
        assert told(limited(limit), [run]) == []
