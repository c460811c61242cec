"""What each recording leaves: the rows of each, and a word where one stands alone."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.effects.registry import registry
from stribeck.gap.answer.recordings import ALONE, alike_now, held_alone, recordings_of, told_alone
from stribeck.gap.diagnose import diagnose
from stribeck.gap.fitted.model import retune
from stribeck.gap.records.prepare import prepare
from stribeck.gap.result import Recording

from ..conftest import NOMINAL, recorded

FLOOR = np.array([0.02])


def rows(*left: float, joint: str = "A") -> list[Recording]:
    """Recordings of one joint that leave so many times their noise."""
    return [Recording(f"run_{k:02d}.csv", False, joint, 9.0, 0.1 * value, 0.1) for k, value in enumerate(left)]


def test_every_recording_has_its_own_rows() -> None:
    runs = recorded()
    prepared = prepare(NOMINAL, runs)
    base = retune(prepared, FLOOR)
    found = recordings_of(prepared, base, base, FLOOR)
    assert [row.run for row in found] == [run.name for run in (*prepared.fit, *prepared.held)]
    assert [row.held_out for row in found] == [False] * len(prepared.fit) + [True] * len(prepared.held)
    first = base.fit.residual[: len(prepared.fit[0].analysis_index)]
    assert found[0].retuned == pytest.approx(np.sqrt(np.mean(first**2)))
    assert all(row.retuned == row.corrected for row in found)
    assert all(row.noise == pytest.approx(FLOOR[0]) for row in found)


def test_the_parts_of_one_recording_are_told_apart_by_what_they_were_for() -> None:
    prepared = prepare(NOMINAL, recorded()[:1])
    base = retune(prepared, FLOOR)
    assert [row.held_out for row in recordings_of(prepared, base, base, FLOOR)] == [False, True]


def test_one_that_stands_alone_is_told_of() -> None:
    (said,) = told_alone(rows(1.1, 9.0, 1.3))
    assert said.startswith("run_01.csv: A leaves 9 times its noise there and 1.3 times at most in the others")
    assert not told_alone(rows(1.1, 9.0))  # of two, either stands alone
    assert not told_alone(rows(3.0, 9.0, 1.3))
    assert not told_alone(rows(0.1, 0.9, 0.1))  # nothing is left in it
    assert len(told_alone([*rows(1.0, 2.0 * ALONE, 1.0), *rows(1.0, 1.0, 1.0, joint="B")])) == 1
    assert not told_alone([replace(row, noise=0.0) for row in rows(1.0, 9.0, 1.0)])


def test_of_recordings_that_are_held_out_one_that_shows_more_than_all_fitted_ones_is_found() -> None:
    fitted = rows(1.1, 9.0, 1.3)
    alone = [fitted[0], replace(fitted[1], held_out=True), fitted[2]]
    assert held_alone(fitted) == []
    assert held_alone(alone) == ["run_01.csv"]
    assert held_alone(alone[:2]) == ["run_01.csv"]  # of two as well: the other one judges then
    assert held_alone([*alone, replace(rows(8.0)[0], run="another", held_out=True)]) == ["run_01.csv"]  # the loudest
    assert held_alone([*alone, replace(rows(3.0)[0], run="another")]) == []
    assert held_alone([replace(row, corrected=0.1 * row.corrected) for row in alone]) == []  # nothing is left in it
    assert alike_now(alone, rows(2.0, 1.3 * ALONE - 0.1, 2.0))
    assert not alike_now(alone, rows(2.0, 2.0, 1.3 * ALONE + 0.1))
    assert alike_now([*alone, *rows(1.0, 1.0, 1.0, joint="B")], [*rows(1.0, 1.0, 1.0), *rows(9.0, 9.0, 9.0, joint="B")])


WALL = ("contact", {"stiffness": 60.0, "position": 1.2, "side": 1.0})  # only one recording goes there
BENT = ("torque_offset", {"offset": 3.0})


@pytest.mark.long
def test_what_one_recording_alone_shows_is_learnt_from_it() -> None:
    """And not, where the user has said which recordings judge."""
    runs, others = recorded(WALL), [name for name in registry() if name not in ("contact", "torque_offset")]
    found = diagnose(NOMINAL, runs, jobs=1, leave_out=others)
    (wall,) = (run.name for run in runs if run.q.max() > 1.2)
    assert wall in {run.name for run in prepare(NOMINAL, runs).held}
    assert (found.named, found.verdict) == (("contact",), "explained")
    assert wall in found.fit_runs
    assert f"{wall}: fitted, for it shows what no other fitted one does" in found.notes
    fit, held = ([run for run in runs if (run.name == wall) is judges] for judges in (False, True))
    told = diagnose(NOMINAL, fit, held, jobs=1, leave_out=others)
    assert (told.named, told.held_out_runs) == ((), (wall,))


@pytest.mark.slow
def test_what_one_recording_alone_shows_may_be_hidden_by_what_all_show() -> None:
    """It stands out only where that is modelled; then it is learnt from, and not advised against."""
    runs, others = recorded(WALL, BENT), [name for name in registry() if name not in ("contact", "torque_offset")]
    said: list[str] = []
    found = diagnose(NOMINAL, runs, jobs=1, leave_out=others, progress=said.append)
    assert (found.named, found.verdict) == (("torque_offset", "contact"), "explained")
    assert not any("times its noise" in text for text in found.warnings)
    (wall,) = (run.name for run in runs if run.q.max() > 1.2)
    again = said.index(f"once more, with {wall} among what is fitted")
    assert any(text.startswith("screening") for text in said[:again])  # after a search
    assert max(row.retuned / row.noise for row in found.recordings if row.run != wall) > 30.0


LAWS = [name for name in registry() if name != "asymmetric_friction"]


@pytest.mark.long
@pytest.mark.parametrize(("place", "judges"), [(3, False), (2, True)])
def test_a_recording_of_another_arm_is_told_of(place: int, judges: bool) -> None:
    """One that is held out stays so: no effect of one arm makes it like the others."""
    runs, heavier = list(recorded()), recorded(("payload", {"mass": 0.5}))
    runs[place] = replace(heavier[place], name="strange.csv")
    said: list[str] = []
    found = diagnose(NOMINAL, runs, jobs=1, leave_out=LAWS, progress=said.append)
    assert any(text.startswith("strange.csv: A leaves ") for text in found.warnings)
    assert ("strange.csv" in found.held_out_runs) is judges
    assert sum(text.startswith("once more") for text in said) == judges  # in vain, and not tried again


def test_of_recordings_of_one_arm_none_is_told_of() -> None:
    assert not any("times its noise" in text for text in diagnose(NOMINAL, recorded(), leave_out=LAWS, jobs=1).warnings)
