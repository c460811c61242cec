"""The band of the comparison rolls off where noise alone is left, and nowhere else."""

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stribeck.effects.registry import registry
from stribeck.gap.diagnose import searched_from
from stribeck.gap.fitted import band as band_module
from stribeck.gap.fitted.band import CORNERS, band_of, corner_of, rolled_off, told_band
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.gap.search import search as search_module
from stribeck.gap.search.setting import Asked
from stribeck.gap.search.tuned import lies_above, retuned
from stribeck.run import Run

from ..conftest import NOMINAL, recorded

NOISE = 1e-4  # rad: the cutoff is what it allows
SLOW = ("cable_spring", {"stiffness": 3.0, "rest": 0.4})
AGAIN = "again, by a band with less of the encoder's noise"
FAST = ("joint_flexibility", {"stiffness": 800.0, "damping": 0.4})


def shaken(runs: tuple[Run, ...], size: float) -> tuple[Run, ...]:
    """The runs with white noise in their commands, N m."""
    rng = np.random.default_rng(0)
    return tuple(replace(run, tau=run.tau + size * rng.standard_normal(run.tau.shape)) for run in runs)


def band(*runs: Run) -> Prepared:
    return retuned(prepare(NOMINAL, runs), Asked(jobs=1)).prepared


def test_it_rolls_off_where_noise_alone_is_left() -> None:
    prepared = band(*recorded(noise=NOISE))
    corner = prepared.fit[0].corner
    assert corner == pytest.approx(CORNERS[0] * prepared.cutoff)
    assert {run.corner for run in (*prepared.fit, *prepared.held, *prepared.moved)} == {corner}
    assert band_of(prepared) == {"cutoff_hz": prepared.cutoff, "corner_hz": corner}
    (note,) = told_band(prepared)
    assert f"{corner:.3g} Hz" in note


@pytest.mark.long
def test_what_a_search_has_found_hides_nothing_below_the_noise_any_more() -> None:
    """A spring bends friction that is re-tuned without it, which shows at all frequencies."""
    prepared = prepare(NOMINAL, recorded(SLOW, noise=NOISE))
    told: list[str] = []
    asked = Asked(jobs=1, progress=told.append, leave_out=tuple(name for name in registry() if name != SLOW[0]))
    tuned = retuned(prepared, asked)
    assert tuned.prepared.fit[0].corner == math.inf
    found = searched_from(tuned, asked)
    assert found.prepared.fit[0].corner < math.inf
    assert {step.best.placed[-1].effect.name for step in found.steps if step.taken and step.best} == {SLOW[0]}
    assert told.count(AGAIN) == 1
    assert found.noise.shape == found.given.shape == found.steps[0].base.held.shape


@pytest.mark.long
def test_a_search_keeps_the_band_where_a_lower_one_would_lose_what_it_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search_module, "lies_above", lambda *_: True)
    asked = Asked(jobs=1, leave_out=tuple(name for name in registry() if name != SLOW[0]))
    found = searched_from(retuned(prepare(NOMINAL, recorded(SLOW, noise=NOISE)), asked), asked)
    assert found.prepared.fit[0].corner == math.inf
    assert {step.best.placed[-1].effect.name for step in found.steps if step.taken and step.best} == {SLOW[0]}
    assert not found.steps[-1].taken  # it went on to its end


@pytest.mark.parametrize("runs", [recorded(FAST, noise=NOISE), shaken(recorded(noise=NOISE), 2.0)])
def test_it_is_flat_where_more_is_left_than_noise(runs: tuple[Run, ...]) -> None:
    prepared = band(*runs)
    assert prepared.fit[0].corner == math.inf
    assert band_of(prepared) == {"cutoff_hz": prepared.cutoff}
    assert told_band(prepared) == []


def hummed(amplitude: float) -> tuple[Run, ...]:
    """Recordings with a hum just below the cutoff, N m."""
    frequency = 0.97 * prepare(NOMINAL, recorded(noise=NOISE)).cutoff
    hum = {"amplitude": amplitude, "frequency": frequency, "phase": 0.3, "duty": 0.0, "noise": 0.0, "bandwidth": 10.0}
    return recorded(("input_disturbance", hum), noise=NOISE)


def test_a_faint_hum_just_below_the_cutoff_counts() -> None:
    assert band(*hummed(0.14)).fit[0].corner == math.inf


@pytest.mark.parametrize(("amplitude", "above"), [(0.4, True), (0.0, False)])
def test_what_lies_above_a_lower_band_is_not_lost_to_it(amplitude: float, above: bool) -> None:
    tuned = retuned(prepare(NOMINAL, hummed(amplitude)), Asked(jobs=1))
    lower = rolled_off(tuned.prepared, CORNERS[0] * tuned.prepared.cutoff)
    nothing: list[Any] = [SimpleNamespace(taken=False, base=tuned.base)]
    found: list[Any] = [SimpleNamespace(taken=True)]
    assert lies_above(rolled_off(tuned.prepared, math.inf), found, lower, nothing) is above
    assert not lies_above(tuned.prepared, found, lower, found)
    assert not lies_above(tuned.prepared, nothing, lower, nothing)


@pytest.mark.long
def test_the_noise_is_measured_anew_in_another_band() -> None:
    prepared = band(*recorded(noise=NOISE))
    flat = rolled_off(prepared, math.inf)
    assert flat.noise is None
    tuned = retuned(prepare(NOMINAL, recorded(noise=NOISE)), Asked(jobs=1))
    assert tuned.prepared.noise is not None
    assert corner_of(tuned.prepared, tuned.base) == prepared.fit[0].corner


def test_recordings_too_short_for_a_spectrum_roll_off_nowhere(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(band_module, "FEWEST", 10**6)
    assert band(*recorded(noise=NOISE)).fit[0].corner == math.inf


def test_a_recording_has_a_say_as_long_as_it_is() -> None:
    """Of white noise, each second is worth as much as any other, in one recording or in several."""
    first: Any = SimpleNamespace(sample_time=0.002, decimation=4, analysis_index=range(4000))
    short: Any = SimpleNamespace(sample_time=0.002, decimation=4, analysis_index=range(1000))
    edges = np.array([12.5, 50.0])  # of 62.5 Hz
    white = np.random.default_rng(0).standard_normal((4000, 1))
    one, four = (band_module._power(white, runs, edges) for runs in ([first], [short] * 4))
    assert one == pytest.approx(0.6 * 4000.0, rel=0.1)
    assert four == pytest.approx(one, rel=0.1)
