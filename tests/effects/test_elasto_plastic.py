"""The elasto-plastic bristle beside the law of Dupont, Hayward, Armstrong & Altpeter (2002), integrated by SciPy."""

import math
from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stribeck.arm import Arm, Friction, Joint
from stribeck.effects.registry import effect_named
from stribeck.gap import diagnose
from stribeck.model.effect import FrictionEffect
from stribeck.run import Run

ELASTIC = 0.7
STIFFNESS, LEVEL = 800.0, 2.0  # N m/rad, N m


def alpha(loaded: float) -> float:
    """The paper's share of the motion that slides, by the load over the level in the direction of motion."""
    middle = (loaded - 0.5 * (1.0 + ELASTIC)) / (1.0 - ELASTIC)
    return 0.5 + 0.5 * math.sin(math.pi * min(max(middle, -0.5), 0.5))


def along(times: np.ndarray, velocity: np.ndarray, damping: float) -> np.ndarray:
    """Return the paper's friction torque at each time."""

    def stretching(t: float, z: np.ndarray) -> float:
        v = float(np.interp(t, times, velocity))
        loaded = STIFFNESS * float(z[0]) / LEVEL
        return v * (1.0 - alpha(loaded * math.copysign(1.0, v)) * loaded * math.copysign(1.0, v))

    found = solve_ivp(stretching, times[[0, -1]], [0.0], t_eval=times, max_step=2e-3, rtol=1e-7, atol=1e-9)
    rates = np.array([stretching(t, z) for t, z in zip(times, found.y.T, strict=True)])
    return np.asarray(STIFFNESS * found.y[0] + damping * rates)


def bristle() -> FrictionEffect:
    effect = effect_named("presliding", "elasto_plastic")
    assert isinstance(effect, FrictionEffect)
    return effect


def moved(torque: float, distance: float, level: float = LEVEL) -> float:
    states = bristle().bristle_moved(ca.DM(level), ca.DM(distance), {"torque": ca.DM(torque)}, {"stiffness": STIFFNESS})
    assert states is not None
    return float(states["torque"])


def test_it_is_a_spring_up_to_break_away_and_the_papers_law_beyond() -> None:
    way = np.linspace(0.0, 8.0, 801) * LEVEL / STIFFNESS
    paper = solve_ivp(
        lambda x, u: [1.0 - alpha(u[0]) * u[0]], (0.0, 8.0), [-1.0], t_eval=way * STIFFNESS / LEVEL, max_step=5e-3
    )
    own = np.array([moved(-LEVEL, x) for x in way]) / LEVEL
    assert np.max(np.abs(own - paper.y[0])) < 0.004
    spring = own < ELASTIC
    np.testing.assert_allclose(own[spring], -1.0 + way[spring] * STIFFNESS / LEVEL, atol=1e-12)
    assert own[-1] == pytest.approx(1.0, abs=0.01)


def test_no_creep_below_break_away() -> None:
    """Where the plain bristle gives way a little with every stroke."""
    torque = 0.3
    for _ in range(50):
        torque = moved(moved(torque, 1e-3), -1e-3)
    assert torque == pytest.approx(0.3, abs=1e-12)
    assert moved(0.3, 0.0) == 0.3


@pytest.mark.parametrize(
    "torque", [-2.0, 0.2, 1.7, 2.6]
)  # loaded the other way, a spring, giving way, beyond a level that fell
@pytest.mark.parametrize("distance", [4e-3, -4e-3])
def test_a_way_in_parts_is_the_way_in_one_and_that_of_the_derivatives(torque: float, distance: float) -> None:
    parts = torque
    for _ in range(7):
        parts = moved(parts, distance / 7)
    assert parts == pytest.approx(moved(torque, distance), abs=0.004 * LEVEL)

    def rate(t: float, b: np.ndarray) -> float:
        signals = SimpleNamespace(velocity=ca.DM(distance))
        states = {"torque": ca.DM(float(b[0]))}
        return float(bristle().bristle_derivatives(ca.DM(LEVEL), signals, states, {"stiffness": STIFFNESS})["torque"])  # type: ignore[arg-type]

    followed = solve_ivp(rate, (0.0, 1.0), [torque], rtol=1e-8, atol=1e-10, max_step=0.02).y[0, -1]
    assert followed == pytest.approx(parts, abs=1e-3 * LEVEL)


@pytest.mark.long
def test_it_is_named_and_its_values_are_found() -> None:
    """In recordings by the paper's law of a joint whose friction is a bristle with much damping.

    Each command stands for the step that follows it, as a controller holds it: it is the torque half a step later.
    """
    friction = Friction(1.8, 0.3, 0.5, 0.1)
    joint = Joint("A", "revolute", 0.3, 2.0, (0.15, 0.0), 0.02, 0.03, friction, friction, 20.0, 2e-5)
    arm = Arm("one joint", (0.0, 0.0), (joint,))
    rng, times = np.random.default_rng(5), np.arange(0.0, 8.0, 0.002)
    runs = []
    for k, slow in enumerate((0.4, 0.9, 0.6, 1.3)):
        rates, phases = slow * np.array([1.0, 2.3, 4.1]), rng.uniform(0.0, 6.28, 3)
        q, dq, ddq = (
            sum(0.2 / r * (r**n) * np.sin(r * times + f + n * np.pi / 2) for r, f in zip(rates, phases, strict=True))
            for n in range(3)
        )
        inertia = 0.02 + 2.0 * 0.15**2 + 0.03
        tau = (inertia * ddq + along(times, dq, 15.0) + 0.5 * dq)[1::2]
        recorded = np.round((q[::2] + 1e-5 * rng.standard_normal(len(tau))) / 2e-5) * 2e-5
        noisy = tau + 0.005 * rng.standard_normal(len(tau))
        runs.append(Run(f"run_{k}", times[::2], recorded[:, None], noisy[:, None]))
    found = diagnose(arm, runs, jobs=1)
    assert found.named == ("presliding",)
    (cause,) = [c for c in found.causes if c.effect == "presliding"]
    assert cause.law == {"A": "elasto_plastic"}
    assert cause.parameters["A"]["stiffness"].value == pytest.approx(STIFFNESS, rel=0.02)
    assert cause.parameters["A"]["damping"].value == pytest.approx(15.0, rel=0.05)
