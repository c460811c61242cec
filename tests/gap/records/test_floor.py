"""The noise floor is what noise leaves: checked against drawing it many times over."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from stribeck.gap.records.floor import LEAST, noise_floor, noise_of_rows
from stribeck.gap.records.prepare import prepare
from stribeck.identify.conditioning import condition
from stribeck.identify.residual import Residual
from stribeck.model.layout import values_of
from stribeck.model.path import SignalPath
from stribeck.run import Run
from stribeck.withheld.excitation import programme
from stribeck.withheld.recorder import default_gains, record

from ..conftest import TRUE

CUTOFF = 20.0
PATH = SignalPath(TRUE)
P = values_of(PATH.entries)


def sliding(seconds: float = 8.0, rate: float = 250.0) -> Run:
    """A joint that turns on without a stop, so that filters round no corner."""
    t = np.arange(round(seconds * rate)) / rate
    q = 1.5 * t + 0.2 * np.sin(2 * np.pi * 0.7 * t)
    return Run("sliding", t, q[:, None], np.zeros((len(t), 1)))


def shaken(run: Run, size: float, seed: int) -> Run:
    return replace(run, q=run.q + size * np.random.default_rng([9, seed]).standard_normal(run.q.shape))


def rms(values: Sequence[np.ndarray]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


@pytest.mark.parametrize("size", [1e-5, 1e-4])
def test_floor_is_what_noise_leaves(size: float) -> None:
    clean = condition(TRUE, sliding(), CUTOFF, np.array([size]), thin=True)
    still = Residual(PATH, [clean], ())(P)[0]
    drawn = []
    for seed in range(12):
        noisy = condition(TRUE, shaken(sliding(), size, seed), CUTOFF, np.array([size]), thin=True)
        drawn.append(Residual(PATH, [noisy], ())(P)[0] - still)
    floor = noise_floor(TRUE, PATH, P, [clean], CUTOFF, 0)
    assert floor.shape == still.shape
    assert rms([floor]) == pytest.approx(rms(drawn), rel=0.1)


def test_floor_of_a_noisy_record() -> None:
    """The record's own noise, found by the conditioning, gives the same floor as the noise that was put in."""
    size = 1e-4
    noisy = condition(TRUE, shaken(sliding(), size, 0), CUTOFF, thin=True)
    stated = condition(TRUE, shaken(sliding(), size, 0), CUTOFF, np.array([size]), thin=True)
    assert noisy.noise == pytest.approx([size], rel=0.1)
    floors = [rms([noise_floor(TRUE, PATH, P, [run], CUTOFF, 0)]) for run in (noisy, stated)]
    assert floors[0] == pytest.approx(floors[1], rel=0.15)


@pytest.mark.parametrize(("rate", "most"), [(100.0, 1.5), (125.0, 1.6), (200.0, 1.3)])
def test_what_samples_miss_of_reversals_is_in_the_floor(rate: float, most: float) -> None:
    """Friction turns within a sample: with the true parameters, all that is left comes of samples and filters."""
    motions = programme(TRUE, np.random.default_rng(1), ("multisine", "multisine"), 6.0)
    runs = record(TRUE, [], motions, rate=rate, noise=1e-5, gains=default_gains(TRUE, 3.0), model=TRUE, seed=5)
    prepared = prepare(TRUE, runs)
    every = (*prepared.fit, *prepared.held)
    left = rms([Residual(PATH, every, ())(P)[0]])
    floor = rms([noise_floor(TRUE, PATH, P, every, prepared.cutoff, 0)])
    assert floor < left < most * floor


def test_floor_grows_with_noise_and_is_repeatable() -> None:
    runs = [condition(TRUE, sliding(), CUTOFF, np.array([size]), thin=True) for size in (1e-5, 1e-4)]
    first = [noise_floor(TRUE, PATH, P, [run], CUTOFF, 0) for run in runs]
    assert 3.0 < rms([first[1]]) / rms([first[0]]) < 30.0
    assert (noise_floor(TRUE, PATH, P, [runs[0]], CUTOFF, 0) == first[0]).all()
    assert (noise_floor(TRUE, PATH, P, [runs[0]], CUTOFF, 1) != first[0]).any()


def test_noise_of_rows_is_the_floor_smoothed() -> None:
    """It has the floor's mean square, but where a row has next to none."""
    run = condition(TRUE, shaken(sliding(), 1e-4, 0), CUTOFF, thin=True)
    floor = noise_floor(TRUE, PATH, P, [run], CUTOFF, 0)
    rows = noise_of_rows(TRUE, PATH, P, [run], CUTOFF, 0)
    assert rows.shape == floor.shape
    assert rms([rows]) == pytest.approx(rms([floor]), rel=0.05)
    assert np.std(rows) < 0.6 * np.std(floor)
    assert rows.min() >= LEAST * rms([floor]) * (1.0 - 1e-9)
