"""A drive is composed from the command to the shaft, whichever of its effects was found first."""

from itertools import permutations

import casadi as ca
import numpy as np
import pytest

from stribeck.effects.registry import effect_named
from stribeck.model.effect import Along
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath
from stribeck.model.values import Signals

from ..effects.bench import nominal_arm

DRIVE = (
    ("torque_saturation", {"limit": 2.0}),
    ("actuator_lag", {"time_constant": 0.01}),
    ("torque_ripple", {"sine": 0.3, "cosine": 0.1, "harmonic": 5.0}),
    ("torque_offset", {"offset": 0.4}),
)


def test_every_place_along_a_drive_is_taken() -> None:
    assert [effect_named(name).along for name, _ in DRIVE] == list(Along)  # type: ignore[attr-defined]


@pytest.mark.parametrize("order", list(permutations(range(len(DRIVE)))))
def test_the_order_in_which_effects_are_placed_is_none(order: tuple[int, ...]) -> None:
    """The limit clips the command, the lag trails that, the ripple is in step with the shaft, the offset is whole."""
    path = SignalPath(nominal_arm(), [Placed(effect_named(DRIVE[i][0]), 0, DRIVE[i][1]) for i in order])
    lag = order.index(1)
    command, trailing, position = 7.0, 1.2, 0.3
    s = Signals(0.0, position, 0.0, 0.0, position, 0.0)
    x = ca.SX.sym("x", len(path.state_names))
    entries = [path.parameter(entry.key) for entry in path.entries]
    law = ca.Function("law", [x, *entries], [path.actuated(0, command, s, x), *path.rates(lag, command, [s], [0.0], x)])
    torque, rate = law(trailing, *values_of(path.entries))
    wave = 0.3 * np.sin(5.0 * position) + 0.1 * np.cos(5.0 * position)
    assert float(torque) == pytest.approx(trailing * (1.0 + wave) + 0.4)
    assert float(rate) == pytest.approx((2.0 - trailing) / 0.01)
