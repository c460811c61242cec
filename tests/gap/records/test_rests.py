"""Long rests around a motion are left out, and nothing else."""

import numpy as np
import pytest

from stribeck.gap.diagnose import diagnose
from stribeck.gap.records.prepare import prepare
from stribeck.gap.records.rests import KEPT, without_long_rests
from stribeck.run import Run

from ..conftest import NOMINAL, TRUE, recorded, sines

NOISE = np.full(1, 1e-5)


def rested(run: Run, before: float, after: float) -> Run:
    """The run with rests (s) around it, its clock going on."""
    h = run.sample_time
    first, last = round(before / h), round(after / h)
    q, tau = (np.pad(values, ((first, last), (0, 0)), mode="edge") for values in (run.q, run.tau))
    q += NOISE * np.random.default_rng(4).standard_normal(q.shape)
    return Run(run.name, np.arange(len(q)) * h, q, tau)


@pytest.mark.parametrize(("before", "after"), [(30.0, 0.0), (0.0, 12.0), (7.0, 9.0)])
def test_what_is_left_is_the_motion_and_a_moment_of_rest(before: float, after: float) -> None:
    run, notes = rested(sines(4.0), before, after), []
    found = without_long_rests(run, NOISE, notes)
    assert found.t[0] == pytest.approx(max(before - KEPT, 0.0), abs=0.3)
    assert found.t[-1] == pytest.approx(min(before + 4.0 + KEPT, run.t[-1]), abs=0.3)
    assert np.shares_memory(found.q, run.q)
    (note,) = notes
    assert note.endswith("s of rest before and after its motion are left out")


@pytest.mark.parametrize(("before", "after"), [(0.0, 0.0), (2.5, 2.4)])
def test_a_moment_of_rest_is_no_long_one(before: float, after: float) -> None:
    run = rested(sines(4.0), before, after)
    assert without_long_rests(run, NOISE, []) is run


def test_rest_in_between_and_a_run_that_never_moves_stay() -> None:
    first, second = sines(2.0), sines(2.0, seed=1)
    held = np.full((4000, 1), first.q[-1])
    q = np.concatenate([first.q, held, second.q + first.q[-1] - second.q[0]])
    run = Run("twice", np.arange(len(q)) * 0.005, q, np.zeros_like(q))
    assert without_long_rests(run, NOISE, []) is run
    still = Run("still", np.arange(8000) * 0.005, np.full((8000, 1), 0.3), np.zeros((8000, 1)))
    assert without_long_rests(still, NOISE, []) is still


def test_a_slow_motion_is_none() -> None:
    """A tenth of the noise from window to window, but far beyond it in all."""
    t = np.arange(8000) * 0.005
    q = (1e-5 * t)[:, None]
    run = Run("creep", t, q, np.zeros_like(q))
    assert without_long_rests(run, NOISE, [])


def test_a_single_recording_is_not_fitted_at_rest() -> None:
    """Of sixty seconds of rest and four of motion, the first 70 % would be all rest."""
    prepared = prepare(TRUE, [rested(sines(4.0), 60.0, 0.0)])
    fitted = prepared.fit[0].run
    assert np.ptp(fitted.q) > 0.5
    assert fitted.t[-1] > 60.0
    assert prepared.fit[0].past.lead == pytest.approx(fitted.t[0])


@pytest.mark.slow
def test_the_answer_is_that_of_the_motion() -> None:
    runs = recorded(("cogging", {"amplitude": 3.0, "harmonic": 12.0, "phase": 0.3}))
    found = diagnose(NOMINAL, [rested(run, 20.0, 10.0) for run in runs], jobs=1)
    assert found.named == ("cogging",)
    assert any("s of rest" in note for note in found.notes)
