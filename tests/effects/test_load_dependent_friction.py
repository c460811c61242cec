"""What enters a gear is what leaves it and its friction: the level solves its own equation, at any load."""

from typing import Any

import numpy as np
import pytest

from stribeck.effects.registry import effect_named


def level(
    law: str, ratio: float, plain: float, direction: float, load: float, viscous: float = 0.0, torque: float = 0.0
) -> float:
    signals: Any = type("Signals", (), {"load": load, "viscous": viscous, "torque": torque})
    effect: Any = effect_named("load_dependent_friction", law)
    return float(effect.level(plain, direction, signals, {}, {"ratio": ratio}))


@pytest.mark.parametrize("ratio", [0.0, 0.05, 0.4, 0.9])
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_directional_friction_is_a_share_of_all_that_enters(ratio: float, direction: float) -> None:
    viscous = 0.7 * direction
    for load in np.linspace(-12.0, 12.0, 25):
        found = level("directional", ratio, 1.5, direction, load, viscous)
        assert found == pytest.approx(1.5 + ratio * abs(direction * (load + viscous) + found), rel=1e-12)
        assert found >= 1.5


@pytest.mark.parametrize("ratio", [0.0, 0.05, 0.4, 0.9])
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_net_friction_is_a_share_of_what_it_leaves(ratio: float, direction: float) -> None:
    for torque in np.linspace(-12.0, 12.0, 25):
        found = level("net", ratio, 1.5, direction, 0.0, torque=torque)
        assert found == pytest.approx(1.5 + ratio * abs(direction * torque - found), rel=1e-12)
        assert found >= 1.5


@pytest.mark.parametrize("torque", [-8.0, 8.0])
def test_the_motor_s_torque_counts_whatever_becomes_of_it(torque: float) -> None:
    assert level("motor", 0.2, 1.5, 1.0, 3.0, torque=torque) == pytest.approx(1.5 + 0.2 * 8.0)


def test_a_driving_motor_meets_more_than_a_driven_one() -> None:
    """The proportional law knows no such difference, and is the directional one's limit for small ratios."""
    driving, driven = (level("directional", 0.2, 0.5, direction, 8.0) for direction in (1.0, -1.0))
    assert driving > 1.4 * driven
    assert level("proportional", 0.2, 0.5, 1.0, 8.0) == level("proportional", 0.2, 0.5, -1.0, 8.0)
    small = [level(law, 1e-6, 0.5, 1.0, 8.0) - 0.5 for law in ("directional", "proportional")]
    assert small[0] == pytest.approx(small[1] + 1e-6 * 0.5, rel=1e-4)


def test_under_load_it_is_easier_to_let_down_than_to_lift() -> None:
    """Without other friction: a share of what enters, which is more than the load when lifting and less when not."""
    lift, lower = (level("directional", 0.6, 0.0, direction, 5.0) for direction in (1.0, -1.0))
    assert lift == pytest.approx(0.6 * 5.0 / 0.4)
    assert lower == pytest.approx(0.6 * 5.0 / 1.6)
