"""Links that are corrected by the residual: any law's, stable, and silent where nothing is wrong."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from stribeck.arm import Arm, Friction, Joint
from stribeck.effects.registry import registry
from stribeck.model.cut import Cut
from stribeck.model.drive import DRIVE
from stribeck.model.effect import TransmissionEffect
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath
from stribeck.model.scale import Scale
from stribeck.model.values import Parameter

STEP, COUNT = 0.002, 2000
NONE = Friction(0.0, 0.0, 0.0, 0.1)
STIFFNESS, DAMPING, LINK = 200.0, 0.05, 0.02  # rings at 16 Hz, 2.5 per mille of critical


class Hardening(TransmissionEffect):
    """A law of somebody else's, with names of its own."""

    name = "hardening"
    channel = "transmission"
    equation = r"\tau = c (\theta - q) + h (\theta - q)^3 + d (\dot\theta - \dot q)"
    symptom = "a resonance that rises with its amplitude"
    source = "a test"
    parameters = (
        Parameter("slope", "N m/rad", "at rest", np.inf, 1.0, 1e6, log=True),
        Parameter("cubic", "N m/rad^3", "of the third power", 0.0, 0.0, 1e9),
    )

    def starts(self, scale: Scale) -> tuple[dict[str, float], ...]:
        return ({"slope": 100.0, "cubic": 1.0},)

    def transmitted(self, deflection: Any, rate: Any, p: Mapping[str, Any]) -> Any:
        return p["slope"] * deflection + p["cubic"] * deflection**3 + DAMPING * rate

    def deflection(self, torque: Any, p: Mapping[str, Any]) -> Any:
        return torque / p["slope"]


SHAFT = Placed(registry()["joint_flexibility"], 0, {"stiffness": STIFFNESS, "damping": DAMPING})
OTHERS = Placed(Hardening(), 0, {"slope": STIFFNESS, "cubic": 5e4})


def path_with(place: Placed) -> SignalPath:
    joint = Joint("A", "revolute", 0.3, 1.0, (0.0, 0.0), LINK, 0.01, NONE, NONE)
    return SignalPath(Arm("a shaft", (0.0, 0.0), (joint,)), (place,))


def residual_of(place: Placed, *, observe: bool, noise: float = 0.0, extra: float = 0.0) -> np.ndarray:
    """Residual (COUNT,), N m, of a motor on a sine whose command balances the shaft's own law, and ``extra`` N m."""
    path = path_with(place)
    p, late = values_of(path.entries), np.zeros(1)
    t, w = np.arange(COUNT) * STEP, 2.0 * np.pi * 1.5
    smooth = {"position": 0.3 * np.sin(w * t), "velocity": 0.3 * w * np.cos(w * t)}
    smooth |= {"acceleration": -(w**2) * smooth["position"], "velocity_sd": np.full(COUNT, 1e-9), "time": t}

    def left(motion: dict[str, np.ndarray], command: np.ndarray, *, observe: bool) -> np.ndarray:
        known = {**motion, "command": command}
        rows = np.array([known.get(name, np.zeros(COUNT)) for name in DRIVE])
        cut, out = Cut(path, STEP, (), observe=observe), []
        state = cut.begin(rows[:, 0], p, late)
        for k in range(COUNT):
            out.append(float(cut.balance(rows[:, k], state, p, late)[0]))
            state = cut.follow(state, rows[:, k], rows[:, min(k + 1, COUNT - 1)], p, late)
        return np.array(out)

    command = -left(smooth, np.zeros(COUNT), observe=False)  # without an observer: what the command lacks
    moved = noise * gaussian_filter1d(np.random.default_rng(0).standard_normal(COUNT), 2.0)
    rate = np.gradient(moved, STEP)
    shaken = {"position": moved, "velocity": rate, "acceleration": np.gradient(rate, STEP)}
    recorded = {**smooth, **{name: smooth[name] + change for name, change in shaken.items()}}
    return left(recorded, command + extra, observe=observe)


@pytest.mark.parametrize("place", [SHAFT, OTHERS], ids=["linear", "hardening"])
def test_what_balances_is_left_alone(place: Placed) -> None:
    assert np.max(np.abs(residual_of(place, observe=True)[5:])) < 1e-3


@pytest.mark.long
def test_noise_does_not_ring_on() -> None:
    alone, observed = (np.std(residual_of(SHAFT, observe=observe, noise=1e-5)[500:]) for observe in (False, True))
    assert observed < 0.5 * alone


def test_a_steady_torque_stays_in_the_residual() -> None:
    """It is a notch, not a servo: what lies far below the link's own frequency is not followed."""
    left = residual_of(SHAFT, observe=True, extra=0.1)
    assert np.mean(left[-500:]) == pytest.approx(0.1, rel=0.15)
