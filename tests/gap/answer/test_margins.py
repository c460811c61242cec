"""Intervals are wider than the fit's: by the law's form, by few blocks, and never beyond what a parameter can be."""

import math

import pytest

from stribeck.effects.registry import registry
from stribeck.gap.answer import margins
from stribeck.gap.answer.margins import COUNTED, FEW_BLOCKS, FORM, NORMAL, OF_A_SAMPLE
from stribeck.gap.result import Estimate

FREE = (-math.inf, math.inf)


def widened(
    found: dict[str, Estimate], sample_time: float, bounds: dict[str, tuple[float, float]] | None = None
) -> dict[str, Estimate]:
    return margins.widened(found, dict.fromkeys(found, FREE) if bounds is None else bounds, sample_time)


def test_an_exact_fit_keeps_the_law_in_doubt() -> None:
    found = widened({"stiffness": Estimate(100.0, 100.0, 100.0, "N m/rad")}, 0.002)["stiffness"]
    assert found.high - found.value == pytest.approx(NORMAL * FORM * 100.0)
    assert found.value - found.low == pytest.approx(NORMAL * FORM * 100.0)


def test_a_wide_interval_grows_by_its_factor() -> None:
    found = widened({"offset": Estimate(0.001, -10.0, 10.0, "N m")}, 0.002)["offset"]
    assert found.high == pytest.approx(0.001 + FEW_BLOCKS * 9.999, rel=1e-6)


def test_a_wave_has_one_amplitude() -> None:
    pair = {"sine": Estimate(1.0, 1.0, 1.0, "N m"), "cosine": Estimate(0.0, 0.0, 0.0, "N m")}
    found = widened(pair, 0.002)
    assert found["cosine"].high == pytest.approx(NORMAL * FORM)


@pytest.mark.parametrize("unit", ["1/rad", "1/m", "Hz"])
def test_how_many_waves_there_are_no_laws_shape_alters(unit: str) -> None:
    found = widened({"harmonic": Estimate(12.0, 12.0, 12.0, unit)}, 0.002)["harmonic"]
    assert found.high - 12.0 == pytest.approx(NORMAL * COUNTED[unit] * 12.0)
    assert found.high - 12.0 < 0.01 * 12.0


def test_a_time_is_known_to_a_part_of_a_sample() -> None:
    found = widened({"time": Estimate(0.0, 0.0, 0.0, "s")}, 0.01)["time"]
    assert found.high == pytest.approx(NORMAL * OF_A_SAMPLE * 0.01)


def test_a_stiffness_stays_positive() -> None:
    bounds = {"stiffness": (1e-2, 1e8), "damping": (0.0, math.inf)}
    found = {"stiffness": Estimate(1.0, 0.05, 20.0, "N m/rad"), "damping": Estimate(0.0, 0.0, 3.0, "N m s/rad")}
    wide = widened(found, 0.002, bounds)
    assert [wide[name].low for name in found] == [1e-2, 0.0]


@pytest.mark.parametrize("size", [0.05, 0.69])
def test_mirrored_recordings_have_mirrored_intervals(size: float) -> None:
    """A wave may be of either sign, however surely it is of one."""
    bounds = {p.name: (p.lower, p.upper) for p in registry()["torque_ripple"].parameters if p.unit == "1"}
    exact = {"sine": (size, 0.98 * size, 1.02 * size), "cosine": (0.0013, 0.001, 0.0016)}
    up, down = (
        widened({name: Estimate(*with_sign(s, values), "1") for name, values in exact.items()}, 0.002, bounds)
        for s in (1.0, -1.0)
    )
    assert up["cosine"].low < 0.0
    assert up["sine"].high <= 0.7
    for name in exact:
        assert (down[name].low, down[name].high) == pytest.approx((-up[name].high, -up[name].low))


def with_sign(sign: float, values: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return value, low and high with another sign."""
    value, low, high = values
    return (value, low, high) if sign > 0.0 else (-value, -high, -low)
