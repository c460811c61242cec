"""Statistics whose unit is the block: numbering, bootstrap, t values, and how many rows count as one."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from scipy.signal import lfilter

from stribeck.gap.records.blocks import (
    LEAST_BLOCKS,
    bayesian_bootstrap,
    block_of_rows,
    block_sums,
    correlation_rows,
    resampled,
    t_value,
)

from ..conftest import conditioned


@settings(max_examples=20)
@given(
    seconds=st.lists(st.floats(1.0, 9.0), min_size=1, max_size=4),
    length=st.floats(0.3, 3.0),
    rate=st.sampled_from([100.0, 200.0]),
)
def test_blocks_never_span_runs(seconds: list[float], length: float, rate: float) -> None:
    runs = conditioned(seconds, rate)
    block = block_of_rows(runs, length)
    rows = [len(run.analysis_index) for run in runs]
    assert len(block) == sum(rows)
    assert set(np.diff(block)) <= {0, 1}  # numbered in order, none left out
    assert block[0] == 0
    start, before = 0, -1
    for run, count in zip(runs, rows, strict=True):
        own = block[start : start + count]
        start += count
        assert own[0] > before  # a run begins a new block
        before = own[-1]
        least = length / (run.decimation * run.sample_time)
        assert np.bincount(own)[own[0] :].min() >= min(least, count) - 1


def test_block_sums() -> None:
    rng = np.random.default_rng(0)
    block = np.array([0, 0, 1, 2, 2, 2])
    values = rng.normal(size=(6, 2))
    assert block_sums(values, block) == pytest.approx(np.array([values[:2].sum(0), values[2], values[3:].sum(0)]))


def test_bayesian_bootstrap() -> None:
    """Weights of mean one in every draw, exchangeable, of the spread of a flat Dirichlet distribution."""
    weights = bayesian_bootstrap(12, 4000, np.random.default_rng(0))
    assert weights.shape == (4000, 12)
    assert (weights >= 0.0).all()
    assert weights.mean(axis=1) == pytest.approx(np.ones(4000))
    assert weights.mean(axis=0) == pytest.approx(np.ones(12), abs=0.1)
    assert weights.var(axis=0) == pytest.approx(np.full(12, 11 / 13), rel=0.15)


def test_bootstrap_gives_the_standard_error() -> None:
    rng = np.random.default_rng(1)
    values = rng.normal(size=40)
    means = bayesian_bootstrap(40, 4000, rng) @ values / 40
    assert np.std(means) == pytest.approx(np.std(values) / np.sqrt(41), rel=0.05)


@given(st.lists(st.floats(-5.0, 5.0), min_size=2, max_size=30))
def test_t_value(differences: list[float]) -> None:
    values = np.array(differences)
    if np.ptp(values) > 1e-6:
        assert t_value(values) == pytest.approx(stats.ttest_1samp(values, 0.0).statistic, rel=1e-9)


def test_t_value_where_it_cannot_be_told() -> None:
    assert t_value(np.array([3.0])) == 0.0
    assert t_value(np.zeros(5)) == 0.0
    assert t_value(np.full(5, 2.0)) == np.inf
    assert t_value(np.full(5, -2.0)) == -np.inf


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9, 0.97])
def test_correlation_rows(rho: float) -> None:
    """A first-order process: (1 + rho) / (1 - rho) rows count as one, within 15 % on average."""
    runs = conditioned([60.0, 90.0])
    rows = sum(len(run.analysis_index) for run in runs)
    rng = np.random.default_rng(2)
    white = rng.standard_normal((rows, 12))
    found = correlation_rows(lfilter([1.0], [1.0, -rho], white, axis=0), runs)
    assert found.shape == (12,)
    assert np.mean(found) == pytest.approx((1 + rho) / (1 - rho), rel=0.15)


def test_runs_that_leave_nothing_do_not_make_rows_count_for_more() -> None:
    runs = conditioned([30.0] * 3)
    rows = len(runs[0].analysis_index)
    coloured = lfilter([1.0], [1.0, -0.9], np.random.default_rng(3).standard_normal((rows, 1)), axis=0)
    held = np.zeros((rows, 1))
    assert correlation_rows(np.concatenate([held, coloured, held]), runs) == correlation_rows(coloured, runs[:1])


def test_correlation_ends_with_the_run() -> None:
    """What two runs have in common does not count: each is looked at alone."""
    runs = conditioned([4.0] * 30)
    rows = [len(run.analysis_index) for run in runs]
    rng = np.random.default_rng(0)
    white = rng.standard_normal((sum(rows), 1))
    repeated = np.tile(rng.standard_normal((rows[0], 1)), (30, 1))
    assert correlation_rows(white, runs)[0] == pytest.approx(1.0, rel=0.25)
    assert correlation_rows(repeated, runs)[0] < 3.0


def test_correlation_is_at_least_one_row() -> None:
    runs = conditioned([30.0])
    rows = len(runs[0].analysis_index)
    alternating = (-1.0) ** np.arange(rows)
    assert correlation_rows(alternating[:, None], runs)[0] == 1.0
    assert correlation_rows(np.zeros((rows, 1)), runs)[0] == 1.0


def test_an_interval_of_a_short_run_has_a_width() -> None:
    """Less than two seconds are one block of a second, which drawn anew is always the same."""
    (run,) = conditioned([1.9])
    block, weights = resampled([run], 200, 0)
    assert int(block.max()) + 1 == 6
    drawn = weights @ block_sums(np.linspace(0.0, 1.0, len(block)), block) / len(block)
    assert np.std(drawn) > 0.05
    assert np.std(weights, axis=0).min() > 0.5
    long = conditioned([9.0, 4.0])
    assert np.array_equal(resampled(long, 10, 0)[0], block_of_rows(long))


@pytest.mark.parametrize("seconds", [[1.4] * 4, [1.9] * 4, [8.0], [2.0, 0.5]])
def test_there_are_blocks_enough_to_draw_from(seconds: list[float]) -> None:
    """However many recordings they lie in, of which each has whole ones."""
    block, draws = resampled(conditioned(seconds), 10, 0)
    assert int(block.max()) + 1 >= LEAST_BLOCKS
    assert draws.shape == (10, int(block.max()) + 1)
