"""Waves in a residual: where a periodic law and one that rings may start."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.effects.registry import effect_named
from stribeck.model.scale import Scale
from stribeck.model.waves import Trace, ringing, strongest_waves, tones

STEP = 0.02


def traced(residual: np.ndarray, runs: int) -> Trace:
    t = np.tile(STEP * np.arange(len(residual) // runs), runs)
    zero = np.zeros_like(t)
    return Trace(t, zero, zero, zero, residual, tuple(range(len(t) // runs, len(t), len(t) // runs)))


def test_strongest_wave() -> None:
    t = np.tile(STEP * np.arange(500), 2)
    trace = traced(2.0 * np.sin(7.0 * t) + 0.5 * np.cos(19.0 * t), 2)
    first, second = strongest_waves(t, np.ones_like(t), trace, (1.0, 40.0), count=2)
    assert (first.rate, second.rate) == pytest.approx((7.0, 19.0), abs=0.1)
    for wave, size in ((first, 2.0), (second, 0.5)):  # between two rates of the grid
        assert np.hypot(wave.sine, wave.cosine) == pytest.approx(size, rel=0.1)


def test_in_proportion_to_nothing_there_is_a_wave_of_no_size() -> None:
    """A joint without a drive has a command of zero, and torque ripple in proportion to that."""
    x = np.linspace(0.0, 6.0, 500)
    waves = strongest_waves(x, np.zeros_like(x), traced(np.sin(3.0 * x), 1), (0.5, 9.0))
    assert waves
    assert all((wave.sine, wave.cosine) == (0.0, 0.0) for wave in waves)


@pytest.mark.parametrize("hertz", [2.74, 5.3, 8.1])
def test_a_tone_is_not_sought_at_its_aliases(hertz: float) -> None:
    """Twenty samples a second, as of a coarse encoder, show no more than ten hertz: above, each tone comes again."""
    t = np.tile(0.05 * np.arange(160), 3)
    trace = replace(traced(np.sin(2 * np.pi * hertz * t + 0.3), 3), time=t)
    assert [wave.rate for wave in tones(trace, (0.3, 25.0), count=1)] == pytest.approx([hertz], abs=0.05)
    assert all(wave.rate < 10.0 for wave in tones(trace, (0.3, 25.0), count=5))


def test_a_tone_in_a_long_record_is_not_taken_for_its_alias() -> None:
    """Of many samples some are looked at, at unequal distances; the line is narrow, and may not be stepped over."""
    t = 0.01 * np.arange(24000)
    trace = replace(traced(np.sin(2 * np.pi * 17.3 * t), 1), time=t)
    assert [wave.rate for wave in tones(trace, (0.3, 25.0), count=1)] == pytest.approx([17.3], abs=0.003)


def test_ringing_is_found_whatever_its_phases() -> None:
    """Shocks at any time, each of which rings down anew: no wave goes through, the spectrum shows it."""
    rng = np.random.default_rng(2)
    rows, runs = 800, 3
    t = STEP * np.arange(rows)
    parts = []
    for _ in range(runs):
        since = [np.maximum(t - at, 0.0) for at in rng.uniform(0.0, 14.0, 8)]
        parts.append(sum(rng.normal() * np.exp(-1.5 * s) * np.sin(2 * np.pi * 3.3 * s) for s in since))
    residual = np.concatenate(parts) + 0.05 * rng.standard_normal(runs * rows)
    found = ringing(traced(residual, runs), (0.8, 20.0))
    assert found[0] == pytest.approx(3.3, rel=0.1)
    assert len(found) == 2
    assert ringing(traced(residual, runs), (5.0, 20.0), count=1)[0] > 5.0
    assert ringing(traced(np.zeros(60), 3), (0.8, 20.0)) == []


def test_an_axis_in_metres_is_searched_by_its_travel() -> None:
    """A screw of 20 mm lead over 0.4 m: no turn says how often what is periodic repeats."""
    turning = Scale(1.0, 1.0, 1.0, 1.8, 1.0, 1e-3)
    axis = replace(turning, travel=0.4, prismatic=True)
    assert turning.rates(60.0) == (1.0, 60.0)
    low, high = axis.rates(60.0)
    assert low < 2.0 * np.pi / 0.4 < 2.0 * np.pi / 0.02 < high
    x = 0.2 * np.sin(np.linspace(0.0, 40.0, 4000))
    rate = 2.0 * np.pi / 0.02
    trace = Trace(np.arange(4000.0), x, np.cos(np.linspace(0.0, 40.0, 4000)), np.ones(4000), 3.0 * np.sin(rate * x))
    for name in ("cogging", "torque_ripple"):
        assert min(abs(s["harmonic"] / rate - 1.0) for s in effect_named(name).starts_from(axis, trace)) < 0.01
    rough = replace(trace, residual=trace.residual * np.sign(trace.velocity))
    starts = effect_named("position_dependent_friction").starts_from(axis, rough)
    assert min(abs(s["harmonic"] / rate - 1.0) for s in starts) < 0.01


@pytest.mark.parametrize("name", ["cogging", "torque_ripple"])
def test_a_wave_generator_of_a_gear_is_in_sight(name: str) -> None:
    """100 and 200 cycles a turn, over slow strokes to and fro: one of the starts has them."""
    t = STEP * np.arange(3000)
    position = 0.8 * np.sin(0.15 * t)
    velocity, command = np.gradient(position, STEP), np.cos(0.4 * t)
    carrier = {"cogging": np.ones_like(t), "torque_ripple": command}[name]
    scale = Scale(1.0, 1.0, 0.1, 1.6, 1.0, 1e-3, covered=1.6)
    for rate in (100.0, 200.0):
        trace = Trace(t, position, velocity, command, carrier * np.sin(rate * position + 0.4), ())
        found = [start["harmonic"] for start in effect_named(name).starts_from(scale, trace)]
        assert min(found, key=lambda harmonic: abs(harmonic - rate)) == pytest.approx(rate, abs=0.5)
