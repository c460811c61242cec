"""The version in files and on pages, and numbers as JSON has them."""

import importlib.metadata
import math

import pytest

from stribeck import version
from stribeck.rounding import rounded
from stribeck.version import package_version


def test_it_is_that_of_the_package_where_it_is_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(version, "version", {"stribeck": "1.2.3"}.__getitem__)
    assert package_version() == "1.2.3"


def test_sources_that_are_not_installed_have_an_unknown_one(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> str:
        raise importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(version, "version", missing)
    assert package_version() == "unknown"


@pytest.mark.parametrize(
    ("value", "digits", "found"),
    [(1.0 / 3.0, 6, 0.333333), (123456789.0, 6, 123457000.0), (1.0 / 3.0, 8, 0.33333333), (-2.0, 6, -2.0)],
)
def test_numbers_have_so_many_significant_digits(value: float, digits: int, found: float) -> None:
    assert rounded(value, digits) == found


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_null(value: float) -> None:
    assert rounded(value, 6) is None
