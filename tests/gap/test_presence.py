"""Evidence of a taken effect, and the probability that follows: what must hold whatever the weights are."""

from dataclasses import fields, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stribeck.gap.presence import CENTRE, CERTAIN, Evidence, chance, evidence, explained, presence

FLOOR = np.array([0.1, 0.4])
STRONG = Evidence(t=2.3, gain=2.5, part=1.0, clear=1.0, further=0.0, further_gain=0.0)


def rows(*rms: float) -> np.ndarray:
    """Residual (M, n) of given rms (n,), signs mixed."""
    signs = np.where(np.arange(400) % 2, 1.0, -1.0)
    return np.asarray(signs[:, None] * np.array(rms))


def model(fit: np.ndarray, held: np.ndarray) -> Any:
    return SimpleNamespace(fit=SimpleNamespace(residual=fit), held=held)


def step(before: Any, after: Any, *, overall: float, t: float, probability: tuple[float, ...] = (0.0, 1.0)) -> Any:
    """A step that took the first of its rivals; the others were turned down."""
    power = np.array([np.mean(m.held**2, axis=0) / FLOOR**2 for m in (before, *[after] * (len(probability) - 1))])
    ranking = SimpleNamespace(
        probability=np.array(probability), best=1, overall=np.full(len(probability), overall),
        t=np.full(len(probability), t), power=power, twins=lambda: [1],
    )  # fmt: skip
    return SimpleNamespace(ranking=ranking, passing=(1,), base=before, best=after)


@given(st.sampled_from([field.name for field in fields(Evidence)][:4]), st.floats(0.01, 0.5))
def test_more_evidence_is_never_less_sure(figure: str, more: float) -> None:
    better = replace(CENTRE, **{figure: getattr(CENTRE, figure) + more})
    assert presence(CENTRE) < presence(better) < CERTAIN


def test_plain_and_poor_evidence() -> None:
    assert presence(STRONG) > 0.9
    assert presence(replace(STRONG, part=0.1, gain=0.2, t=1.1)) < 0.5  # a fifth less of a gap that stays
    assert presence(replace(STRONG, clear=0.0)) < presence(STRONG) - 0.1
    small = replace(STRONG, gain=0.3)
    assert presence(replace(small, further=1.0, further_gain=0.3)) < presence(small)  # what the first law does not fit


@given(st.floats(0.1, 2.0), st.floats(0.05, 1.0))
def test_a_further_effect_that_gains_more_is_surer(gain: float, more: float) -> None:
    small, large = (replace(CENTRE, gain=g, further=1.0, further_gain=g) for g in (gain, gain + more))
    assert presence(small) < presence(large)


def test_explained_is_the_part_above_the_floor() -> None:
    base, best = model(rows(1.0, 4.0), rows(1.0, 4.0)), model(rows(0.1, 0.4), rows(0.5, 4.0))
    assert explained(base, model(rows(0.1, 0.4), rows(0.1, 0.4)), FLOOR, 0) == pytest.approx(1.0)
    assert explained(base, base, FLOOR, 1) == 0.0
    assert explained(base, best, FLOOR, 0) == pytest.approx(
        1.0 - (25.0 - 1.0) / (100.0 - 1.0)
    )  # the held-out runs decide
    assert explained(base, best, FLOOR, 1) == 0.0
    assert explained(model(rows(0.05, 1.0), rows(0.05, 1.0)), base, FLOOR, 0) == 1.0  # there was no gap


def test_evidence_of_two_steps() -> None:
    first, then, last = (model(rows(a, 0.4), rows(a, 0.4)) for a in (1.0, 0.4, 0.1))
    taken = [step(first, then, overall=0.8, t=9.0), step(then, last, overall=0.5, t=4.0, probability=(0.0, 0.7, 0.3))]
    one, two = (evidence(taken, k, FLOOR) for k in range(2))
    assert one.t == pytest.approx(np.log(9.0))
    assert one.gain == pytest.approx(-np.log(0.2))
    assert one.part == two.part == pytest.approx(1.0)  # of all that was taken, in the end
    assert (one.further, one.further_gain) == (0.0, 0.0)
    assert (two.further, two.further_gain) == (1.0, pytest.approx(np.log(2.0)))
    assert two.clear == pytest.approx(0.7)  # the one that was turned down speaks against it
    assert chance(taken[1]) == pytest.approx(1.0)


def test_a_loss_and_a_perfect_fit_stay_finite() -> None:
    first, then = model(rows(1.0, 0.4), rows(1.0, 0.4)), model(rows(0.1, 0.4), rows(0.1, 0.4))
    for t, overall in ((-3.0, 0.1), (50.0, 1.0)):
        assert 0.0 <= presence(evidence([step(first, then, overall=overall, t=t)], 0, FLOOR)) < CERTAIN + 1e-9
