"""What was recorded first: every run is told how far its joints had gone before."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from stribeck.effects.registry import effect_named, registry
from stribeck.gap.diagnose import diagnose
from stribeck.gap.records.prepare import prepare
from stribeck.gap.records.sequence import after, in_sequence, on_average
from stribeck.identify.conditioning import condition
from stribeck.identify.residual import Residual
from stribeck.identify.stretches import part
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath
from stribeck.model.values import Signals

from ..conftest import NOMINAL, recorded, sines

RUNS = [sines(2.0, name=name) for name in ("run_10", "run_9", "run_2")]


def gone(*runs, late: float = 0.0) -> dict[str, float]:  # type: ignore[no-untyped-def]
    """Return what each run is told, by its name, the run number k moved by k times ``late``, s."""
    moved = [replace(run, t=run.t + k * late) for k, run in enumerate(runs)]
    prepared = prepare(NOMINAL, moved)
    return {run.name: float(np.ravel(run.past.travelled)[0]) for run in (*prepared.fit, *prepared.held)}


def test_names_tell_the_order_where_clocks_start_anew() -> None:
    told = gone(*RUNS)
    assert told["run_2"] == 0.0
    assert told["run_10"] == pytest.approx(2.0 * told["run_9"], rel=1e-2)
    assert gone(*RUNS[::-1]) == pytest.approx(told)


def test_one_clock_goes_on_from_one_million_seconds_to_the_next() -> None:
    """As seconds since 1970 do twice a month: the times are counted from one origin."""
    late = [replace(run, t=run.t + 1.7e9 - 7.0) for run in RUNS]
    told = gone(*RUNS, late=5.0)
    assert gone(*late, late=5.0) == pytest.approx(told, rel=1e-3)


def test_one_clock_tells_better() -> None:
    told = gone(*RUNS, late=5.0)
    assert told["run_10"] == 0.0
    assert told["run_2"] == pytest.approx(2.0 * told["run_9"], rel=1e-2)


def test_parts_of_one_run_follow_each_other() -> None:
    prepared = prepare(NOMINAL, [sines(10.0, name="only")])
    (fit,), (held,) = prepared.fit, prepared.held
    assert held.past.recordings == 0
    assert held.past.lead == pytest.approx(7.0, abs=0.01)
    assert held.past.led == pytest.approx(np.sum(np.abs(fit.velocity), axis=0) * fit.sample_time, rel=0.01)


@pytest.mark.parametrize("kept", [1.0, 0.3, 0.0])
def test_running_in_goes_on_where_the_last_run_left_it(kept: float) -> None:
    """Friction in the second of two like runs is what it would be so much further on, but for what is not kept."""
    effect = effect_named("history", "running_in")
    path = SignalPath(NOMINAL, [Placed(effect, 0, {"change": 0.5, "distance": 3.0, "kept": kept})])
    prepared = prepare(NOMINAL, [sines(4.0, name="run_1"), sines(4.0, name="run_2")])
    ((first,), (second,)), p = (prepared.fit, prepared.held), values_of(path.entries)
    if first.name == "run_2":
        first, second = second, first
    left = [Residual(path, [run], ()).states(run, p)[:, -1] for run in (first, second)]
    assert left[0][0] == 1.0
    assert left[1][0] == pytest.approx(1.0 - kept * (1.0 - left[0][-1]), rel=0.02)
    assert left[1][-1] == pytest.approx(left[1][0] * left[0][-1], rel=0.02)


@pytest.mark.parametrize(
    ("law", "change", "within"), [("warm_up", 0.1, 0.05), ("heat", 0.005, 0.2), ("heat", -0.05, 0.1)]
)
def test_a_part_of_the_warmth_is_kept_for_the_next_run(law: str, change: float, within: float) -> None:
    """By the mean speed of the runs before: where viscous friction heats, that is less than the mean of its power."""
    effect = effect_named("history", law)
    values = {"change": change, "time": 3.0, "start": 0.4, "kept": 0.6}
    path = SignalPath(NOMINAL, [Placed(effect, 0, values)])
    prepared = prepare(NOMINAL, [sines(4.0, name=f"run_{k}") for k in range(4)])
    p, runs = values_of(path.entries), sorted((*prepared.fit, *prepared.held), key=lambda run: run.name)
    warmth = [Residual(path, [run], ()).states(run, p)[:, -1] for run in runs]
    assert warmth[0][0] == pytest.approx(0.4)
    for before, then in pairwise(warmth):
        assert then[0] == pytest.approx(0.6 * before[-1], rel=within)


@pytest.mark.parametrize("kept", [1.0, 0.3, 0.0])
def test_what_settles_in_time_goes_on_where_the_last_run_left_it(kept: float) -> None:
    effect = effect_named("history", "in_time")
    path = SignalPath(NOMINAL, [Placed(effect, 0, {"change": 0.5, "time": 3.0, "kept": kept})])
    prepared = prepare(NOMINAL, [sines(4.0, name=f"run_{k}") for k in range(4)])
    p, runs = values_of(path.entries), sorted((*prepared.fit, *prepared.held), key=lambda run: run.name)
    newness = [Residual(path, [run], ()).states(run, p)[:, -1] for run in runs]
    assert newness[0][0] == 1.0
    assert newness[0][-1] == pytest.approx(np.exp(-4.0 / 3.0), rel=0.02)
    for before, then in pairwise(newness):
        assert then[0] == pytest.approx(1.0 - kept * (1.0 - before[-1]), rel=0.02)


@pytest.mark.parametrize(("law", "change"), [("warm_up", 0.1), ("heat", -0.05)])
def test_a_part_of_a_run_goes_on_as_warm_as_the_part_before_it_was(law: str, change: float) -> None:
    effect = effect_named("history", law)
    path = SignalPath(NOMINAL, [Placed(effect, 0, {"change": change, "time": 3.0, "start": 0.4, "kept": 0.0})])
    prepared, p = prepare(NOMINAL, [sines(10.0, name="only")]), values_of(path.entries)
    (fit,), (held,) = prepared.fit, prepared.held
    before, then = (Residual(path, [run], ()).states(run, p)[:, -1] for run in (fit, held))
    assert then[0] == pytest.approx(before[-1], rel=0.05)


def test_runs_of_one_name_on_one_clock_are_two_recordings() -> None:
    first, second = sines(4.0, name="data.csv"), sines(4.0, name="data.csv")
    prepared = prepare(NOMINAL, [first, replace(second, t=second.t + 100.0)])
    told = {run.run.t[0]: run.past.recordings for run in (*prepared.fit, *prepared.held)}
    assert told == {0.0: 0, 100.0: 1}


def test_stretches_know_what_lies_between_them() -> None:
    """Parts of the second recording: the first is behind them, and all of their own, used or not."""
    recordings = [sines(10.0, name="run_1"), sines(50.0, name="run_2")]
    parts = [part(recordings[1], start, start + 1000) for start in (0, 3000, 9000)]
    runs = in_sequence([condition(NOMINAL, run, 15.0, thin=True) for run in parts], recordings)
    assert [run.past.recordings for run in runs] == [1, 1, 1]
    assert [run.past.lead for run in runs] == pytest.approx([0.0, 15.0, 45.0], abs=0.1)
    whole = np.abs(np.diff(recordings[1].q[:, 0]))
    assert [float(np.ravel(run.past.led)[0]) for run in runs] == pytest.approx(
        [0.0, whole[:3000].sum(), whole[:9000].sum()], rel=0.01
    )
    told = after(runs[-1:])
    assert told.recordings == 2
    assert told.recorded == pytest.approx(10.0 + 45.0 + 5.0, abs=0.1)


@pytest.mark.parametrize(
    ("law", "values", "state"),
    [
        ("running_in", {"change": 0.5, "distance": 10.0, "kept": 0.6}, "newness"),
        ("in_time", {"change": 0.5, "time": 8.0, "kept": 0.6}, "newness"),
        ("warm_up", {"change": 0.1, "time": 3.0, "start": 0.0, "kept": 0.5}, "warmth"),
        ("heat", {"change": -0.05, "time": 3.0, "start": 0.0, "kept": 0.5}, "heat"),
    ],
)
def test_an_arm_without_a_past_is_as_the_recordings_were_on_average(
    law: str, values: dict[str, float], state: str
) -> None:
    effect = effect_named("history", law)
    prepared = prepare(NOMINAL, [sines(4.0, name=f"run_{k}") for k in range(3)])
    runs = (*prepared.fit, *prepared.held)
    path = SignalPath(NOMINAL, [Placed(effect, 0, values)])
    p = values_of(path.entries)
    begun = np.mean([Residual(path, [run], ()).states(run, p)[0, -1] for run in runs])
    (place,) = on_average(path, p, runs)
    fresh = float(effect.initial(Signals(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), place.values)[state])
    assert place.values["change"] * fresh == pytest.approx(values["change"] * begun, rel=1e-6)
    assert begun > 0.0


def test_what_comes_after_comes_after_all() -> None:
    prepared = prepare(NOMINAL, [sines(4.0, name=f"run_{k}") for k in range(3)])
    told = after((*prepared.fit, *prepared.held))
    assert told == after((*prepared.held, *prepared.fit))
    assert told.recordings == 3
    assert told.recorded == pytest.approx(12.0, abs=0.1)


@pytest.mark.slow
def test_the_written_arm_is_as_worn_as_the_recordings_found_it() -> None:
    """What is told is the change at the start of the first recording; a file that knows no past holds the mean."""
    others = [name for name in registry() if name != "history"]
    found = diagnose(NOMINAL, recorded(("history", {"change": 0.8, "work": 60.0})), jobs=1, leave_out=others)
    assert found.named == ("history",)
    told = found.causes[0].parameters["A"]["change"].value
    (entry,) = found.models["corrected"].effects
    assert 0.0 < entry.parameters["A"]["change"] < 0.9 * told
