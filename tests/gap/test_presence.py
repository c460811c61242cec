"""Evidence of a taken effect, and the probability that follows: what must hold whatever the weights are."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stribeck.gap.presence import CENTRE, CERTAIN, Evidence, chance, evidence, presence

FLOOR = np.array([0.1, 0.4])
STRONG = Evidence(
    t=3.0, gain=4.0, size=4.0, clear=1.0, further=0.0, elusive=0.0, elusive_gain=0.0
)  # fmt: skip


def rows(*rms: float) -> np.ndarray:
    """Residual (M, n) of given rms (n,), signs mixed."""
    signs = np.where(np.arange(400) % 2, 1.0, -1.0)
    return np.asarray(signs[:, None] * np.array(rms))


def model(fit: np.ndarray, held: np.ndarray, *, elusive: bool = False) -> Any:
    last = SimpleNamespace(effect=SimpleNamespace(elusive=elusive))
    return SimpleNamespace(fit=SimpleNamespace(residual=fit), held=held, placed=(last,))


def step(before: Any, after: Any, *, overall: float, t: float, probability: tuple[float, ...] = (0.0, 1.0)) -> Any:
    """A step that took the first of its rivals; the others were turned down."""
    power = np.array([np.mean(m.held**2, axis=0) / FLOOR**2 for m in (before, *[after] * (len(probability) - 1))])
    ranking = SimpleNamespace(
        probability=np.array(probability), best=1, overall=np.full(len(probability), overall),
        t=np.full(len(probability), t), power=power, twins=lambda: [1],
    )  # fmt: skip
    return SimpleNamespace(ranking=ranking, passing=(1,), base=before, best=after)


@given(st.sampled_from(["t", "gain", "clear"]), st.floats(0.01, 0.5))
def test_more_evidence_is_never_less_sure(figure: str, more: float) -> None:
    better = replace(CENTRE, **{figure: getattr(CENTRE, figure) + more})
    assert presence(CENTRE) < presence(better) < CERTAIN


def test_plain_and_poor_evidence() -> None:
    assert presence(STRONG) > 0.9  # 98 % less, at twenty times its scatter
    assert presence(replace(STRONG, size=4.0, gain=0.2, t=1.1)) < 0.5  # a fifth less of a gap that stays
    assert presence(replace(STRONG, clear=0.0)) < presence(STRONG) - 0.1
    small = replace(STRONG, gain=0.3)
    assert presence(replace(small, further=1.0)) < presence(small)  # what the first law does not fit


@given(st.floats(0.1, 2.0), st.floats(0.05, 1.0))
def test_an_elusive_law_that_gains_more_is_surer(gain: float, more: float) -> None:
    """Small gains are what such laws always have; a large one is not."""
    small, large = (replace(CENTRE, gain=g, elusive=1.0, elusive_gain=g) for g in (gain, gain + more))
    assert presence(small) < presence(large)
    assert presence(replace(CENTRE, gain=0.1, elusive=1.0, elusive_gain=0.1)) < presence(replace(CENTRE, gain=0.1))


def test_evidence_of_two_steps() -> None:
    first, then, last = (model(rows(a, 0.4), rows(a, 0.4)) for a in (1.0, 0.4, 0.1))
    taken = [step(first, then, overall=0.8, t=9.0), step(then, last, overall=0.5, t=4.0, probability=(0.0, 0.7, 0.3))]
    one, two = (evidence(taken, k) for k in range(2))
    assert one.t == pytest.approx(np.log(9.0))
    assert one.gain == pytest.approx(-np.log(0.2))
    assert (one.size, two.size) == (pytest.approx(np.log(100.0)), pytest.approx(np.log(16.0)))
    assert (one.further, two.further) == (0.0, 1.0)
    assert two.clear == pytest.approx(0.7)  # the one that was turned down speaks against it
    assert chance(taken[1]) == pytest.approx(1.0)
    assert (one.elusive, one.elusive_gain) == (0.0, 0.0)


def test_evidence_of_an_elusive_law() -> None:
    first, then = model(rows(1.0, 0.4), rows(1.0, 0.4)), model(rows(0.4, 0.4), rows(0.4, 0.4), elusive=True)
    found = evidence([step(first, then, overall=0.8, t=9.0)], 0)
    assert (found.elusive, found.elusive_gain) == (1.0, found.gain)


def test_a_loss_and_a_perfect_fit_stay_finite() -> None:
    first, then = model(rows(1.0, 0.4), rows(1.0, 0.4)), model(rows(0.1, 0.4), rows(0.1, 0.4))
    for t, overall in ((-3.0, 0.1), (50.0, 1.0)):
        assert 0.0 <= presence(evidence([step(first, then, overall=overall, t=t)], 0)) < CERTAIN + 1e-9
