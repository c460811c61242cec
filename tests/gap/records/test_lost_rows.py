"""Recordings of which rows are lost in bursts."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.effects.registry import registry
from stribeck.gap import diagnose
from stribeck.gap.records.observed import observe
from stribeck.gap.records.prepare import prepare
from stribeck.run import Run

from ..conftest import NOMINAL, TRUE, recorded, sines

BURSTS = ((200, 208), (500, 508), (800, 808))


def lossy(run: Run, bursts: tuple[tuple[int, int], ...] = BURSTS) -> Run:
    """The run without some rows."""
    kept = np.delete(np.arange(len(run.t)), np.concatenate([np.arange(*burst) for burst in bursts]))
    channels = {key: value[kept] for key in ("t", "q", "tau", "dq") if (value := getattr(run, key)) is not None}
    return replace(run, **channels)


@pytest.mark.long
def test_they_are_no_gap_of_the_model() -> None:
    leave_out = [name for name in registry() if name not in ("torque_gain", "actuator_lag")]
    found = diagnose(NOMINAL, [lossy(run) for run in recorded()], jobs=1, leave_out=leave_out)
    assert found.verdict == "no_gap"
    assert len(found.fit_runs) + len(found.held_out_runs) == 4  # a run of several stretches is one


def test_they_are_no_filter_of_the_velocity() -> None:
    runs = recorded(channels=("dq",))
    runs = [runs[0], lossy(runs[1], ((300, 360), (700, 760))), *runs[2:]]
    assert not observe(NOMINAL, runs, prepare(NOMINAL, runs).scales).placed


def test_a_stretch_too_short_for_what_slow_runs_leave_of_the_band_is_left_out() -> None:
    """Runs at 20 Hz lower the cutoff of all: what is long enough at 1 kHz alone may not be beside them."""
    slow = [sines(10.0, 20.0, seed, name=f"slow {seed}") for seed in range(2)]
    fast = lossy(sines(8.0, 1000.0, 5, name="fast"), ((3000, 3020), (3900, 3920)))
    prepared = prepare(TRUE, [*slow, fast], [sines(10.0, 20.0, 3, name="held")])
    lengths = [round(np.ptp(run.time), 1) for run in prepared.fit if run.name == "fast"]
    assert lengths == [3.0, 4.1]
