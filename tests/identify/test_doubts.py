"""What an identification leaves open is said, with what is taken in its place."""

from types import SimpleNamespace

import numpy as np
import pytest

from stribeck.identify.doubts import TAKEN, left_open
from stribeck.identify.findings import JointFriction

from .bench import joint


def said(source: str, ok: bool) -> list[str]:
    """Return what is said of a direction of which whole recordings do not show C2."""
    curve = SimpleNamespace(ok=True, identified=np.ones(4, dtype=bool))
    sure = np.array([True, True, False, True])
    one = SimpleNamespace(sliding=0, curve=curve, source=source, runs_identified=sure)
    whole = SimpleNamespace(arm=joint(), rms=np.zeros(1), fit=SimpleNamespace(ok=ok, status="failed", at_limit=()))
    return left_open([JointFriction("A", {"forward": one}, None, None)], whole)  # type: ignore[arg-type,dict-item]


@pytest.mark.parametrize("source", ["nominal", "other direction"])
def test_constants_that_are_not_the_fit_s_own(source: str) -> None:
    assert f"A, forward: the recordings do not tell C2 to half the tolerance; {TAKEN[source]}" in said(source, ok=True)


def test_of_a_fit_that_failed_nothing_more_is_said() -> None:
    assert not any("do not tell" in text for text in said("nominal", ok=False))


def test_what_is_left_has_a_unit_and_a_measure() -> None:
    whole = SimpleNamespace(arm=joint(), rms=np.array([2.0]), fit=SimpleNamespace(ok=True, status="", at_limit=()))
    sure = SimpleNamespace(sliding=9, curve=None, source="curve", runs_identified=np.ones(4, dtype=bool))
    sure.curve = SimpleNamespace(ok=True, identified=np.ones(4, dtype=bool))
    told = left_open([JointFriction("A", {"forward": sure}, None, None)], whole)  # type: ignore[arg-type,dict-item]
    share = 2.0 / (whole.arm.joints[0].friction.C0 + whole.arm.joints[0].friction.C1)
    left = "A: friction and rigid body leave 2 N m rms of the torque along the recordings unexplained"
    assert told == [f"{left}, {100.0 * share:.0f} % of its break-away torque; try stribeck diagnose"]


def test_readings_need_no_whole_recordings() -> None:
    assert not any("do not tell" in text for text in said("curve", ok=True))
