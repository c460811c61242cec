"""What counts as slid: net motion, all of it; noise at rest, not at all."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stribeck.arm import Arm, Friction, Joint
from stribeck.effects.registry import laws
from stribeck.identify.conditioning import condition
from stribeck.identify.residual import Residual
from stribeck.identify.sliding import REACH, sliding
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath
from stribeck.run import Run

SD = 1e-4


def speed_of(position: np.ndarray, step: float) -> np.ndarray:
    return np.abs(np.gradient(position, step, axis=0))


def test_noise_at_rest_does_not_slide() -> None:
    position = SD * np.random.default_rng(0).standard_normal((4000, 1))
    gone = np.mean(sliding(position, np.array([SD])) * speed_of(position, 1.0))
    assert gone < 0.02 * np.mean(speed_of(position, 1.0))


def test_motion_slides_wholly() -> None:
    """But for the play after each reversal."""
    t = np.arange(2000) / 500.0
    position = np.sin(2.0 * np.pi * t)[:, None]
    part = sliding(position, np.array([SD]))[:, 0]
    missed = np.sum((1.0 - part) * speed_of(position, 1.0)[:, 0])
    fast = np.abs(np.cos(2.0 * np.pi * t)) > 0.3
    assert part[10:][fast[10:]] == pytest.approx(1.0)
    assert missed == pytest.approx(2.0 * REACH * SD * 8, rel=0.5)


def test_a_creep_slower_than_its_noise_is_counted_once() -> None:
    """The noise goes to and fro more than ten times as far."""
    rng = np.random.default_rng(1)
    position = (np.linspace(0.0, 0.02, 4000) + SD * rng.standard_normal(4000))[:, None]
    gone = np.sum(sliding(position, np.array([SD])) * speed_of(position, 1.0))
    assert np.sum(speed_of(position, 1.0)) > 10 * 0.02
    assert gone == pytest.approx(0.02, rel=0.3)


@given(st.integers(0, 10_000), st.floats(0.0, 1e-2))
@settings(max_examples=30, deadline=None)
def test_a_part_between_nothing_and_all(seed: int, sd: float) -> None:
    position = np.cumsum(np.random.default_rng(seed).standard_normal((50, 2)), axis=0) * 1e-3
    part = sliding(position, np.array([sd, 0.0]))
    assert np.all((part >= 0.0) & (part <= 1.0))
    assert part[np.abs(np.gradient(position[:, 1])) > 1e-9, 1] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("name", "law", "values", "kept"),
    [
        ("presliding", "lugre", {"stiffness": 400.0, "damping": 200.0}, 2.0),  # all of the friction, 2 N m
        ("dwell_time", "break_away", {"rise": 1.0, "time": 1.0, "distance": 2e-3}, 1.0),  # as old as can be
    ],
)
def test_laws_in_the_distance_gone_do_not_mind_noise_at_rest(
    name: str, law: str, values: dict[str, float], kept: float
) -> None:
    """After a slide a joint stands still for eight seconds, and its encoder trembles."""
    friction = Friction(2.0, 0.0, 0.0, 0.1)
    joint = Joint("A", "revolute", 0.3, 1.0, (0.1, 0.0), 0.01, 0.0, friction, friction, 10.0, SD)
    arm = Arm("one joint", (0.0, 0.0), (joint,))
    t = np.arange(0.0, 10.0, 0.004)
    noise = SD * np.random.default_rng(2).standard_normal(len(t))
    position = 0.2 * np.minimum(t, 2.0) + noise
    run = condition(arm, Run("slide and rest", t, position[:, None], np.full((len(t), 1), 2.0)), 15.0, np.array([SD]))
    path = SignalPath(arm, (Placed(laws()[name, law], 0, values),))
    residual, p = Residual(path, [run], ()), values_of(path.entries)
    assert residual.states(run, p)[-1, 0] == pytest.approx(kept, rel=0.15)
    if name == "presliding":
        assert np.mean(residual.stages(run, p)["friction"][-1000:]) == pytest.approx(kept, rel=0.15)
