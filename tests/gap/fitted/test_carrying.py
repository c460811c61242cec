"""Recordings that carry a load are told from those that do not; whatever an arm has in all of them is no load."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from stribeck.gap.fitted import carrying as module
from stribeck.gap.fitted.carrying import Carrying, carrying, told_apart, unloaded
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.gap.search.setting import Asked
from stribeck.gap.search.tuned import retuned
from stribeck.run import Run

from ..conftest import NOMINAL, conditioned, recorded

MASS = 0.5  # kg


def found_in(runs: Sequence[Run]) -> Carrying | None:
    found = retuned(prepare(NOMINAL, runs), Asked(0, 1, (), lambda text: None))
    return carrying(found.prepared, found.base, found.noise.rms)


@pytest.mark.parametrize("loaded", [(1,), (0, 2), (1, 2, 3)])
def test_those_that_carry_a_load_are_told_with_its_mass(loaded: tuple[int, ...]) -> None:
    without, with_it = recorded(), recorded(("payload", {"mass": MASS}))
    told = found_in([with_it[k] if k in loaded else run for k, run in enumerate(without)])
    assert told is not None
    assert told.loaded == tuple(sorted(without[k].name for k in loaded))
    assert sorted(told.loaded + told.unloaded) == sorted(run.name for run in without)
    assert told.more == pytest.approx(MASS, rel=0.2)


@pytest.mark.parametrize(
    "effects",
    [
        (),
        (("payload", {"mass": MASS}),),
        (("contact", {"stiffness": 60.0, "position": 1.2, "side": 1.0}),),  # in one recording alone
        (("cable_spring", {"stiffness": 8.0, "rest": 0.5}),),
        (("delay", {"time": 0.012}),),
    ],
)
def test_what_is_in_all_recordings_is_no_load(effects: tuple[tuple[str, dict[str, float]], ...]) -> None:
    assert found_in(recorded(*effects)) is None


@pytest.mark.parametrize(
    ("masses", "error", "share", "loaded"),
    [
        ((0.0, 0.01, 0.2, 0.21), 0.005, 0.7, ("b", "d")),
        ((0.0, 0.01, 0.2, 0.21), 0.05, 0.7, ()),  # no surer than by chance
        ((0.0, 0.01, 0.2, 0.21), 0.005, 0.2, ()),  # hardly any of what is left
        ((0.0, 0.07, 0.13, 0.2), 0.001, 0.7, ()),  # no two groups
    ],
)
def test_each_bar_alone_keeps_it_silent(
    masses: Sequence[float], error: float, share: float, loaded: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    found = np.array(masses), np.full(4, error), share
    monkeypatch.setattr(module, "_masses", lambda *given: found)
    runs = [replace(conditioned((1.0,))[0], name=name) for name in "acdb"]
    prepared = replace(prepare(NOMINAL, recorded()), fit=tuple(runs), held=())
    told = carrying(prepared, None, np.ones(1))  # type: ignore[arg-type]
    assert (told.loaded if told else ()) == loaded


def test_of_two_recordings_none_is_told_to_carry_a_load() -> None:
    assert found_in([recorded()[0], recorded(("payload", {"mass": MASS}))[1]]) is None


def names(prepared: Prepared) -> tuple[list[str], list[str]]:
    """Names of the fitted runs, and of the held-out ones."""
    fit, held = ([run.name for run in runs] for runs in (prepared.fit, prepared.held))
    return fit, held


def test_those_without_it_are_told_so_where_some_of_each_kind_are_fitted() -> None:
    prepared = prepare(NOMINAL, recorded())
    fit, held = names(prepared)
    told = told_apart(prepared, Carrying((fit[0],), (*fit[1:], *held), MASS))
    assert unloaded(told) == (*fit[1:], *held)
    assert [run.name for run in (*told.fit, *told.held) if not run.without] == [fit[0]]
    for loaded, light in ((tuple(held), tuple(fit)), (tuple(fit), tuple(held))):
        assert told_apart(prepared, Carrying(loaded, light, MASS)) is prepared


def test_what_recordings_are_told_does_not_hide_the_load() -> None:
    """Asked once more, with a model that has none, they fall in the same two groups."""
    runs = [recorded()[0], recorded(("payload", {"mass": MASS}))[1], *recorded()[2:]]
    found = retuned(prepare(NOMINAL, runs, fitted=[runs[1].name]), Asked())
    first = carrying(found.prepared, found.base, found.noise.rms)
    assert first is not None
    told = told_apart(found.prepared, first)
    assert unloaded(told)
    assert carrying(told, found.base, found.noise.rms) == first
