"""Tasks side by side along recordings that each process is sent once."""

import os
import sys
import time
import warnings
from dataclasses import replace
from pathlib import Path

import pytest
from joblib import delayed

from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.gap.search.pool import Pool

from ..conftest import NOMINAL, recorded


@pytest.fixture(scope="module")
def prepared() -> Prepared:
    return prepare(NOMINAL, recorded())


@pytest.mark.long
@pytest.mark.parametrize("jobs", [1, 2])
def test_what_is_worked_out_along_recordings_is_known_to_the_next_task(prepared: Prepared, jobs: int) -> None:
    def seen(prepared: Prepared, number: int, *, times: int = 1) -> tuple[int, bool, float]:
        known = "moved" in vars(prepared)
        return number * times, known, float(prepared.moved[0].position.sum())

    vars(prepared).pop("moved", None)
    with Pool(jobs) as pool:
        folder = Path(pool._folder.name)
        found = pool(delayed(seen)(prepared, k, times=3) for k in range(12))
        again = pool(delayed(seen)(prepared, k) for k in range(12))
        assert len(list(folder.iterdir())) == (0 if jobs == 1 else 1)
        assert folder.stat().st_mode & 0o077 == 0
    assert not folder.exists()
    assert [number for number, _, _ in found] == list(range(0, 36, 3))
    assert [number for number, _, _ in again] == list(range(12))
    assert sum(not known for _, known, _ in (*found, *again)) <= jobs
    assert len({total for _, _, total in (*found, *again)}) == 1


@pytest.mark.parametrize("jobs", [1, pytest.param(2, marks=pytest.mark.long)])
def test_an_error_leaves_nothing_behind(prepared: Prepared, jobs: int) -> None:
    def fails(prepared: Prepared) -> None:
        raise ArithmeticError("of a task")

    with pytest.raises(ArithmeticError, match="of a task"), Pool(jobs) as pool:
        folder = Path(pool._folder.name)
        pool([delayed(fails)(prepared)])
    assert not folder.exists()


@pytest.mark.long
def test_of_the_recordings_that_were_sent_the_last_are_kept(prepared: Prepared) -> None:
    def cutoff(prepared: Prepared) -> float:
        return prepared.cutoff

    with Pool(2) as pool:
        for k in range(5):
            one = replace(prepared, cutoff=float(k))
            assert pool(delayed(cutoff)(one) for _ in range(3)) == [k] * 3
        assert len(list(Path(pool._folder.name).iterdir())) == 2
        assert pool([delayed(cutoff)(one)]) == [4]


@pytest.mark.long
def test_a_process_that_has_grown_is_replaced_without_a_word(prepared: Prepared) -> None:
    pytest.importorskip("psutil", reason="without it, no process is watched")

    def grows(prepared: Prepared, number: int) -> tuple[int, int]:
        if number > 1:  # what a first task leaves is taken as a process's size
            vars(sys).setdefault("grown", []).append(b"x" * 330_000_000)
            time.sleep(1.1)
        return number, os.getpid()

    with Pool(2) as pool, warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        found = pool(delayed(grows)(prepared, k) for k in range(8))
    assert not said
    assert [number for number, _ in found] == list(range(8))
    assert len({process for _, process in found}) > 2
