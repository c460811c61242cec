"""Tustin's friction: odd, dissipative, with the bend of the paper's equations (2) to (4)."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from stribeck.model.tustin import tustin_level, tustin_viscous

CONSTANTS = st.fixed_dictionaries(
    {"C0": st.floats(0.0, 20.0), "C1": st.floats(0.0, 10.0), "C2": st.floats(0.0, 10.0), "alpha": st.floats(1e-3, 1.0)}
)


def friction(v: float, constants: dict[str, float]) -> float:
    level, c2 = float(tustin_level(abs(v), constants)), constants["C2"]
    return math.copysign(level, v) + float(tustin_viscous(v, c2, c2))


@given(constants=CONSTANTS, v=st.floats(1e-6, 50.0))
def test_odd(constants: dict[str, float], v: float) -> None:
    assert friction(-v, constants) == -friction(v, constants)


@given(constants=CONSTANTS, v=st.floats(-50.0, 50.0).filter(bool))
def test_dissipative(constants: dict[str, float], v: float) -> None:
    assert v * friction(v, constants) >= 0.0


@given(constants=CONSTANTS)
def test_break_away(constants: dict[str, float]) -> None:
    assert float(tustin_level(0.0, constants)) == constants["C0"] + constants["C1"]


@given(constants=CONSTANTS)
def test_bend(constants: dict[str, float]) -> None:
    """Where C2 alpha < C1, eq. (2), friction is lowest at the speed of eq. (3), with the value of eq. (4)."""
    c0, c1, c2, alpha = (constants[name] for name in ("C0", "C1", "C2", "alpha"))
    ratio = c2 * alpha / c1 if c1 > 0.0 else math.inf
    assume(1e-6 < ratio < 0.95)
    speed = -alpha * math.log(ratio)
    lowest = friction(speed, constants)
    assert lowest == pytest.approx(c0 + c2 * alpha + c2 * alpha * math.log(1.0 / ratio), rel=1e-9)
    around = speed * np.concatenate([np.linspace(0.01, 0.99, 40), np.linspace(1.01, 4.0, 40)])
    assert all(friction(v, constants) >= lowest - 1e-12 * (1.0 + lowest) for v in around)


@given(constants=CONSTANTS, share=st.floats(0.0, 0.999))
def test_no_bend(constants: dict[str, float], share: float) -> None:
    """Where eq. (2) does not hold, friction only rises."""
    constants = {**constants, "C1": share * constants["C2"] * constants["alpha"]}
    speeds = np.geomspace(1e-4, 10.0, 60)
    values = np.array([friction(v, constants) for v in speeds])
    assert (np.diff(values) >= -1e-12 * (1.0 + values[1:])).all()


@given(v=st.floats(-9.0, 9.0), forward=st.floats(0.0, 5.0), backward=st.floats(0.0, 5.0))
def test_viscous_constant_of_either_direction(v: float, forward: float, backward: float) -> None:
    assert float(tustin_viscous(v, forward, backward)) == pytest.approx((forward if v > 0 else backward) * v)
