"""Whether one joint's rounds die out."""

import numpy as np
import pytest

from stribeck.loop.exact.turns import CREEP, TINY, dies_out


def rounds(*spread: float) -> np.ndarray:
    """Turns whose rounds span twice these, rad."""
    out = np.zeros(len(spread), dtype=[("low", float), ("high", float)])
    out["low"], out["high"] = -np.array(spread), np.array(spread)
    return out


def test_a_tiny_turn_among_large_ones_is_no_rest():
    assert not dies_out(rounds(0.1, 0.1, 0.1, 0.1, 0.1, 0.09 * TINY))  # where it stops, a sampled joint turns once more
    assert not dies_out(rounds(0.1, 0.05, 0.02, 2.0 * CREEP, 0.1 * CREEP, 0.1 * TINY))


@pytest.mark.parametrize("first", [0.1 * CREEP, 0.5 * CREEP])
def test_small_rounds_that_vanish_are_rest(first):
    assert dies_out(rounds(0.1, 0.01, first, 0.1 * first, 0.01 * first, 0.1 * TINY))
    assert dies_out(rounds(*(first * 0.9**k for k in range(10))))
    assert not dies_out(rounds(*(first * 1.1**k for k in range(10))))
