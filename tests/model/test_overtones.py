"""Waves with overtones: their sums, and where a fit of them starts."""

import casadi as ca
import numpy as np
import pytest

from stribeck.effects.external.input_disturbance_harmonics import ORDER, InputDisturbanceHarmonics
from stribeck.model.overtones import faster_wave, slower_wave, two_waves
from stribeck.model.values import Signals

PHASES = np.linspace(-2.0, 5.0, 11)


def value(phase: float, p: dict[str, float]) -> float:
    return float(ca.evalf(two_waves(ca.SX(phase), p)))


def test_the_second_wave_turns_twice_as_fast() -> None:
    p = {"sine": 0.3, "cosine": -0.2, "second_sine": 0.05, "second_cosine": 0.07, "harmonic": 1.0}
    for phase in PHASES:
        expected = np.imag((0.3 - 0.2j) * np.exp(1j * phase) + (0.05 + 0.07j) * np.exp(2j * phase))
        assert value(phase, p) == pytest.approx(expected, abs=1e-12)


def test_a_wave_is_the_same_taken_for_either_of_the_two() -> None:
    for position in PHASES:
        expected = 0.3 * np.sin(7.0 * position) - 0.2 * np.cos(7.0 * position)
        for p in (slower_wave(0.3, -0.2, 7.0), faster_wave(0.3, -0.2, 7.0)):
            assert value(p["harmonic"] * position, p) == pytest.approx(expected, abs=1e-12)


def test_a_periodic_disturbance_is_its_fourier_series() -> None:
    p = {f"{order}{part}": 0.1 * i for i, order in enumerate(ORDER, 1) for part in ("sine", "cosine")}
    for t in PHASES:
        signals = Signals(ca.SX(t), 0.0, 0.0, 0.0, 0.0, 0.0)
        torque = float(ca.evalf(InputDisturbanceHarmonics().torque(signals, {}, {**p, "frequency": 0.4})))
        phase = 2.0 * np.pi * 0.4 * t
        expected = sum(0.1 * i * (np.sin(i * phase) + np.cos(i * phase)) for i in (1, 2, 3))
        assert torque == pytest.approx(expected, abs=1e-12)
