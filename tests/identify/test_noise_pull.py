"""What noise shifts a fit by: nothing without noise, and with it what fits to noisier recordings show."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import Tolerance
from stribeck.identify import noise_pull as module
from stribeck.identify.blocks import block_of_rows
from stribeck.identify.conditioning import Conditioned, condition
from stribeck.identify.confidence import intervals
from stribeck.identify.map_fit import Fit, fit
from stribeck.identify.noise_pull import noise_pull
from stribeck.identify.problem import Weights
from stribeck.identify.residual import Residual
from stribeck.model.layout import values_of
from stribeck.model.path import SignalPath

from .conftest import pendulum, recorded

CUTOFF, NOISE = 20.0, 3e-4
ARM = replace(pendulum(), tolerance=Tolerance(0.1, 1.0))
WEIGHTS = Weights(np.array([0.1]), np.ones(1))


def run(noise: float = NOISE, seed: int = 0) -> Conditioned:
    own = recorded(rate=250.0, noise=noise, seed=seed)
    return condition(ARM, own, CUTOFF, np.full(1, noise), thin=True)


def fitted(residual: Residual) -> Fit:
    found = fit(residual, WEIGHTS, tolerance=1e-6)
    assert found.ok
    return found


def in_deviations(pull: np.ndarray, residual: Residual) -> np.ndarray:
    return np.asarray(pull * [residual.path.entries[i].sd for i in residual.columns])


def test_no_noise_pulls_nothing() -> None:
    residual = Residual(SignalPath(ARM), [run(1e-12)])
    assert np.abs(in_deviations(noise_pull(fitted(residual), WEIGHTS, residual, CUTOFF), residual)).max() < 1e-4


def test_the_same_seed_gives_the_same_pull() -> None:
    residual = Residual(SignalPath(ARM), [run()])
    found = fitted(residual)
    first, again, other = (noise_pull(found, WEIGHTS, residual, CUTOFF, seed) for seed in (1, 1, 2))
    assert first.tolist() == again.tolist() != other.tolist()


def test_pull_is_what_moves_a_fit_to_noisier_recordings(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fits to the very recordings that the pull was read from, plus and minus one draw, move by it on average."""
    monkeypatch.setattr(module, "PAIRS", 1)
    residual = Residual(SignalPath(replace(ARM, tolerance=Tolerance(0.01, 0.05))), [run()])  # near enough to be linear
    found = fitted(residual)
    pull = noise_pull(found, WEIGHTS, residual, CUTOFF, seed=4) / module.OF_ITSELF
    draw = np.random.default_rng(4).standard_normal(residual.runs[0].run.q.shape)
    noisier = []
    for sign in (1.0, -1.0):
        own = residual.runs[0].run
        moved, noise = replace(own, q=own.q + sign * NOISE * draw), np.full(1, NOISE)
        shaken = condition(ARM, moved, CUTOFF, noise, thin=True, louder=np.sqrt(2.0))
        noisier.append(fitted(residual.along([shaken])).p[list(residual.columns)])
    unit = np.array([residual.path.entries[i].sd for i in residual.columns])
    columns = (found.jacobian * WEIGHTS.scale).reshape(-1, len(unit)) * unit
    expected = -np.linalg.solve(columns.T @ columns + np.eye(len(unit)), in_deviations(pull, residual))
    moved = (np.mean(noisier, axis=0) - found.p[list(residual.columns)]) / unit
    assert np.abs(expected).max() > 0.05
    assert moved == pytest.approx(expected, abs=0.2 * np.abs(expected).max())


@pytest.mark.parametrize(("noise", "least"), [(3e-5, 0.95), (1e-4, 0.95), (NOISE, 0.85)])
def test_intervals_with_the_pull_are_wider_and_hold_the_truth(noise: float, least: float) -> None:
    """Friction constants of ten noisy recordings of one motion; the loudest noise hides all of Stribeck's decay."""
    path = SignalPath(ARM)
    truth = values_of(path.entries)
    friction = [i for i, entry in enumerate(path.entries) if entry.owner == "friction"]
    held = []
    for seed in range(10):
        residual = Residual(path, [run(noise, seed)])
        found = fitted(residual)
        block = block_of_rows(residual.runs)
        plain = intervals(found, WEIGHTS, block)
        bounds = intervals(found, WEIGHTS, block, pull=noise_pull(found, WEIGHTS, residual, CUTOFF))
        assert (bounds.low <= plain.low + 1e-12).all()
        assert (bounds.high >= plain.high - 1e-12).all()
        held.append([bounds.low[i] <= truth[i] <= bounds.high[i] for i in friction])
    assert np.mean(held) >= least
