"""Positions as they were read: no leaps by a turn, no rows that repeat, and the torque's impulse is kept."""

import dataclasses
import re

import numpy as np
import pytest

from stribeck.run import Run
from stribeck.run.reading import as_read
from stribeck.run.turns import TURN, _turns_apart, in_one_turn

STEP = 0.002


def a_run(rows: int = 3000) -> Run:
    t = STEP * np.arange(rows)
    q = np.column_stack([9.0 * np.sin(1.1 * t), 0.3 * np.cos(2.0 * t)])  # one of them turns over, and back
    return Run("r.csv", t, q, tau=np.sign(q) + q, dq=np.gradient(q, STEP, axis=0), q_ref=q + 0.01)


def wrapped(values: np.ndarray, to: float = np.pi) -> np.ndarray:
    return (values + to) % (2.0 * np.pi) - to


def held(run: Run, rows: np.ndarray) -> Run:
    """Return a run whose positions are read in some rows only, and repeated in between."""
    last = np.searchsorted(rows, np.arange(len(run.t)), "right") - 1
    return dataclasses.replace(run, q=run.q[rows[last]], dq=run.dq[rows[last]])


def test_a_plain_run_is_left_alone() -> None:
    run = a_run()
    assert as_read(run) == (run, ())
    fast = dataclasses.replace(run, q=run.q + 4.5 * (run.t[:, None] > 3.0))  # no turn: what it is, no one knows
    assert as_read(fast) == (fast, ())


@pytest.mark.parametrize("to", [np.pi, 0.0])
def test_a_counter_goes_on_where_it_begins_anew(to: float) -> None:
    run = a_run()
    again, (note,) = as_read(dataclasses.replace(run, q=wrapped(run.q, to), q_ref=wrapped(run.q_ref, to)))
    for made, true in ((again.q, run.q), (again.q_ref, run.q_ref)):
        turns = (made - true) / (2.0 * np.pi)
        np.testing.assert_allclose(turns, np.round(turns[0]) + 0.0 * turns, atol=1e-9)
    assert "q1 (" in note
    assert ("q2 (" in note) == (to == 0.0)  # the second crosses zero, and never half a turn


@pytest.mark.parametrize("speed", [4.0, -9.0])
@pytest.mark.parametrize("lost", [0.05, 0.15, 0.3])
def test_a_counter_that_begins_anew_while_rows_are_missing_goes_on_by_the_speeds_around(
    lost: float, speed: float
) -> None:
    t = STEP * np.arange(2000)
    q = np.column_stack([speed * t + np.sin(3.0 * t), 2.0 * np.sin(3.0 * t)])
    over = t[np.argmax(np.abs(np.diff(wrapped(q[:, 0]))) > 3.0)]
    there = np.abs(t - over) > 0.5 * lost
    torn = wrapped(q[there])
    torn[np.argmax(t[there] > over) + 3, 0] += 1.0  # a wrong reading near the gap tells no speed
    again, _ = as_read(Run("r.csv", t[there], torn, tau=q[there]))
    np.testing.assert_allclose(again.q, q[there], atol=0.05)


def runs_about(*middles: float) -> list[Run]:
    """Runs of a joint that swings about some places, beside one that stays near zero in all of them."""
    t = STEP * np.arange(1500)
    swings = [np.column_stack([m + 0.4 * np.sin(4.0 * t), 0.3 * np.cos(2.0 * t)]) for m in middles]
    return [Run(f"r{k}.csv", t, wrapped(q), tau=q, q_ref=wrapped(q) - 0.01) for k, q in enumerate(swings)]


def test_runs_of_a_joint_whose_counter_begins_anew_lie_in_one_turn() -> None:
    """The third begins beyond half a turn, and the last, which leaps nowhere, is recorded beyond it all along."""
    middles = (3.0, 3.1, 3.5, 3.8)
    runs, notes = runs_about(*middles), list[str]()
    moved = in_one_turn(runs, notes)
    assert moved[0] is runs[0]
    assert [note.partition(":")[0] for note in notes] == ["r2.csv", "r3.csv"]
    assert all(note.endswith("moved by whole turns to where the other recordings are: q1 (+1)") for note in notes)
    for run, middle in zip(moved, middles, strict=True):
        again, _ = as_read(run)
        assert again.q.mean(axis=0) == pytest.approx([middle, 0.0], abs=0.15)
        assert again.q_ref == pytest.approx(again.q - 0.01)


@pytest.mark.parametrize("middles", [(0.5, 2.6, -2.6), (3.0, 3.1, 0.9), (3.0, 3.1, -1.0)])
def test_runs_stay_where_they_are_if_no_counter_begins_anew_or_no_turn_brings_them_nearer(
    middles: tuple[float, ...],
) -> None:
    runs, notes = runs_about(*middles), list[str]()
    made = in_one_turn(runs, notes)
    assert all(one is other for one, other in zip(made, runs, strict=True))
    assert notes == []


def test_a_run_far_from_the_others_stays_where_it_is_when_they_move() -> None:
    """The widest one is moved to the others, of which there are more; the second comes no nearer by any turn."""
    ranges = np.array([[0.0, 2.0], [4.2, 5.0], [TURN, TURN + 1.5], [TURN + 0.1, TURN + 1.4]])
    assert _turns_apart(ranges) == pytest.approx([1.0, 0.0, 0.0, 0.0])


def test_a_wrong_reading_makes_no_counter_that_begins_anew() -> None:
    t = STEP * np.arange(1500)
    runs = [
        Run(name, t, (at + 0.4 * np.sin(4.0 * t))[:, None], tau=t[:, None]) for name, at in (("a", 0.0), ("b", TURN))
    ]
    runs[0].q[500, 0] += 6.1
    assert all(one is other for one, other in zip(in_one_turn(runs, []), runs, strict=True))


def test_where_the_speeds_around_missing_rows_tell_no_turn_positions_are_left_alone() -> None:
    """A joint that swings on through several periods, as fast before as after, and one that is moved to another place.

    Neither has a counter that begins anew.
    """
    t = STEP * np.arange(2000)
    there = np.abs(t - 0.5 * np.pi) > 0.5 * np.pi - 0.2
    q = np.column_stack([2.0 * np.sin(4.0 * t), np.where(t < 1.5, 0.0, 4.0)])[there]
    run = Run("r.csv", t[there], q, tau=q)
    assert as_read(run) == (run, ())


@pytest.mark.parametrize("rows", [[0], [1000], [1000, 1001, 1002], [2998, 2999]])
def test_a_reading_that_went_wrong_is_put_in_line(rows: list[int]) -> None:
    run = a_run()
    q = run.q.copy()
    q[rows, 1] = 0.0 if rows[0] else 1.0
    again, (note,) = as_read(dataclasses.replace(run, q=q))
    assert f"q2 ({len(rows)} times)" in note
    assert "q1" not in note
    np.testing.assert_allclose(again.q, run.q, atol=5e-3)  # an end goes on as it is


def test_blows_steps_and_rests_are_no_wrong_readings() -> None:
    """A link that comes off a stop, one that is moved on and stays there, and one that rests but for a count."""
    t = STEP * np.arange(3000)
    bounced = np.abs(np.sin(1.1 * t))
    moved = 0.1 * np.sin(t) + 0.2 * (t > 3.0)
    rests = 1e-4 * ((np.arange(3000) % 2 == 0) & (t > 2.0))
    still = 1e-4 * (np.arange(3000) % 700 == 600)
    run = Run("r.csv", t, np.column_stack([bounced, moved, rests, still]), tau=np.zeros((3000, 4)))
    assert as_read(run) == (run, ())


def test_what_leaps_all_the_time_is_no_wrong_reading() -> None:
    run = a_run()
    run.q[::50, 1] += 1.0
    assert as_read(run) == (run, ())


@pytest.mark.parametrize("every", [2, 5])
def test_repeated_rows_are_left_out(every: int) -> None:
    run = a_run()
    rows = np.arange(0, 3000, every)
    again, (note,) = as_read(held(run, rows))
    assert re.search(f"every {'second' if every == 2 else '5th'} row", note)
    np.testing.assert_array_equal(again.t, run.t[rows])
    np.testing.assert_array_equal(again.q, run.q[rows])
    assert again.dq is not None
    np.testing.assert_array_equal(again.dq, run.dq[rows])
    impulse = np.cumsum(run.tau * STEP, axis=0)[every - 1 :: every]
    np.testing.assert_allclose(np.cumsum(again.tau * every * STEP, axis=0), impulse, atol=1e-9)
    assert as_read(again) == (again, ())


def test_rests_and_lost_rows_do_not_matter() -> None:
    run = a_run()
    run.q[1000:1500] = run.q[1000]
    late = held(run, np.concatenate([np.arange(0, 2001, 4), np.arange(2003, 3000, 4)]))
    again, _ = as_read(late)
    steps = np.rint(np.diff(again.t) / STEP)
    assert np.count_nonzero(steps != 4.0) <= 2
    assert len(again.t) == pytest.approx(750, abs=2)


def test_what_is_read_now_and_then_or_moves_a_moment_is_left_alone() -> None:
    run = a_run()
    irregular = held(run, np.cumsum([0, *[2, 3, 2, 2, 3] * 249]))
    assert as_read(irregular) == (irregular, ())
    run.q[700:] = run.q[700]
    short = held(run, np.arange(0, 3000, 20))
    assert as_read(short) == (short, ())


def test_an_encoder_that_counts_slowly_is_read_in_every_row() -> None:
    """One count in every fifth row, by a constant speed: no row is a repetition."""
    t = STEP * np.arange(3000)
    q = 1e-3 * np.floor(0.2 * np.arange(3000) + 1e-9)[:, None]
    run = Run("r.csv", t, q, tau=q)
    assert as_read(run) == (run, ())


def interpolated(run: Run, every: int, *, command: bool) -> Run:
    """The run on a clock so many times as fast, by straight lines; its command held or interpolated as well."""
    rows = np.arange((len(run.t) - 1) * every + 1) / every
    t, q, tau = (
        np.column_stack([np.interp(rows, np.arange(len(run.t)), column) for column in values.T])
        for values in (run.t[:, None], run.q, run.tau)
    )
    return Run("r.csv", t[:, 0], np.round(q, 7), tau if command else run.tau[np.floor(rows).astype(int)])


@pytest.mark.parametrize("every", [2, 10])
@pytest.mark.parametrize("command", [True, False])
def test_rows_that_were_interpolated_are_left_out(every: int, command: bool) -> None:
    rng, run = np.random.default_rng(5), a_run()
    run = Run(
        "r.csv", run.t, np.round(run.q + 1e-5 * rng.standard_normal(run.q.shape), 7), rng.normal(size=run.q.shape)
    )
    again, (note,) = as_read(interpolated(run, every, command=command))
    assert re.search(f"straight lines between every {'second' if every == 2 else '10th'} row", note)
    np.testing.assert_allclose(again.t, run.t, atol=1e-9)
    np.testing.assert_allclose(again.q, run.q, atol=1e-12)
    np.testing.assert_allclose(again.tau[:-1], run.tau[:-1], atol=1e-9)


@pytest.mark.parametrize("speed", [0.02, 0.3, 2.0])
@pytest.mark.parametrize("step", [1e-6, 1e-3])
def test_no_row_of_an_encoder_was_interpolated(speed: float, step: float) -> None:
    """At a constant speed its counts lie on lines as well, and at 10 kHz any motion does."""
    for rate in (50.0, 1000.0, 10_000.0):
        t = np.arange(10_000) / rate
        q = step * np.round(speed * np.column_stack([t, np.sin(t)]) / step)
        run = Run("r.csv", t, q, tau=q)
        assert not any("straight" in note for note in as_read(run)[1])
