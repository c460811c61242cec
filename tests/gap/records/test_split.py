"""Which runs are kept back: whole ones, none twice, that move as the others do."""

import time
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from stribeck.gap.records import split as split_module
from stribeck.gap.records.split import HELD_SHARE, split
from stribeck.run import Run

from ..conftest import sines


def names(runs: list[Run]) -> list[str]:
    """Those of the runs that are kept back."""
    return [run.name for run in split(runs, [])[1]]


def moving(*sizes: float) -> list[Run]:
    """Runs that differ by how far and fast they go."""
    return [sines(3.0, size=size, name=f"{i}") for i, size in enumerate(sizes)]


@given(st.integers(2, 25))
def test_whole_runs_are_kept_back(count: int) -> None:
    runs = [sines(1.0, 50.0, name=f"{i}") for i in range(count)]
    fit, held = split(runs, [])
    assert {run.name for run in fit}.isdisjoint({run.name for run in held})
    assert len(fit) + len(held) == count
    assert fit
    assert held
    assert len(held) <= (count + 2) / 3


def test_single_run_is_cut() -> None:
    run = sines(10.0, name="only")
    notes: list[str] = []
    (fit,), (held,) = split([run], notes)
    assert fit.t[-1] < held.t[0]
    assert np.concatenate([fit.t, held.t]) == pytest.approx(run.t)
    assert np.concatenate([fit.q, held.q]) == pytest.approx(run.q)
    assert len(held.t) == pytest.approx(HELD_SHARE * len(run.t), abs=1)
    assert notes == ["only: the last 30% is held out"]


def test_a_joint_that_rests_is_not_moved_by_its_encoders_noise() -> None:
    """Of six recordings two move the second joint, at whatever rate its noise was read: one of them is kept back."""
    rng, runs = np.random.default_rng(5), []
    for k in range(6):
        run = sines(3.0, 1000.0, seed=k, name=f"{k}")
        rests = 0.3 + 0.05 * (run.q if k in (1, 4) else 0.0 * run.q)
        q = np.column_stack([run.q, rests]) + 1e-4 * rng.standard_normal((len(run.t), 2 * run.n))
        runs.append(replace(run, q=q, tau=np.column_stack([run.tau, run.tau])))
    moved = split_module._moved(split_module._asked(runs), runs[0].n)[:, -1]
    assert moved.tolist() == [k in (1, 4) for k in range(6)]
    assert len({"1", "4"} & set(names(runs))) == 1


def test_a_run_that_goes_where_no_other_goes_is_fitted() -> None:
    """What only one recording shows could not be learnt from the others."""
    runs = [sines(3.0, seed=k, name=f"{k}") for k in range(6)]
    assert names(runs) == ["1", "4"]
    runs[1] = replace(runs[1], tau=3.0 * runs[1].tau)
    fit, held = split(runs, [])
    assert "1" in {run.name for run in fit}
    assert [run.name for run in held] == ["2", "4"]


@pytest.mark.parametrize("rest", [0.0, 0.2, 0.4])
def test_of_a_single_run_a_part_is_held_out_in_which_the_arm_moves(rest: float) -> None:
    run = sines(6.0)
    still = round(rest * len(run.t))
    q = run.q.copy()
    q[len(q) - still :] = q[len(q) - still - 1]
    notes: list[str] = []
    (fit,), (held,) = split([replace(run, q=q)], notes)
    assert len(fit.t) + len(held.t) == len(run.t)
    way = [np.abs(np.diff(part.q, axis=0)).sum() for part in (fit, held)]
    assert way[1] / sum(way) == pytest.approx(0.3, abs=0.06 if rest > 0.2 else 0.2)
    (note,) = notes
    assert f"the last {len(held.t) / len(run.t):.0%} is held out" in note
    assert (f"{len(held.t) / len(run.t):.0%}" == "30%") == (rest < 0.3)


def test_a_run_that_shows_what_no_other_does_is_fitted_however_it_moves() -> None:
    runs = [sines(3.0, seed=k, name=f"{k}") for k in range(6)]
    notes: list[str] = []
    fit, held = split(runs, notes, {"1"})
    assert "1" in {run.name for run in fit}
    assert len(held) == 2
    assert notes == ["1: fitted, for it shows what no other fitted one does"]


def test_runs_that_stand_alone_side_by_side_are_both_fitted() -> None:
    """The last of five would be kept back; it and the one before reach beyond all others."""
    runs = [sines(3.0, name=f"{i}") for i in range(5)]
    runs[3], runs[4] = replace(runs[3], tau=9.0 * runs[3].tau), replace(runs[4], q=4.0 * runs[4].q)
    _, held = split(runs, [])
    assert [run.name for run in held] == ["1", "2"]


def test_two_runs_that_both_stand_alone_are_split_all_the_same() -> None:
    runs = [sines(3.0, name="a"), sines(3.0, seed=1, name="b")]
    runs[0], runs[1] = replace(runs[0], tau=9.0 * runs[0].tau), replace(runs[1], q=2.0 * runs[1].q)
    fit, held = split(runs, [])
    assert [run.name for run in fit] == ["a"]
    assert [run.name for run in held] == ["b"]


def test_the_runs_that_are_kept_back_move_as_the_others_do() -> None:
    """Every third would be the tame ones; one of each kind speaks for all."""
    runs = moving(1.0, 0.1, 1.0, 1.0, 0.1, 1.0)
    assert len({run.name for run in runs if run.name in names(runs)} & {"1", "4"}) == 1


def test_a_run_that_stands_alone_is_not_kept_back_for_being_like_the_rest() -> None:
    """A tame run and the second largest would ask most as the rest does; but no other has its one blow of torque."""
    runs = moving(0.1, 0.85, 0.1, 1.0, 0.1, 0.1)
    assert "1" in names(runs)
    blow = runs[1].tau.copy()
    blow[100] = 3.0 * np.abs(blow).max()
    runs[1] = replace(runs[1], tau=blow)
    assert "1" not in names(runs)
    assert "3" in names(runs)


def test_the_first_recording_is_fitted() -> None:
    """It alone shows what had been before: whether it is given first or not, and even where others would be liker."""
    runs = moving(0.85, 0.1, 0.1, 1.0, 0.1, 0.1)
    assert "0" not in names(runs)
    assert "0" not in names(runs[::-1])


def test_of_runs_that_move_alike_every_third_is_kept_back() -> None:
    """Whatever drifts with time is then seen early and late."""
    assert names(moving(1.0, 1.1, 1.0, 1.1, 1.0, 1.1, 1.0, 1.1)) == ["1", "4", "7"]


def one_by_one(*rows: tuple[float, float]) -> list[Run]:
    """Runs of a first and a second joint that go as far as is said."""
    return [
        replace(run, q=run.q * row, tau=run.tau * row)
        for run, row in zip(moving(*[1.0] * len(rows)), rows, strict=True)
    ]


@pytest.mark.parametrize(
    ("rows", "held"),
    [
        ([(1, 0), (0, 1), (1, 0), (0, 1)], 2),
        ([(1, 0.01), (0, 1), (1, 0.01), (0, 1), (1, 0), (0, 1)], 2),
        ([(1, 0), (1, 0), (1, 0), (1, 0), (0, 1), (0, 1)], 2),
        ([(1, 0), (0, 1), (4, 0), (0, 4)], 2),
        ([(0.05, 0.05), (1, 1), (1.5, 1), (1, 1.5)], 1),
        ([(1, 0), (1, 0), (0, 1)], 1),  # nobody else moves the second
    ],
)
def test_every_joint_that_two_runs_move_is_moved_in_what_is_fitted_and_in_what_is_kept_back(rows, held) -> None:
    runs = one_by_one(*rows)
    parts = split(runs, [])
    assert len(parts[1]) == held
    sizes = np.array(rows, dtype=float)
    for part in parts:
        chosen = [int(run.name) for run in part]
        twice = np.sort(sizes, axis=0)[-2] > 0.0
        assert np.all((sizes[chosen].max(axis=0) >= 0.3 * np.sort(sizes, axis=0)[-2])[twice])


def test_of_two_runs_that_move_a_joint_the_one_that_goes_further_is_fitted() -> None:
    """Both stand alone; what is fitted to little steps says nothing of long ways."""
    assert names(one_by_one((0.3, 0), (0, 2), (2, 0), (0, 0.3))) == ["0", "3"]
    assert names(one_by_one((2, 0), (0, 0.3), (0.3, 0), (0, 2))) == ["1", "2"]


def test_a_run_that_alone_moves_both_joints_with_another_is_exchanged_for_two() -> None:
    """Where it shows what no fitted one does: a limit of torque that only the run reaches which moves both at once."""
    runs, notes = one_by_one((0.4, 0.03), (0, 0.03), (0.9, 0.5), (0.01, 0.9)), []
    assert names(runs) == ["2"]
    fit, held = split(runs, notes, {"2"})
    assert [[run.name for run in part] for part in (fit, held)] == [["1", "2"], ["0", "3"]]
    assert notes == ["2: fitted, for it shows what no other fitted one does"]
    assert [run.name for run in split(runs[1:], [], {"2"})[1]] == ["3"]


def test_a_joint_that_one_run_alone_moves_is_fitted() -> None:
    assert "2" not in names(one_by_one((1, 0), (1, 0), (0, 1)))


@given(st.lists(st.floats(0.01, 10.0), min_size=2, max_size=9))
@example([4.75, 6.0])  # either of two is as far from the other
def test_units_do_not_matter(sizes: list[float]) -> None:
    runs = moving(*sizes)
    other = [replace(run, q=1e3 * run.q, tau=1e-3 * run.tau) for run in runs]
    assert names(runs) == names(other)


@given(st.lists(st.sampled_from([0.0, 0.1, 1.0, 1.2]), min_size=2, max_size=9))
def test_joints_that_rest_are_split_as_well(sizes: list[float]) -> None:
    fit, held = split(moving(*sizes), [])
    assert len(held) == len(range(1, len(sizes), 3))
    assert {run.name for run in (*fit, *held)} == {f"{i}" for i in range(len(sizes))}


@pytest.mark.parametrize("pose", [1e-3, 3.0, 40.0])
def test_a_joint_that_rests_elsewhere_in_each_run_stands_alone_no_more_than_another_can(pose: float) -> None:
    """It has no range of its own to measure that by; it outweighs neither what is shown nor another joint's torque."""
    runs = [replace(run, q=run.q + pose * k * np.array([0.0, 1.0])) for k, run in enumerate(one_by_one(*[(1, 0)] * 6))]
    assert "1" not in [run.name for run in split(runs, [], {"1"})[1]]
    runs[4] = replace(runs[4], tau=9.0 * runs[4].tau)
    assert "4" not in names(runs)


def test_hundreds_of_runs_are_split_in_no_time() -> None:
    runs = [sines(1.0, 50.0, seed=i, size=0.1 + i % 7, name=f"{i}") for i in range(400)]
    begun = time.process_time()
    assert len(names(runs)) == 133
    assert time.process_time() - begun < 5.0
