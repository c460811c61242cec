"""A joint that moves without a torque, or with more than its drive has, is told of; one at rest is not."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import Arm
from stribeck.identify.commanded import doubtful_torques
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


@pytest.mark.parametrize(("kind", "unit"), [("revolute", "N m"), ("prismatic", "N")])
def test_more_torque_than_the_limit_is_told_of_with_both(kind: str, unit: str) -> None:
    run = recorded(noise=1e-5)
    run = replace(run, tau=run.tau / np.max(np.abs(run.tau)) * 12.5)
    (text,) = told(limited(5.0, kind), [run])
    assert text.startswith(f"A: 12.5 {unit} recorded, beyond its torque_limit of 5 {unit}: check the limit")
    for limit in (12.5, 80.0, None):
        assert told(limited(limit), [run]) == []
