"""Evidence of a taken effect, and the probability that follows: what must hold whatever the weights are."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stribeck.gap.search.presence import CENTRE, CERTAIN, FAINT, Evidence, evidence, presence

FLOOR = np.array([0.1, 0.4])
STRONG = Evidence(
    t=3.0, gain=4.0, size=4.0, removed=4.0, elusive=0.0, elusive_gain=0.0, left=0.0
)  # fmt: skip


def rows(*rms: float) -> np.ndarray:
    """Residual (M, n) of given rms (n,), signs mixed."""
    signs = np.where(np.arange(400) % 2, 1.0, -1.0)
    return np.asarray(signs[:, None] * np.array(rms))


def model(fit: np.ndarray, held: np.ndarray, *, elusive: bool = False) -> Any:
    last = SimpleNamespace(effect=SimpleNamespace(elusive=elusive))
    return SimpleNamespace(fit=SimpleNamespace(residual=fit), held=held, placed=(last,))


def ranking(before: Any, after: Any, *, overall: float, t: float) -> Any:
    power = np.array([np.mean(m.held**2, axis=0) / FLOOR**2 for m in (before, after)])
    return SimpleNamespace(best=1, overall=np.full(2, overall), t=np.full(2, t), power=power)


def step(before: Any, after: Any, *, overall: float, t: float, worth: Any = None) -> Any:
    """A step that took the only one of its rivals."""
    return SimpleNamespace(ranking=ranking(before, after, overall=overall, t=t), worth=worth, best=after)


@given(st.sampled_from(["t", "gain", "removed"]), st.floats(0.01, 0.5))
def test_more_evidence_is_never_less_sure(figure: str, more: float) -> None:
    better = replace(CENTRE, **{figure: getattr(CENTRE, figure) + more})
    assert presence(CENTRE) < presence(better) < CERTAIN


def test_plain_and_poor_evidence() -> None:
    assert presence(STRONG) > 0.9  # 98 % less, at twenty times its scatter
    assert presence(replace(STRONG, gain=0.2, t=1.1, left=1.9)) < 0.5  # a fifth less of a gap that stays
    assert presence(replace(STRONG, left=2.0)) < presence(STRONG)


@given(st.floats(0.1, 2.0), st.floats(0.05, 1.0))
def test_an_elusive_law_that_gains_more_is_surer(gain: float, more: float) -> None:
    """Small gains are what such laws always have; a large one is not."""
    small, large = (replace(CENTRE, gain=g, elusive=1.0, elusive_gain=g) for g in (gain, gain + more))
    assert presence(small) < presence(large)
    assert presence(replace(CENTRE, gain=0.1, elusive=1.0, elusive_gain=0.1)) < presence(replace(CENTRE, gain=0.1))


def test_an_effect_counts_by_its_worth_beside_the_others() -> None:
    """Taken first, it closed little of a gap that was mostly another's: without it, all the rest stays."""
    first, then, last = (model(rows(a, 0.4), rows(a, 0.4)) for a in (1.0, 0.8, 0.1))
    alone = step(first, then, overall=0.36, t=3.0)
    beside = step(first, then, overall=0.36, t=3.0, worth=ranking(then, last, overall=0.9, t=9.0))
    assert (evidence(alone).t, evidence(beside).t) == (pytest.approx(np.log(3.0)), pytest.approx(np.log(9.0)))
    assert (evidence(alone).gain, evidence(beside).gain) == (pytest.approx(-np.log(0.64)), pytest.approx(-np.log(0.1)))
    assert evidence(beside).size == pytest.approx(np.log(64.0))
    assert evidence(beside).removed == pytest.approx(np.log(63.0 + FAINT))
    assert presence(evidence(alone)) < presence(evidence(beside))


def test_evidence_of_an_elusive_law() -> None:
    first, then = model(rows(1.0, 0.4), rows(1.0, 0.4)), model(rows(0.4, 0.4), rows(0.4, 0.4), elusive=True)
    found = evidence(step(first, then, overall=0.8, t=9.0))
    assert (found.elusive, found.elusive_gain) == (1.0, found.gain)


def test_what_is_left_counts_where_most_is_left() -> None:
    first, then, better = (model(rows(1.0, b), rows(1.0, b)) for b in (1.6, 0.8, 0.4))
    assert evidence(step(first, then, overall=0.8, t=9.0)).left == pytest.approx(np.log(10.0))
    quiet = model(rows(0.1, 0.4), rows(0.1, 0.4))
    assert evidence(step(better, quiet, overall=0.8, t=9.0)).left == pytest.approx(0.0)


def test_a_loss_and_a_perfect_fit_stay_finite() -> None:
    first, then = model(rows(1.0, 0.4), rows(1.0, 0.4)), model(rows(0.1, 0.4), rows(0.1, 0.4))
    for t, overall in ((-3.0, 0.1), (50.0, 1.0)):
        assert 0.0 <= presence(evidence(step(first, then, overall=overall, t=t))) < CERTAIN + 1e-9
