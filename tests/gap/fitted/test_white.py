"""What is white through the analysis filter is noise; what has a memory, or comes in bursts, is not."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stribeck.gap.fitted.white import noise_of_best, white_rms
from stribeck.gap.records.passed import BANDS, Passed
from stribeck.identify.conditioning import Conditioned, condition
from stribeck.run import Run

from ..conftest import TRUE

CUTOFF = 12.0
SIZE = 0.3  # N m


@cache
def still(seed: int = 0, rate: float = 500.0) -> Conditioned:
    """A long recording, whose filter and rows are what matters here."""
    t = np.arange(round(40.0 * rate)) / rate
    q = 0.5 * np.sin(t)[:, None] + 1e-5 * np.random.default_rng(seed).standard_normal((len(t), 1))
    return condition(TRUE, Run("still", t, q, np.zeros_like(q)), CUTOFF, thin=True)


def rows(torque: np.ndarray) -> np.ndarray:
    """Torque at every sample (N,) as the analysis keeps it."""
    return still().filtered(torque[:, None])[:, 0]


def noise(seed: int) -> np.ndarray:
    return SIZE * np.random.default_rng(seed).standard_normal(len(still().time))


@pytest.mark.parametrize("seed", range(3))
def test_white_noise_is_all_noise(seed: int) -> None:
    seen = rows(noise(seed))
    assert white_rms(seen, [still()], CUTOFF, 0) == pytest.approx(np.sqrt(np.mean(seen**2)), rel=0.1)


@pytest.mark.parametrize("hertz", [0.3, 1.0, 3.0, 5.0, 6.0, 8.0, 10.0])
def test_a_motion_is_not_noise_nor_is_a_tone(hertz: float) -> None:
    seen = rows(np.sin(2 * np.pi * hertz * still().time))
    assert white_rms(seen, [still()], CUTOFF, 0) < 0.1 * np.sqrt(np.mean(seen**2))


def test_noise_is_found_under_a_gap_three_times_as_large() -> None:
    alone = rows(noise(5))
    size = float(np.sqrt(np.mean(alone**2)))
    seen = alone + 3.0 * size * np.sqrt(2.0) * rows(np.sin(2 * np.pi * 0.7 * still().time))
    assert white_rms(seen, [still()], CUTOFF, 0) == pytest.approx(size, rel=0.3)


def test_bursts_are_no_noise() -> None:
    """Knocks in one second out of ten are as white as noise, but not always there."""
    torque = noise(7) * (np.floor(still().time) % 10 == 0)
    seen = rows(torque)
    assert white_rms(seen, [still()], CUTOFF, 0) < 0.2 * np.sqrt(np.mean(seen**2))


@pytest.mark.parametrize("first", [70.0, 500.0])
def test_runs_of_another_rate_have_other_rows(first: float) -> None:
    """A slow tone in noise, recorded at 70 and at 500 Hz: either may come first."""
    runs = [still(rate=first), still(rate=570.0 - first)]
    parts, alone = [], []
    for k, run in enumerate(runs):
        torque = SIZE * np.random.default_rng(20 + k).standard_normal(len(run.time))
        tone = 2.0 * SIZE * np.sin(2 * np.pi * 0.7 * run.time)
        for into, values in ((alone, torque), (parts, torque + tone)):
            into.append(run.filtered(values[:, None])[:, 0])
    size = np.sqrt(np.mean(np.concatenate(alone) ** 2))
    assert white_rms(np.concatenate(parts), runs, CUTOFF, 0) == pytest.approx(size, rel=0.15)


def test_nothing_is_nothing() -> None:
    assert white_rms(np.zeros(len(still().analysis_index)), [still()], CUTOFF, 0) == 0.0
    assert white_rms(np.zeros(0), [], CUTOFF, 0) == 0.0


def test_noise_in_the_torque_is_judged_by_models_without_a_compliance() -> None:
    """These hold all of it. Where there is none, what an earlier step's models told stands.

    But what looks as white and is gone with a compliance, the noise that it takes put back, was its ringing; and so it
    was where an earlier step took it for noise.
    """
    whole, part = rows(noise(8)), 0.3 * rows(noise(9))
    through = {
        k: Passed(np.array([0.01 * k]), np.array([k]), np.full((BANDS // 2 + 1, 1), k**2), np.array([False]))
        for k in (0.3, 1.0)
    }
    stiff: Any = SimpleNamespace(whole=whole[:, None], noise=None)
    soft: Any
    rings: Any
    soft, rings = (SimpleNamespace(whole=part[:, None], noise=noise) for noise in through.values())
    prepared: Any = SimpleNamespace(fit=(still(),), held=(), cutoff=CUTOFF, reference=through[1.0], noise=None)
    floor, size = np.array([0.01]), np.sqrt(np.mean(whole**2))
    assert noise_of_best(floor, [soft, stiff], prepared) == pytest.approx([size], rel=0.1)
    assert noise_of_best(floor, [soft, stiff], prepared, np.array([9.0])) == pytest.approx([size], rel=0.1)
    assert noise_of_best(floor, [soft], prepared, np.array([1.9 * size])) == [1.9 * size]
    assert noise_of_best(floor, [soft], prepared, np.array([9.0])) == pytest.approx([size], rel=0.1)
    assert noise_of_best(floor, [soft, rings], prepared, np.array([9.0])) == pytest.approx([0.3 * size], rel=0.1)
    assert noise_of_best(np.array([4.0]), [rings], prepared, np.array([9.0])) == [4.0]
    unknown: Any = SimpleNamespace(whole=rings.whole, noise=replace(rings.noise, bristles=np.array([True])))
    assert noise_of_best(floor, [unknown], prepared, np.array([9.0])) == [9.0]
    assert noise_of_best(floor, [soft], prepared) == pytest.approx([0.3 * size], rel=0.1)
    assert noise_of_best(floor, [rings, stiff], prepared) == pytest.approx([0.3 * size], rel=0.1)
    assert noise_of_best(np.array([7.0]), [stiff, rings], prepared) == [7.0]


def test_a_drives_noise_is_found_where_its_joint_rests_most_of_the_time() -> None:
    """Stiction holds it at rest: it shows in two seconds of five, and that is how much of it there is."""
    t = np.arange(20000) / 500.0
    q = np.cumsum(0.5 * np.sin(2.0 * np.pi * t) * (np.floor(t) % 5 < 2))[:, None] / 500.0
    run = condition(TRUE, Run("to and fro", t, q, np.zeros_like(q)), CUTOFF, thin=True)
    resting = run.stuck[run.analysis_index, 0]
    assert 0.5 < np.mean(resting) < 0.65
    seen = run.filtered((noise(11)[: len(run.time)] * (np.floor(run.time) % 5 < 2))[:, None])[:, 0]
    assert white_rms(seen, [run], CUTOFF, 0) == pytest.approx(np.sqrt(np.mean(seen**2)), rel=0.15)
