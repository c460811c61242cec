"""A load that some recordings carry is named, and which they are; where it is not, a warning says what to do."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import pytest

from stribeck.effects.placing import entries_of
from stribeck.effects.registry import effect_named, registry
from stribeck.gap.diagnose import diagnose
from stribeck.gap.records.prepare import prepare
from stribeck.gap.result import Diagnosis
from stribeck.model.layout import Placed
from stribeck.run import Run

from ..conftest import NOMINAL, recorded

MASS = 0.5  # kg


def with_load_in(*loaded: int, mass: float = MASS) -> list[Run]:
    with_it = recorded(("payload", {"mass": mass}))
    return [with_it[k] if k in loaded else run for k, run in enumerate(recorded())]


def answered(runs: Sequence[Run], *candidates: str, **asked: Any) -> Diagnosis:
    others = [name for name in registry() if name not in candidates]
    return diagnose(NOMINAL, runs, jobs=1, leave_out=others, **asked)


@pytest.mark.parametrize("loaded", [(1,), (0, 2), (3,), (0, 1, 2)])
def test_it_is_named_with_its_mass_and_its_recordings(loaded: tuple[int, ...]) -> None:
    """Whichever recordings would else have been kept back."""
    runs = with_load_in(*loaded)
    found = answered(runs, "payload", "delay")
    assert (found.verdict, found.named) == ("explained", ("payload",))
    (cause,) = [cause for cause in found.causes if cause.effect == "payload"]
    assert cause.parameters["A"]["mass"].value == pytest.approx(MASS, rel=0.05)
    which = ", ".join(sorted(runs[k].name for k in loaded))
    assert f"payload: in {which} only; the corrected arm carries it: take it off where yours does not" in found.notes
    assert not any("more at the tip" in text for text in found.warnings)
    assert found.models["corrected"].effects[0].effect == "payload"
    assert found.stages[-2].motion["A"] < 0.5 * found.stages[1].motion["A"]


def test_in_all_recordings_it_is_in_none_alone() -> None:
    found = answered(recorded(("payload", {"mass": MASS})), "payload", "delay")
    assert not any(text.startswith("payload: in") for text in found.notes)


def test_where_it_is_no_candidate_a_warning_says_what_to_do() -> None:
    runs = with_load_in(1)
    found = answered(runs, "delay")
    assert any(text.startswith(f"{runs[1].name}: as with 0.") for text in found.warnings)
    assert found.verdict != "no_gap"


def test_recordings_that_are_given_as_held_out_stay_held_out() -> None:
    """Where they alone carry it, no fit knows its mass."""
    runs = with_load_in(1)
    found = answered([runs[0], *runs[2:]], "payload", "delay", held_out=[runs[1]])
    assert found.held_out_runs == (runs[1].name,)
    assert not any(text.startswith("payload: in") for text in found.notes)
    assert any(text.startswith(f"{runs[1].name}: as with 0.") for text in found.warnings)


def test_the_only_recording_with_it_is_not_kept_back() -> None:
    """That is known before a search, which would find nothing."""
    runs, said = with_load_in(2, mass=0.1), list[str]()
    assert [run.name for run in prepare(NOMINAL, runs).held] == [runs[2].name]
    found = answered(runs, "payload", "delay", progress=said.append)
    assert found.named == ("payload",)
    assert not any(text.startswith("once more") for text in said)
    assert runs[2].name not in found.held_out_runs


def test_a_payload_of_the_arm_file_is_in_all_recordings() -> None:
    """A load beyond it is told of, as where it is no candidate."""
    stated = Placed(effect_named("payload"), 0, {"mass": 0.2})
    arm = replace(NOMINAL, effects=entries_of(NOMINAL, [stated]))
    runs = with_load_in(1)
    others = [name for name in registry() if name not in ("payload", "delay")]
    found = diagnose(arm, runs, jobs=1, leave_out=others)
    assert any(text.startswith(f"{runs[1].name}: as with 0.") for text in found.warnings)
    assert not any(text.startswith("payload: in") for text in found.notes)
