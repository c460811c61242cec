"""Parts of recordings: what lies across missing samples is left out."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.grid import uniform
from stribeck.identify.cutoff import CUTOFF_RANGE, MOST_OF_RATE
from stribeck.identify.filters import low_pass
from stribeck.identify.identification import identify_friction
from stribeck.identify.stretches import LEAST_SAMPLES, LEAST_STRETCH, MOST_SAMPLES, between_gaps, shortened
from stribeck.run import Run

from .conftest import FRICTION, pendulum, recorded


def lossy(run: Run, *lost: tuple[int, int]) -> Run:
    """The run without some of its rows."""
    kept = np.ones(len(run.t), dtype=bool)
    for start, stop in lost:
        kept[start:stop] = False
    return replace(run, t=run.t[kept], q=run.q[kept], tau=run.tau[kept])


def test_the_stretches_between_gaps_hold_what_was_measured() -> None:
    run, notes = recorded(), list[str]()
    even, _ = uniform(lossy(run, (1000, 1020), (1100, 1110)))
    first, last = between_gaps([even], notes)
    assert [len(first.t), len(last.t)] == [
        1000,
        len(run.t) - 1110,
    ]  # the 80 between are too few
    for piece in (first, last):
        rows = np.rint(piece.t * 500.0).astype(int)
        assert piece.q == pytest.approx(run.q[rows], abs=1e-9)
        assert np.shares_memory(piece.q, even.q)  # by which it is known whose part it is
    assert notes == ["sines: 2 stretches between missing samples used, 5.78 s out of 5.998 s"]


def test_a_run_without_gaps_is_left_alone_and_one_of_short_pieces_keeps_the_longest() -> None:
    run = recorded(duration=1.0)
    assert between_gaps([run], []) == [run]
    even, _ = uniform(lossy(run, (100, 110), (280, 310)))
    (longest,) = between_gaps([even], [])
    assert len(longest.t) == 190


def test_lost_rows_cost_no_constant() -> None:
    run = recorded(noise=1e-6, step=1e-6)
    found = identify_friction(pendulum(), [lossy(run, (400, 420), (900, 920), (1700, 1720), (2400, 2420))])
    friction = found.arm.joints[0].friction
    for name in ("C0", "C2", "alpha"):
        assert getattr(friction, name) == pytest.approx(getattr(FRICTION, name), rel=0.15), name
    assert found.whole.rms[0] < 0.05


@pytest.mark.parametrize("rate", [20.0, 50.0, 100.0, 250.0, 1000.0, 5000.0])
def test_what_is_kept_is_long_enough_for_any_analysis_filter(rate: float) -> None:
    """Else one short piece would have a whole diagnosis refused."""
    low = min(CUTOFF_RANGE[0], MOST_OF_RATE * rate)
    assert len(low_pass(low, 1.0 / rate)) < max(LEAST_STRETCH * rate, LEAST_SAMPLES)


@pytest.mark.parametrize(("rate", "duration", "runs"), [(10_000.0, 30.0, 3), (500.0, 100.0, 40), (1000.0, 900.0, 1)])
def test_of_long_runs_the_end_is_used_too(rate: float, duration: float, runs: int) -> None:
    """A joint may not move before: of three at 10 kHz the first 20 s alone would be left."""
    t = np.arange(round(rate * duration)) / rate
    q, notes = np.zeros((len(t), 1)), list[str]()
    every = [Run(f"run_{k}", t, q, q) for k in range(runs)]
    parts = shortened(every, notes)
    assert sum(len(part.t) for part in parts) <= 1.01 * MOST_SAMPLES
    for run, note in zip(every, notes, strict=True):
        mine = [part for part in parts if part.name == run.name]
        assert len(mine) >= 3
        assert (mine[0].t[0], mine[-1].t[-1]) == (t[0], t[-1])
        assert note.startswith(f"{run.name}: {len(mine)} stretches of ")
        assert len(mine[0].t) / rate >= 2.0
