"""Recordings that carry a load are told from those that do not; whatever an arm has in all of them is no load."""

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stribeck.effects.registry import registry
from stribeck.gap.answer import loads
from stribeck.gap.answer.loads import told_loads
from stribeck.gap.diagnose import diagnose
from stribeck.gap.records.prepare import prepare
from stribeck.gap.search.setting import Asked
from stribeck.gap.search.tuned import retuned
from stribeck.run import Run

from ..conftest import NOMINAL, recorded

MASS = 0.5  # kg


def told(runs: Sequence[Run]) -> list[str]:
    found = retuned(prepare(NOMINAL, runs), Asked(0, 1, (), lambda text: None))
    return told_loads(found.prepared, (found.base,), found.noise.rms)


@pytest.mark.parametrize("loaded", [(1,), (0, 2), (1, 2, 3)])
def test_those_that_carry_a_load_are_told_with_its_mass(loaded: tuple[int, ...]) -> None:
    without, with_it = recorded(), recorded(("payload", {"mass": MASS}))
    (said,) = told([with_it[k] if k in loaded else run for k, run in enumerate(without)])
    names, _, text = said.partition(": ")
    assert names.split(", ") == sorted(without[k].name for k in loaded)
    assert float(text.split()[2]) == pytest.approx(MASS, rel=0.2)


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
    assert not told(recorded(*effects))


@pytest.mark.parametrize(
    ("masses", "error", "share", "said"),
    [
        ((0.0, 0.01, 0.2, 0.21), 0.005, 0.7, ["b, d: as with 0.2 kg more at the tip"]),
        ((0.0, 0.01, 0.2, 0.21), 0.05, 0.7, []),  # no surer than by chance
        ((0.0, 0.01, 0.2, 0.21), 0.005, 0.2, []),  # hardly any of what is left
        ((0.0, 0.07, 0.13, 0.2), 0.001, 0.7, []),  # no two groups
    ],
)
def test_each_bar_alone_keeps_it_silent(
    masses: Sequence[float], error: float, share: float, said: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    found = np.array(masses), np.full(4, error), share
    monkeypatch.setattr(loads, "_masses", lambda *given: found)
    prepared: Any = SimpleNamespace(fit=[SimpleNamespace(name=name) for name in "acdb"], held=())
    text = told_loads(prepared, (None,), np.ones(1))  # type: ignore[arg-type]
    assert [one.partition(" than")[0] for one in text] == said


def test_of_two_recordings_none_is_told_to_carry_a_load() -> None:
    assert not told([recorded()[0], recorded(("payload", {"mass": MASS}))[1]])


def test_a_diagnosis_warns_of_it() -> None:
    runs = [recorded()[0], recorded(("payload", {"mass": MASS}))[1], *recorded()[2:]]
    others = [name for name in registry() if name not in ("payload", "delay")]
    found = diagnose(NOMINAL, runs, jobs=1, leave_out=others)
    assert any(text.startswith(f"{runs[1].name}: as with 0.") for text in found.warnings)
    assert found.verdict != "no_gap"
