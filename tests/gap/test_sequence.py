"""What was recorded first: every run is told how far its joints had gone before."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from stribeck.effects.registry import effect_named
from stribeck.gap.prepare import prepare
from stribeck.identify.residual import Residual
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath

from .conftest import NOMINAL, sines

RUNS = [sines(2.0, name=name) for name in ("run_10", "run_9", "run_2")]


def gone(*runs, late: float = 0.0) -> dict[str, float]:  # type: ignore[no-untyped-def]
    """Return what each run is told, by its name, the run number k moved by k times ``late``, s."""
    moved = [replace(run, t=run.t + k * late) for k, run in enumerate(runs)]
    prepared = prepare(NOMINAL, moved)
    return {run.name: float(np.ravel(run.past.travelled)[0]) for run in (*prepared.fit, *prepared.held)}


def test_names_tell_the_order_where_clocks_start_anew() -> None:
    told = gone(*RUNS)
    assert told["run_2"] == 0.0
    assert told["run_10"] == pytest.approx(2.0 * told["run_9"], rel=1e-3)
    assert gone(*RUNS[::-1]) == pytest.approx(told)


def test_one_clock_tells_better() -> None:
    told = gone(*RUNS, late=5.0)
    assert told["run_10"] == 0.0
    assert told["run_2"] == pytest.approx(2.0 * told["run_9"], rel=1e-3)


def test_parts_of_one_run_follow_each_other() -> None:
    prepared = prepare(NOMINAL, [sines(10.0, name="only")])
    (fit,), (held,) = prepared.fit, prepared.held
    assert held.past.recordings == 0
    assert held.past.recorded == pytest.approx(7.0, abs=0.01)
    assert held.past.travelled == pytest.approx(np.sum(np.abs(fit.velocity), axis=0) * fit.sample_time)


def test_running_in_goes_on_where_the_last_run_left_it() -> None:
    """Friction in the second of two like runs is what it would be so much further on, not what it was at first."""
    effect = effect_named("history", "running_in")
    path = SignalPath(NOMINAL, [Placed(effect, 0, {"change": 0.5, "distance": 3.0})])
    prepared = prepare(NOMINAL, [sines(4.0, name="run_1"), sines(4.0, name="run_2")])
    ((first,), (second,)), p = (prepared.fit, prepared.held), values_of(path.entries)
    if first.name == "run_2":
        first, second = second, first
    left = [Residual(path, [run], ()).states(run, p)[:, -1] for run in (first, second)]
    assert left[0][0] == 1.0
    assert left[1][0] == pytest.approx(left[0][-1], rel=0.02)
    assert left[1][-1] == pytest.approx(left[0][-1] ** 2, rel=0.02)


def test_a_part_of_the_warmth_is_kept_for_the_next_run() -> None:
    effect = effect_named("history", "warm_up")
    values = {"change": 0.1, "time": 3.0, "start": 0.4, "kept": 0.6}
    path = SignalPath(NOMINAL, [Placed(effect, 0, values)])
    prepared = prepare(NOMINAL, [sines(4.0, name=f"run_{k}") for k in range(4)])
    p, runs = values_of(path.entries), sorted((*prepared.fit, *prepared.held), key=lambda run: run.name)
    warmth = [Residual(path, [run], ()).states(run, p)[:, -1] for run in runs]
    assert warmth[0][0] == pytest.approx(0.4)
    for before, after in pairwise(warmth):
        assert after[0] == pytest.approx(0.6 * before[-1], rel=0.05)


def test_a_part_of_a_run_goes_on_as_warm_as_the_part_before_it_was() -> None:
    effect = effect_named("history", "warm_up")
    path = SignalPath(NOMINAL, [Placed(effect, 0, {"change": 0.1, "time": 3.0, "start": 0.4, "kept": 0.0})])
    prepared, p = prepare(NOMINAL, [sines(10.0, name="only")]), values_of(path.entries)
    (fit,), (held,) = prepared.fit, prepared.held
    before, after = (Residual(path, [run], ()).states(run, p)[:, -1] for run in (fit, held))
    assert after[0] == pytest.approx(before[-1], rel=0.05)
