"""A held command put on fewer rows, or between its own: it neither loses of its size nor comes late."""

import numpy as np
import pytest

from stribeck.grid import uniform
from stribeck.identify.conditioning import held_command
from stribeck.run import Run
from stribeck.run.held import mean_of_held
from stribeck.run.reading import as_read

FAST = 0.001  # s, for which a command is held
PERIOD = 0.15  # s, of the command


def wave(t: np.ndarray) -> np.ndarray:
    return np.sin(2.0 * np.pi * t / PERIOD)


def a_run() -> Run:
    t = FAST * np.arange(6000)
    q = np.sin(3.0 * t)[:, None]
    return Run("r.csv", t, q, tau=wave(t + 0.5 * FAST)[:, None])  # held about the middle of each row


def astray(run: Run) -> float:
    """Return by how much the command that a run stands for is off the wave, at most, but for the ends."""
    assert run.droop is not None
    return float(np.abs(held_command(run.tau + run.droop)[:, 0] - wave(run.t))[8:-8].max())


@pytest.mark.parametrize(("every", "most"), [(2, 1e-4), (10, 2e-3), (20, 0.025)])
def test_a_command_faster_than_the_encoder_keeps_its_size(every: int, most: float) -> None:
    """The mean of twenty rows alone, held, is off by 6 %."""
    run = a_run()
    q = np.repeat(run.q[::every], every, axis=0)
    again, _ = as_read(Run("r.csv", run.t, q, run.tau))
    assert len(again.t) == len(run.t) / every
    assert astray(again) < most


def test_a_command_between_whose_rows_others_are_taken_keeps_its_size() -> None:
    rng = np.random.default_rng(0)
    fast = a_run()
    rows = np.cumsum(rng.choice([9, 10, 11], 590))
    tau, _ = mean_of_held(fast.t, fast.tau, fast.t[rows])
    jittered = Run("r.csv", fast.t[rows[:-1]], fast.q[rows[:-1]], tau)
    even, _ = uniform(jittered)
    assert even.droop is not None
    plain = float(np.std(held_command(even.tau)[8:-8, 0] - wave(even.t)[8:-8]))
    assert float(np.std(held_command(even.tau + even.droop)[8:-8, 0] - wave(even.t)[8:-8])) < 0.7 * plain


def test_a_command_that_changes_with_the_rows_alone_lacks_nothing() -> None:
    t = 0.01 * np.arange(50)
    values = np.random.default_rng(0).normal(size=(50, 2))
    fine = np.arange(0.0, 0.5, 0.002)
    for times, held in ((t, values), (fine, np.repeat(values, 5, axis=0))):
        mean, droop = mean_of_held(times, held, np.append(t, 0.5))
        np.testing.assert_allclose(mean, values, atol=1e-12)
        np.testing.assert_allclose(droop, 0.0, atol=1e-12)
