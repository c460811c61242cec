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
    assert f"A, forward: the recordings do not determine C2; {TAKEN[source]}" in said(source, ok=True)


def test_of_a_fit_that_failed_nothing_more_is_said() -> None:
    assert not any("do not determine" in text for text in said("nominal", ok=False))


def test_readings_need_no_whole_recordings() -> None:
    assert not any("do not determine" in text for text in said("curve", ok=True))
