"""A candidate's trial comes near to where its fit is to begin."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stribeck.effects.registry import registry
from stribeck.gap.fitted.model import retune, weights_of
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.gap.search.screen import screen
from stribeck.run import Run

from ...identify.conftest import pendulum, recorded

RATE = 500.0


def shifted(late: float, noise: float) -> Prepared:
    """Three recordings whose position is late by a whole number of samples."""
    lost, runs = round(abs(late) * RATE), []
    for seed in range(3):
        run: Run = recorded(rate=RATE, duration=8.0, noise=noise, seed=seed)
        q, tau = (run.q[lost:], run.tau[:-lost]) if late < 0.0 else (run.q[:-lost], run.tau[lost:])
        runs.append(replace(run, name=f"run_{seed}", t=run.t[:-lost], q=q, tau=tau))
    return prepare(pendulum(), runs)


@pytest.mark.parametrize("noise", [2e-5, 2e-4])  # rad
@pytest.mark.parametrize("late", [-0.055, -0.026, 0.026, 0.05])  # s
def test_a_late_record_is_found_between_the_starts_and_beyond(late: float, noise: float) -> None:
    """From starts 9 ms away and more; by derivatives at a point, which friction's leaps rule, a trial hardly moves."""
    prepared, floor = shifted(late, noise), np.full(1, 0.02)
    base = retune(prepared, floor, ())
    trial = screen(prepared, base, weights_of(base, prepared, floor), registry()["time_shift"], 0)
    assert trial.start["time"] == pytest.approx(late, abs=7e-3)
    assert trial.promise > 0.0
