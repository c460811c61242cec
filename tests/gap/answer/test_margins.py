"""Intervals are wider than the fit's: by the law's form, by few blocks, and never across a known sign."""

import pytest

from stribeck.gap.answer.margins import COUNTED, FEW_BLOCKS, FORM, NORMAL, OF_A_SAMPLE, widened
from stribeck.gap.result import Estimate


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
    assert widened({"stiffness": Estimate(1.0, 0.05, 20.0, "N m/rad")}, 0.002)["stiffness"].low >= 0.0
