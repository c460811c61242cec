"""Intervals that hold with coloured residuals: how often they cover the truth, counted."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from stribeck.identify.confidence import Intervals, intervals
from stribeck.identify.map_fit import Fit
from stribeck.identify.problem import Weights
from stribeck.model.layout import Entry

ROWS, JOINTS, BLOCK = 1200, 2, 60
TRUTH = np.array([2.0, -0.7, 0.4])
BLOCKS = np.arange(ROWS) // BLOCK


def entries(sd: float = np.inf, lower: float = -np.inf, log: bool = False) -> tuple[Entry, ...]:
    return tuple(Entry(f"p{i}", 0, f"p{i}", "1", 0.0, sd, lower, np.inf, log, "friction") for i in range(3))


def design(rng: np.random.Generator) -> np.ndarray:
    """Regressors (M, n, 3) that are themselves coloured, as those of a motion are."""
    return np.asarray(lfilter([1.0], [1.0, -0.9], rng.standard_normal((ROWS, JOINTS, 3)), axis=0))


def noise(rng: np.random.Generator, rho: float) -> np.ndarray:
    return np.asarray(lfilter([1.0], [1.0, -rho], rng.standard_normal((ROWS, JOINTS)), axis=0) * [0.5, 2.0])


def estimate(columns: np.ndarray, y: np.ndarray, weights: Weights, sd: float = np.inf) -> Fit:
    """The fit of a linear model, solved directly; residual = measured - needed, its Jacobian minus the columns."""
    flat = (columns * weights.scale[None, :, None]).reshape(-1, 3)
    hessian = flat.T @ flat + (np.eye(3) / sd**2 if np.isfinite(sd) else 0.0)
    p = np.linalg.solve(hessian, flat.T @ (y * weights.scale).ravel())
    return Fit(entries(sd), p, np.arange(3), y - columns @ p, -columns, 0.0, 0.0, "Solve_Succeeded", ())


def repeated(rho: float, blocks: np.ndarray, repeats: int = 200) -> tuple[np.ndarray, np.ndarray]:
    """Share of intervals that cover, and their mean half width over the estimate's spread, each (3,)."""
    columns = design(np.random.default_rng(0))
    weights = Weights(np.array([1.0, 4.0]), np.array([10.0, 10.0]))
    covered, half, found = [], [], []
    for seed in range(repeats):
        fit = estimate(columns, columns @ TRUTH + noise(np.random.default_rng([1, seed]), rho), weights)
        bounds = intervals(fit, weights, blocks)
        covered.append((bounds.low <= TRUTH) & (bounds.high >= TRUTH))
        half.append((bounds.high - bounds.low) / 2)
        found.append(fit.p)
    return np.mean(covered, axis=0), np.mean(half, axis=0) / np.std(found, axis=0)


@pytest.mark.parametrize("rho", [0.0, 0.9])
def test_coverage(rho: float) -> None:
    covered, width = repeated(rho, BLOCKS)
    assert (covered >= 0.88).all()
    assert (covered <= 0.99).all()
    assert (width < 2.6).all()  # and not by being wide: 1.96 is the least


def test_rows_as_blocks_would_not_hold() -> None:
    """The same intervals with every row its own block: what taking residuals for white does."""
    covered, _ = repeated(0.9, np.arange(ROWS), 60)
    assert covered.mean() < 0.85


def one(
    sd: float = np.inf, lower: float = -np.inf, p: np.ndarray | None = None, scale: float = 1.0, log: bool = False
) -> Intervals:
    rng = np.random.default_rng(3)
    columns = design(rng) * scale
    weights = Weights(np.ones(2), np.ones(2))
    fit = estimate(columns, columns @ TRUTH + noise(rng, 0.5), weights, sd)
    values = fit.p if p is None else p
    fit = Fit(entries(sd, lower, log), values, fit.free, fit.residual, fit.jacobian, 0.0, 0.0, "ok", ())
    return intervals(fit, weights, BLOCKS)


def test_prior_alone_gives_the_prior_interval() -> None:
    """Regressors next to nothing: the interval is the tolerance's, and the value counts as not identified."""
    bounds = one(sd=0.3, scale=1e-6)
    assert bounds.high - bounds.low == pytest.approx(2 * 2.093 * 0.3, rel=1e-3)  # Student's t for 20 blocks
    assert not bounds.identified.any()
    assert one(sd=0.3).identified.all()


def test_value_at_its_bound_reaches_away_from_it_alone() -> None:
    values = np.array([2.0, 0.0, 0.4])
    bounds, free = one(lower=0.0, p=values), one(p=values)
    assert bounds.low[1] == 0.0
    assert bounds.high[1] == free.high[1] > 0.0
    assert bounds.high[0] > bounds.low[0]


@pytest.mark.parametrize(("scale", "sure"), [(1.0, True), (1e-6, False)])
def test_a_bound_is_no_identification(scale: float, sure: bool) -> None:
    assert one(sd=0.3, lower=0.0, p=np.array([2.0, 0.0, 0.4]), scale=scale).identified[1] == sure


def without_second(fit: Fit) -> Fit:
    """Return a fit whose residual does not know its second value."""
    return replace(fit, jacobian=fit.jacobian * np.array([1.0, 0.0, 1.0]))


def clipped(columns: np.ndarray, y: np.ndarray, weights: Weights) -> Fit:
    """Return the fit of a linear model whose second value is held at its bound, 0."""
    found = estimate(columns * np.array([1.0, 0.0, 1.0]), y, weights, sd=1e6)
    return replace(found, entries=entries(lower=0.0), jacobian=-columns)


def held_where_noise_takes_the_second_to_its_bound(columns: np.ndarray, truth: np.ndarray, k: int) -> list[bool]:
    """Whether the interval of value ``k`` holds the truth, in each draw of noise that takes the second to its bound."""
    weights, held = Weights(np.ones(2), np.ones(2)), []
    for seed in range(60):
        y = columns @ truth + noise(np.random.default_rng([1, seed]), 0.5)
        if estimate(columns, y, weights).p[1] < 0.0:
            bounds = intervals(clipped(columns, y, weights), weights, BLOCKS)
            held.append(bool(bounds.low[k] <= truth[k] <= bounds.high[k]))
    return held


def test_a_small_value_that_noise_takes_to_its_bound_is_covered() -> None:
    columns = design(np.random.default_rng(0))
    held = held_where_noise_takes_the_second_to_its_bound(columns, np.array([2.0, 0.004, 0.4]), 1)
    assert len(held) > 10
    assert np.mean(held) > 0.9


def test_others_are_as_uncertain_as_a_value_that_noise_alone_takes_to_its_bound() -> None:
    """It is hard to tell from the first, whose interval would miss the truth were it held."""
    columns = design(np.random.default_rng(0))
    columns[..., 0] = columns[..., 1] + 0.05 * columns[..., 0]
    held = held_where_noise_takes_the_second_to_its_bound(columns, np.array([2.0, 0.05, 0.4]), 0)
    assert len(held) > 10
    assert np.mean(held) > 0.9


def test_others_know_a_value_that_is_surely_at_its_bound() -> None:
    rng, weights = np.random.default_rng(3), Weights(np.ones(2), np.ones(2))
    columns = design(rng)
    found = clipped(columns, columns @ TRUTH + noise(rng, 0.5), weights)
    bounds, known = intervals(found, weights, BLOCKS), intervals(without_second(found), weights, BLOCKS)
    for one in (0, 2):
        assert (bounds.low[one], bounds.high[one]) == pytest.approx((known.low[one], known.high[one]), rel=1e-9)


def test_level() -> None:
    rng = np.random.default_rng(3)
    columns = design(rng)
    weights = Weights(np.ones(2), np.ones(2))
    fit = estimate(columns, columns @ TRUTH + noise(rng, 0.5), weights)
    half, most = (intervals(fit, weights, BLOCKS, level) for level in (0.5, 0.95))
    assert (most.high - most.low) / (half.high - half.low) == pytest.approx(2.0930 / 0.6876, rel=1e-3)


def test_margin_widens_what_the_scatter_says_and_not_the_tolerance() -> None:
    rng = np.random.default_rng(3)
    columns = design(rng)
    weights = Weights(np.ones(2), np.ones(2))
    free, held = (estimate(columns * size, noise(rng, 0.5), weights, sd) for size, sd in ((1.0, np.inf), (1e-6, 0.3)))
    for fit, factor in ((free, 1.3), (held, 1.0)):
        plain, wide = intervals(fit, weights, BLOCKS), intervals(fit, weights, BLOCKS, margin=1.3)
        assert (wide.high - wide.low) / (plain.high - plain.low) == pytest.approx(factor, rel=1e-6)


def test_logarithmic_parameters_have_intervals_of_ratios() -> None:
    values = np.array([2.0, 0.7, 0.4])
    bounds = one(p=values, log=True)
    assert (bounds.low > 0.0).all()
    assert bounds.low * bounds.high == pytest.approx(values**2)


def attenuated(seed: int) -> tuple[Fit, Weights, np.ndarray]:
    """A fit whose regressors are noisy: values too small by a fifth, and what as much noise again pulls them by."""
    rng = np.random.default_rng([2, seed])
    clean = rng.standard_normal((ROWS, JOINTS, 3))
    seen = clean + 0.5 * rng.standard_normal(clean.shape)
    draw = 0.5 * rng.standard_normal(clean.shape)
    weights = Weights(np.ones(2), np.ones(2))
    y = clean @ TRUTH + 0.1 * rng.standard_normal((ROWS, JOINTS))
    fit = estimate(seen, y, weights)
    noisier = [np.einsum("mnf,mn->f", -x, y - x @ fit.p) for x in (seen + draw, seen - draw)]
    return fit, weights, np.mean(noisier, axis=0) - np.einsum("mnf,mn->f", fit.jacobian, fit.residual)


def test_noisy_regressors_bias_what_scatter_does_not_show_and_the_pull_does() -> None:
    """Closed form: 1 / 1.25 of each value is found; as much noise again would take off 0.16 of the 0.2 that lack."""
    held, blind = [], []
    for seed in range(40):
        fit, weights, pull = attenuated(seed)
        assert fit.p == pytest.approx(TRUTH / 1.25, abs=0.08)
        plain, shifted = intervals(fit, weights, BLOCKS), intervals(fit, weights, BLOCKS, pull=1.25 * pull)
        blind.append((plain.low <= TRUTH) & (plain.high >= TRUTH))
        held.append((shifted.low <= TRUTH) & (shifted.high >= TRUTH))
        outward = np.sign(TRUTH) > 0.0
        assert np.where(outward, shifted.low == plain.low, shifted.high == plain.high).all()  # on one side only
    assert np.mean(blind) < 0.2
    assert np.mean(held) > 0.9


def test_a_shift_as_large_as_the_tolerance_is_no_identification() -> None:
    fit, weights, pull = attenuated(0)
    sure = replace(fit, entries=entries(sd=0.3))
    assert intervals(sure, weights, BLOCKS).identified.all()
    assert not intervals(sure, weights, BLOCKS, pull=pull).identified[0]


def test_a_decay_constant_is_known_by_its_ratio_and_nothing_is_beyond_a_bound() -> None:
    rng = np.random.default_rng(3)
    columns = design(rng) * 0.02
    weights = Weights(np.ones(2), np.ones(2))
    fit = estimate(columns, columns @ TRUTH + noise(rng, 0.5), weights)
    own = zip(fit.entries, ("alpha", "C1", "C2"), (0.0, -0.8, 0.0), strict=True)
    named = tuple(replace(entry, name=name, lower=lower) for entry, name, lower in own)
    fit = replace(fit, p=np.array([2.0, -0.7, 0.4]))
    plain, bounds = intervals(fit, weights, BLOCKS), intervals(replace(fit, entries=named), weights, BLOCKS)
    half = plain.high[0] - fit.p[0]
    assert [bounds.low[0], bounds.high[0]] == pytest.approx([2.0 * np.exp(-half / 2.0), 2.0 * np.exp(half / 2.0)])
    assert (bounds.low[1], bounds.low[2]) == (-0.8, 0.0)
    assert bounds.high[1:] == pytest.approx(plain.high[1:])


def test_weights_of_rows_are_those_of_joints_where_all_rows_are_alike() -> None:
    rng = np.random.default_rng(3)
    columns = design(rng)
    y = columns @ TRUTH + noise(rng, 0.5)
    by_joint = Weights(np.array([0.5, 2.0]), np.ones(2))
    by_row = Weights(np.tile(by_joint.sd, (ROWS, 1)), np.ones(2))
    fit = estimate(columns, y, by_joint)
    a, b = intervals(fit, by_joint, BLOCKS), intervals(fit, by_row, BLOCKS)
    assert a.high == pytest.approx(b.high, rel=1e-12)


def test_weights_do_not_change_the_interval() -> None:
    """The sandwich does not believe the stated noise."""
    rng = np.random.default_rng(3)
    columns = design(rng)
    y = columns @ TRUTH + noise(rng, 0.5)
    few, many = (Weights(np.full(2, sd), np.ones(2)) for sd in (0.01, 10.0))
    a, b = intervals(estimate(columns, y, few), few, BLOCKS), intervals(estimate(columns, y, many), many, BLOCKS)
    assert a.high - a.low == pytest.approx(b.high - b.low, rel=1e-9)
