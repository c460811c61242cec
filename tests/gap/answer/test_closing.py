"""How much of a gap is closed: the contract's formula, one effect's part of it, and the intervals of both."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stribeck.effects.registry import effect_named
from stribeck.gap.answer.closing import Closing, closable, closed_again, closure, with_interval
from stribeck.gap.records.blocks import bayesian_bootstrap
from stribeck.model.layout import Placed

FLOOR = np.array([0.1, 0.4])
EFFECTS = ("delay", "cogging", "payload", "torque_gain")


def rows(*rms: float) -> np.ndarray:
    """Residual (M, n) of given rms (n,), signs mixed."""
    signs = np.where(np.arange(400) % 2, 1.0, -1.0)
    return np.asarray(signs[:, None] * np.array(rms))


@given(st.lists(st.floats(0.5, 5.0), min_size=2, max_size=2), st.lists(st.floats(1.05, 20.0), min_size=2, max_size=2))
def test_closure(after: list[float], factor: list[float]) -> None:
    """1 - (after^2 - floor^2) / (before^2 - floor^2), joints scaled by their floors, as the contract has it."""
    first, last = FLOOR * np.array(after) * np.array(factor) * 1.1, FLOOR * np.array(after)
    found = closure(rows(*first), rows(*last), FLOOR)
    left, was = (np.sum((x / FLOOR) ** 2 - 1.0) for x in (last, first))
    if was > 0.01:
        assert found == pytest.approx(1.0 - max(left, 0.0) / was, abs=1e-9)


def test_a_joint_that_brakes_hold_in_all_held_out_runs_takes_nothing_off() -> None:
    """It leaves nothing, over a floor of nothing."""
    one, both = FLOOR[:1], np.array([FLOOR[0], 1e-12])
    before, after = (np.stack([np.full(20, size * FLOOR[0]), np.zeros(20)], axis=1) for size in (2.0, 1.4))
    assert closable(before, both) == pytest.approx(closable(before[:, :1], one))
    assert closure(before, after, both) == pytest.approx(closure(before[:, :1], after[:, :1], one))
    block, draws = np.arange(20) // 5, np.ones((3, 4))
    alone = closed_again(before[:, :1], after[:, :1], one, block, draws)
    assert closed_again(before, after, both, block, draws) == pytest.approx(alone)
    still = closed_again(before[:, 1:], after[:, 1:], both[1:], block, draws)
    assert np.all(np.isfinite(still))


def test_closure_in_numbers() -> None:
    before, after = rows(0.5, 0.8), rows(0.2, 0.8)
    assert closure(before, after, FLOOR) == pytest.approx(1.0 - (3.0 + 3.0) / (24.0 + 3.0))
    assert closure(before, before, FLOOR) == pytest.approx(0.0)
    assert closure(before, rows(0.1, 0.4), FLOOR) == pytest.approx(1.0)
    assert closure(before, rows(1.0, 1.6), FLOOR) < 0.0  # worse than before is said as it is


def test_nothing_to_close() -> None:
    """Below the floor there is no gap; nothing is divided by nothing."""
    assert np.isfinite(closure(rows(0.05, 0.1), rows(0.05, 0.1), FLOOR))
    assert closable(rows(0.05, 0.4), FLOOR) < 0.0 < closable(rows(0.15, 0.4), FLOOR)


def test_interval_of_the_closed_part() -> None:
    rng = np.random.default_rng(0)
    block = np.arange(400) // 20
    draws = bayesian_bootstrap(20, 400, rng)
    uneven = np.repeat(rng.uniform(0.2, 2.0, 20), 20)[:, None]
    before, after = rows(0.5, 0.8) * uneven, rows(0.2, 0.8)
    found = with_interval(closure(before, after, FLOOR), closed_again(before, after, FLOOR, block, draws))
    assert found.low < found.value < found.high
    even = closed_again(rows(0.5, 0.8), after, FLOOR, block, draws)
    assert np.ptp(even) < 1e-9  # blocks that are all alike leave nothing unsure
    assert even == pytest.approx(closure(rows(0.5, 0.8), after, FLOOR))


def chain_of(effects: int) -> list[Any]:
    """The re-tuned model, and one more for each effect."""
    return [SimpleNamespace(placed=(Placed(effect_named(e), 0),) if e else ()) for e in (None, *EFFECTS[:effects])]


def of_blocks(monkeypatch: pytest.MonkeyPatch, chain: list[Any], left: list[np.ndarray]) -> Closing:
    """What models close that leave this (90, 1) each, over a floor of one and nine blocks."""
    by_model = {id(model): each for model, each in zip(chain, left, strict=True)}
    monkeypatch.setattr(Closing, "left", lambda _, model: by_model[id(model)])
    noise: Any = SimpleNamespace(floor=np.ones(1))
    draws = bayesian_bootstrap(9, 400, np.random.default_rng(1))
    return Closing(chain[0], noise, np.repeat(np.arange(9), 10), draws)


def drawn_so(monkeypatch: pytest.MonkeyPatch, chain: list[Any], closed: list[tuple[float, float, float]]) -> Closing:
    """What models close: a value, and what it is in eighty draws, one of two bounds."""
    value = {
        id(m): np.array([v, *np.repeat([low, high], 40)]) for m, (v, low, high) in zip(chain[1:], closed, strict=True)
    }
    monkeypatch.setattr(Closing, "_drawn", lambda _, model: value[id(model)])
    noise: Any = None
    return Closing(chain[0], noise, np.zeros(1), np.ones((80, 1)))


@pytest.mark.parametrize(("width", "high"), [(0.04, 0.98), (0.4, 1.0)])
def test_no_effect_closes_more_than_there_is(monkeypatch: pytest.MonkeyPatch, width: float, high: float) -> None:
    chain = chain_of(1)
    closing = drawn_so(monkeypatch, chain, [(0.96, 0.96 - width / 2, 0.96 + width / 2)])
    closes = closing.by_effect("delay", chain)
    assert closes.high == pytest.approx(high)
    assert closes.low == pytest.approx(0.96 - width / 2)


def test_the_only_effect_closes_what_is_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the same interval, which is not symmetrical; and what several close adds up, draw by draw."""
    chain, size = chain_of(2), np.random.default_rng(0).uniform(0.2, 3.0, (90, 1))
    closing = of_blocks(monkeypatch, chain, [size**k * left for k, left in enumerate((3.0, 1.5, 1.2))])
    alone = closing.by_effect("delay", chain[:2])
    assert alone == closing.by(chain[1])
    assert abs(alone.high + alone.low - 2.0 * alone.value) > 0.01 * (alone.high - alone.low)
    first, second = (closing.by_effect(name, chain) for name in ("delay", "cogging"))
    assert first == alone
    assert first.value + second.value == pytest.approx(closing.by(chain[2]).value)
    assert second.low < second.value < second.high < 0.0  # it makes it worse, in every draw


@pytest.mark.parametrize(("more", "low"), [(1.01, -1.0), (1.2, None)])
def test_a_draw_without_a_gap_tells_no_number(monkeypatch: pytest.MonkeyPatch, more: float, low: float | None) -> None:
    """Little above the floor, any part of nothing: an interval had reached down to -6e9 per cent."""
    chain, size = chain_of(1), np.random.default_rng(0).uniform(0.2, 1.65, (90, 1))
    closes = of_blocks(monkeypatch, chain, [size, more * size]).by(chain[1])
    assert closes.low == (closes.value if low is None else low)
    assert closes.low <= closes.value < 0.0


def test_no_effect_closes_more_than_the_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nor does the interval of what it closes, which is of what it closes draw by draw."""
    chain = chain_of(4)
    closing = drawn_so(monkeypatch, chain, [(v, v - 0.1, v + 0.02) for v in (0.98, -0.1, 0.5, 1.0)])
    found = {effect: closing.by_effect(effect, chain) for effect in EFFECTS}
    assert (found["delay"].value, found["delay"].high) == (0.98, 1.0)
    assert found["delay"].low == pytest.approx(0.98 - 0.1)
    assert found["payload"].value == pytest.approx(0.6)
    assert all(estimate.low <= estimate.value <= estimate.high <= 1.0 for estimate in found.values())
