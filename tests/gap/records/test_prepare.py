"""From runs to conditioned ones, with what is typical of them."""

import math
from dataclasses import replace

import numpy as np
import pytest

from stribeck.errors import InputError
from stribeck.gap.records.prepare import moved_inertia, prepare
from stribeck.identify.stretches import part
from stribeck.run import Run

from ..conftest import TRUE, recorded, sines


def test_part_cuts_every_channel() -> None:
    run = sines(2.0)
    piece = part(run, 10, 60)
    assert piece.tau == pytest.approx(run.tau[10:60])
    assert len(piece.t) == 50
    assert piece.dq is None


def test_held_out_runs_of_the_user_are_used() -> None:
    runs = [sines(3.0, name="a"), sines(3.0, seed=1, name="b")]
    extra = sines(3.0, seed=2, name="c")
    prepared = prepare(TRUE, runs, [extra])
    assert [run.name for run in prepared.fit] == ["a", "b"]
    assert [run.name for run in prepared.held] == ["c"]


def test_the_order_in_which_runs_are_given_does_not_matter() -> None:
    runs = [sines(3.0 + 0.5 * k, seed=k, name=f"run_{k}") for k in range(6)]
    one, other = (prepare(TRUE, given) for given in (runs, [runs[k] for k in (3, 0, 5, 1, 4, 2)]))
    assert [run.name for run in one.fit] == [run.name for run in other.fit]
    assert [run.name for run in one.held] == [run.name for run in other.held]


def test_typical_magnitudes() -> None:
    runs = [sines(3.0, name="a"), sines(3.0, seed=1, name="b")]
    prepared = prepare(TRUE, runs)
    (scale,) = prepared.scales
    assert scale.torque == pytest.approx(1.0, rel=0.4)  # white noise of one N m, as far as the command is smoothed
    assert scale.friction == 4.6
    assert scale.travel == pytest.approx(np.ptp(runs[0].q), rel=0.02)
    assert scale.speed == pytest.approx(np.std(np.gradient(runs[0].q[:, 0], 0.005)), rel=0.05)
    about_the_axis = 0.06 + 4.0 * (0.17**2 + 0.01**2)
    assert scale.inertia == pytest.approx(about_the_axis + 0.15)
    assert moved_inertia(TRUE, runs) == pytest.approx([about_the_axis + 0.15])
    assert math.isfinite(prepared.cutoff)


def test_the_torque_that_a_motion_needs_is_what_a_sound_drive_gives() -> None:
    """Of the arm as it is; a command that no motion follows asks for it in vain."""
    runs = recorded()
    (scale,) = prepare(TRUE, runs).scales
    assert scale.needed == pytest.approx(scale.torque, rel=0.1)
    (wound_up,) = prepare(TRUE, [replace(run, tau=9.0 * run.tau) for run in runs]).scales
    assert wound_up.needed == pytest.approx(scale.needed, rel=0.05)  # other rows are analysed
    assert wound_up.torque == pytest.approx(9.0 * scale.torque)


def test_of_a_joint_without_a_drive_the_torque_is_what_its_motion_needs() -> None:
    """Effects start at a part of it: of a command of zero they would never leave zero."""
    runs = recorded()
    (driven,) = prepare(TRUE, runs).scales
    undriven = prepare(TRUE, [replace(run, tau=np.zeros_like(run.tau)) for run in runs])
    assert any("its torque is zero in every recording" in text for text in undriven.warnings)
    (free,) = undriven.scales
    assert driven.driven
    assert not free.driven
    assert free.torque == pytest.approx(free.needed)


def test_runs_of_a_joint_whose_counter_begins_anew_are_prepared_in_one_turn() -> None:
    """Held-out ones with the fitted: what lies at a place of the joint lies there in all of them."""

    def wrapped(run: Run, middle: float) -> Run:
        return replace(run, q=(run.q + middle + np.pi) % (2.0 * np.pi) - np.pi)

    runs = [wrapped(sines(3.0, seed=k, size=0.3, name=f"run_{k}"), 2.9) for k in range(2)]
    judged = wrapped(sines(3.0, seed=2, size=0.3, name="run_2"), 3.9)  # beyond half a turn all along
    prepared = prepare(TRUE, runs, [judged])
    (first, second), (last,) = prepared.fit, prepared.held
    assert last.position.mean() - first.position.mean() == pytest.approx(1.0, abs=0.2)
    assert second.position.mean() == pytest.approx(first.position.mean(), abs=0.2)
    assert sum("moved by whole turns" in note and "run_2" in note for note in prepared.notes) == 1
    assert prepared.scales[0].covered < 2.5


@pytest.mark.parametrize("seconds", [20.0, pytest.param(400.0, marks=pytest.mark.long)])
def test_the_distance_is_that_of_all_recordings_held_out_ones_too(seconds: float) -> None:
    """Of joints on one sine each, four times the amplitude a period; long ones are analysed in parts only."""
    t = np.arange(round(seconds * 200.0)) / 200.0
    runs = [Run(f"run_{k}", t, np.sin(2.0 * np.pi * 0.5 * t)[:, None], sines(seconds, 200.0, k).tau) for k in range(3)]
    (scale,) = prepare(TRUE, runs).scales
    assert scale.distance == pytest.approx(3.0 * 4.0 * 0.5 * seconds, rel=0.01)


def test_uneven_clock_is_noted() -> None:
    from dataclasses import replace

    run = sines(4.0, name="jittery")
    rng = np.random.default_rng(0)
    jittered = replace(run, t=run.t + 0.1 * 0.005 * rng.uniform(-1, 1, len(run.t)))
    prepared = prepare(TRUE, [jittered, sines(4.0, seed=1, name="even")])
    assert any("jittery" in note or "resampled" in note for note in prepared.notes)
    assert np.ptp(np.diff(prepared.fit[0].time)) < 1e-9


def test_degrees_narrow_what_is_analysed_until_it_is_too_short() -> None:
    """Beside the same torque, noise in them is 57 times as much."""
    rng, long = np.random.default_rng(0), sines(4.0, size=0.005)
    long = replace(long, q=long.q + 1e-5 * rng.standard_normal(long.q.shape))
    short = replace(part(long, 0, 60), name="short")
    assert prepare(TRUE, [long], [short])
    long, short = (replace(run, q=np.rad2deg(run.q)) for run in (long, short))
    with pytest.raises(InputError, match=r"found 60 samples, 0.3 s, where .* 5 Hz takes 0.645 s.* units of q and tau"):
        prepare(TRUE, [long], [short])


@pytest.mark.parametrize("samples", [1, 2, 3, 5, 6, 12, 22])
def test_a_run_shorter_than_the_filter_is_refused(samples: int) -> None:
    """Nothing of it would be analysed; better to say so than to fail on it, then or later."""
    runs = [sines(4.0, name=f"{i}") for i in range(3)]
    short = replace(part(runs[0], 0, samples), name="short")
    for given in (([*runs, short],), (runs, [short]), ([short],)):
        with pytest.raises(InputError, match=r"short: too short to be analysed: found \d+ samples"):
            prepare(TRUE, *given)


def test_a_run_of_which_next_to_nothing_is_left_is_refused() -> None:
    """One that rests but for one step, at a sample a second: 2 s of rest on either side are 4 samples."""
    t = np.arange(100.0)
    q = np.where(t < 50.0, 0.0, 1.0) + 1e-5 * np.random.default_rng(0).standard_normal(100)
    slow = Run("slow", t, q[:, None], np.sin(t)[:, None])
    with pytest.raises(InputError, match=r"slow: too short to be analysed: found \d samples"):
        prepare(TRUE, [slow], [replace(slow, name="other")])
