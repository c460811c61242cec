"""A candidate's trial comes near to where its fit is to begin."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stribeck.effects.registry import registry
from stribeck.gap.fitted.model import fit_model, retune, weights_of
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.gap.search import screen as screening
from stribeck.gap.search.descent import Descent
from stribeck.gap.search.screen import screen
from stribeck.model.layout import Placed
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
    assert trial.promise > 0.0
    assert trial.start["time"] == pytest.approx(late, abs=7e-3)  # from where a fit finds its way:
    place = Placed(registry()["time_shift"], 0, dict(trial.start))
    found = fit_model(prepared, (*base.placed, place), weights_of(base, prepared, floor), base.fit)
    assert found.placed[-1].values["time"] == pytest.approx(late, abs=2e-3)


def test_a_search_made_anew_starts_where_it_came_to(monkeypatch: pytest.MonkeyPatch) -> None:
    """But for a law that looks at what is left: a wave that is known wrongly is found again."""
    prepared, floor = shifted(-0.026, 2e-5), np.full(1, 0.02)
    base = retune(prepared, floor, ())
    weights, starts = weights_of(base, prepared, floor), []
    monkeypatch.setattr(screening, "Descent", lambda *given: starts.append(given[2]) or Descent(*given))
    first = screen(prepared, base, weights, registry()["time_shift"], 0)
    before = len(starts)
    again = screen(prepared, base, weights, registry()["time_shift"], 0, first.start, anew=True)
    assert 0 < len(starts) - before < before / 2
    assert again.promise >= 0.95 * first.promise
    assert again.start["time"] == pytest.approx(first.start["time"], abs=2e-3)
    cogging, wrong = registry()["cogging"], {"sine": 1e-3, "cosine": 0.0, "harmonic": 40.0}
    seen, known = (screen(prepared, base, weights, cogging, 0, *given) for given in ((), (wrong, None, True)))
    assert known.promise == pytest.approx(seen.promise, rel=0.05)
