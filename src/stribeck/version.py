"""The version that files and pages say they were written by."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version


def package_version() -> str:
    """Return the version of the installed package; "unknown" where it is run from its sources, not installed."""
    try:
        return version("stribeck")
    except PackageNotFoundError:
        return "unknown"
