"""Digits: as many as the interval supports, and never a false certainty."""

from __future__ import annotations

import math

import pytest

from stribeck.gap.result import Estimate
from stribeck.report.numbers import (
    as_written,
    change,
    estimate,
    interval,
    number,
    percent,
    percent_interval,
    probability,
    unit_text,
)


def plain(text):
    return text.replace("\u00a0", " ")


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1.9, "1.90"), (0.1, "0.100"), (0.0999999, "0.100"), (123456.0, "123000"), (1e7, "1.00 × 10⁷"), (-2.5, "−2.50"),
        (6e-6, "6.00 × 10⁻⁶"), (0.0, "0"), (math.nan, "not known"), (math.inf, "∞"), (9.999, "10.0"), (1234.5, "1230"),
    ],
)  # fmt: skip
def test_number(value, text):
    assert plain(number(value)) == text


@pytest.mark.parametrize(("part", "text"), [
    (-0.56, "−56 %"), (0.031, "+3.1 %"), (-2e-5, "0 %"), (0.0, "0 %"), (3e-4, "0 %"), (-1.0, "−100 %"),
])  # fmt: skip
def test_change(part: float, text: str) -> None:
    assert plain(change(part)) == text


@pytest.mark.parametrize(
    ("value", "texts"),
    [
        (Estimate(1502.31, 1411.2, 1594.0), ("1502", "1411 to 1594")),
        (Estimate(0.0123456, 0.0119, 0.0127), ("0.01235", "0.01190 to 0.01270")),
        (Estimate(4.81, 0.0, 9.7), ("4.8", "0 to 9.7")),
        (Estimate(1234567.0, 1e6, 1.5e6), ("1.23 × 10⁶", "1.00 × 10⁶ to 1.50 × 10⁶")),
        (Estimate(3.0, 3.0, 3.0), ("3.00", "exact")),
        (Estimate(3.0, -math.inf, math.inf), ("3.00", "not bounded")),
        (Estimate(3.0, 1.0, math.inf), ("3.00", "1.00 to ∞")),
        (Estimate(3.0, math.nan, math.nan), ("3.00", "not known")),
        (Estimate(-0.02, -0.05, 0.01), ("−0.020", "−0.050 to 0.010")),
        (Estimate(1.0000000013, 0.9999999975, 1.0000000051), ("1.00000", "1.00000 to 1.00000")),
        (Estimate(-3.302e-8, -2.036e-7, 1.376e-7), ("−3 × 10⁻⁸", "−2.0 × 10⁻⁷ to 1.4 × 10⁻⁷")),
        (Estimate(1.2e-5, 1.1e-5, 1.3e-5), ("1.20 × 10⁻⁵", "1.10 × 10⁻⁵ to 1.30 × 10⁻⁵")),
    ],
)
def test_estimate_has_the_digits_of_its_interval(value, texts):
    assert (plain(estimate(value)), plain(interval(value))) == texts


@pytest.mark.parametrize(
    ("part", "text"),
    [
        (0.62, "62 %"), (0.091, "9.1 %"), (0.0, "0 %"), (-0.052, "−5.2 %"), (1.0, "100 %"), (0.9999, "99.9 %"),
        (0.9962, "99.6 %"), (0.999998, "99.9 %"), (0.9999999, "100 %"), (-0.0001, "0 %"), (math.nan, "not known"),
    ],
)  # fmt: skip
def test_percent(part, text):
    assert plain(percent(part)) == text


def test_percent_interval_and_its_absence():
    assert plain(percent_interval(Estimate(0.91, 0.88, 0.934))) == "91 % (88 to 93 %)"
    assert plain(percent_interval(Estimate(0.91, math.nan, math.nan))) == "91 %"


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.97, "97 %"),
        (0.9999, "over 99.9 %"),
        (1.0, "over 99.9 %"),
        (0.993, "99.3 %"),
        (1e-5, "under 0.1 %"),
        (0.0, "0 %"),
    ],
)
def test_probability_never_reads_as_certainty(value, text):
    assert plain(probability(value)) == text


def test_units_and_values_as_written():
    assert plain(unit_text("kg m^2")) == "kg m²"
    assert unit_text("1") == ""
    assert [as_written(x) for x in (4.0, 0.17, 0.06, 200.0, 0.0)] == ["4", "0.17", "0.06", "200", "0"]
