"""A link of another length than the arm file has is told of, with its length; what arms lack is no length."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stribeck.arm import Arm, Friction, Joint
from stribeck.gap import diagnose
from stribeck.gap.answer import conventions as conventions_module
from stribeck.gap.answer.conventions import Convention, told_conventions
from stribeck.gap.answer.stages import stages_of
from stribeck.gap.fitted.model import Model
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.gap.search import lengths as module
from stribeck.gap.search.lengths import asked_lengths, of_asked_lengths, told_lengths
from stribeck.gap.search.setting import Asked
from stribeck.gap.search.tuned import Retuned, retuned
from stribeck.identify.residual import Residual
from stribeck.model.layout import values_of
from stribeck.model.path import SignalPath
from stribeck.run import Run
from stribeck.withheld.arms import misinformed
from stribeck.withheld.excitation import programme
from stribeck.withheld.injections import Injection
from stribeck.withheld.recorder import default_gains, record

UPPER, LOWER = Friction(2.6, 0.9, 0.8, 0.06), Friction(1.1, 0.4, 0.3, 0.05)
TRUE = Arm(
    "two links that hang",
    (9.81, 0.0),
    (
        Joint("A", "revolute", 0.36, 4.0, (0.17, 0.0), 0.05, 0.1, UPPER, UPPER, 80.0, 2e-5),
        Joint("B", "revolute", 0.3, 2.2, (0.14, 0.0), 0.02, 0.03, LOWER, LOWER, 40.0, 2e-5),
    ),
    sample_time=0.004,
)
NOMINAL = misinformed(TRUE, np.random.default_rng(3), 0.05, 0.2)


@cache
def recorded(effect: str = "", joint: str = "A", **values: float) -> tuple[Run, ...]:
    """Four runs, 5 s each, by the independent plant, with an effect hidden in them."""
    motions = programme(
        NOMINAL, np.random.default_rng(1), ("multisine", "via points", "multisine", "slow reversals"), 5.0
    )
    hidden = [Injection(effect, joint, values)] if effect else []
    return record(TRUE, hidden, motions, rate=250.0, noise=1e-5, gains=default_gains(NOMINAL), model=NOMINAL, seed=5)


def longer(times: float, joint: int = 0) -> Arm:
    """The arm file with a link that is so many times as long."""
    joints = list(NOMINAL.joints)
    joints[joint] = replace(joints[joint], length=times * joints[joint].length)
    return replace(NOMINAL, joints=tuple(joints))


def begun(arm: Arm, runs: tuple[Run, ...]) -> Retuned:
    return retuned(prepare(arm, runs), Asked(0, 1, (), lambda text: None))


def asked_of(arm: Arm, runs: tuple[Run, ...]) -> np.ndarray | None:
    found = begun(arm, runs)
    return asked_lengths(found.prepared, found.base, found.noise.rms)


@pytest.mark.parametrize("times", [1.1, 0.92])
def test_the_length_that_recordings_ask_for_is_the_true_one(times: float) -> None:
    asked = asked_of(longer(times), recorded())
    assert asked is not None
    assert asked[0] == pytest.approx(TRUE.joints[0].length, rel=0.01)
    assert asked[1] == NOMINAL.joints[1].length


def test_nothing_is_asked_for_where_lengths_are_right_or_make_no_difference() -> None:
    assert asked_of(NOMINAL, recorded()) is None
    assert asked_of(longer(1.1, joint=1), recorded()) is None  # nothing hangs from the tip


@pytest.mark.long
@pytest.mark.parametrize(
    ("effect", "joint", "values"),
    [
        ("gravity_tilt", "A", {"x": -0.08, "y": 1.2}),
        ("payload", "B", {"mass": 1.0}),
        ("base_flexibility", "A", {"stiffness": 3000.0}),
        ("joint_flexibility", "A", {"stiffness": 1500.0}),
        ("torque_gain", "A", {"gain": 0.8}),
        ("encoder_offset", "B", {"offset": 0.08}),
        ("cable_spring", "B", {"stiffness": 3.0, "rest": 0.4}),
        ("delay", "B", {"time": 0.012}),
    ],
)
def test_what_an_arm_lacks_is_no_length(effect: str, joint: str, values: dict[str, float]) -> None:
    assert asked_of(NOMINAL, recorded(effect, joint, **values)) is None


@pytest.mark.parametrize(
    ("effect", "joint", "values"),
    [("cogging", "A", {"amplitude": 1.0, "harmonic": 9.0, "phase": 0.0}), ("torque_dead_zone", "B", {"width": 0.5})],
)
def test_what_an_effect_makes_at_one_joint_hides_no_length(effect: str, joint: str, values: dict[str, float]) -> None:
    asked = asked_of(longer(1.1), recorded(effect, joint, **values))
    assert asked is not None
    assert asked[0] == pytest.approx(TRUE.joints[0].length, rel=0.02)


@pytest.mark.parametrize(
    ("before", "after", "promise", "step", "found"),
    [
        ((10.0, 10.0), (10.0, 1.0), 0.5, 0.1, True),  # at one joint will do
        ((10.0, 10.0), (10.0, 3.0), 0.5, 0.1, False),  # closes too little
        ((10.0, 10.0), (12.0, 1.0), 0.5, 0.1, False),  # at the cost of the other
        ((10.0, 0.5), (1.0, 0.9), 0.5, 0.1, True),  # noise is no cost
        ((2.0, 2.0), (1.0, 1.0), 0.5, 0.1, False),  # nothing stands out
        ((10.0, 10.0), (1.0, 1.0), 0.1, 0.1, False),  # looked for no further
        ((10.0, 10.0), (1.0, 1.0), 0.5, 0.005, False),  # as drawn
        ((10.0, 10.0), (1.0, 1.0), 0.5, 0.35, False),  # no such arm
    ],
)
def test_each_bar_alone_keeps_it_silent(
    before: tuple[float, float],
    after: tuple[float, float],
    promise: float,
    step: float,
    found: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tuned = begun(NOMINAL, recorded())
    fitted = replace(tuned.base)
    steps = iter((step, *[0.0] * 9))
    monkeypatch.setattr(module, "_over", lambda model, floor: np.array(before if model is tuned.base else after))
    monkeypatch.setattr(module, "_step", lambda *_: (promise * tuned.base.fit.cost, np.array([next(steps)])))
    monkeypatch.setattr(module, "retune", lambda *_, **__: fitted)
    asked = asked_lengths(tuned.prepared, tuned.base, tuned.noise.rms)
    assert (asked is not None) is found
    if asked is not None:
        assert asked == pytest.approx([1.1 * NOMINAL.joints[0].length, NOMINAL.joints[1].length])


def test_any_of_several_models_may_show_it_and_once_is_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    tuned, asked, seen = begun(NOMINAL, recorded()), Asked(0, 1, (), lambda text: None), list[Model]()
    lengths = 1.1 * np.array([joint.length for joint in NOMINAL.joints])

    def some(prepared: Prepared, model: Model, floor: np.ndarray) -> np.ndarray | None:
        seen.append(model)
        return lengths if model is right else None

    monkeypatch.setattr(module, "asked_lengths", some)
    astray = replace(tuned.base, held=np.full_like(tuned.base.held, np.inf))
    other, right = replace(tuned.base), replace(tuned.base)
    again = of_asked_lengths(tuned, [astray, other, right], tuned.noise.rms, asked)
    assert seen[0] is other
    assert again is not None
    assert [joint.length for joint in again.prepared.arm.joints] == lengths.tolist()
    assert np.allclose(again.given, tuned.given)  # the file's model leaves what it left
    assert len(told_lengths(again.prepared)) == 2
    assert of_asked_lengths(again, [right], tuned.noise.rms, asked) is None
    assert of_asked_lengths(tuned, [other], tuned.noise.rms, asked) is None


@pytest.mark.long
def test_the_gap_is_judged_with_the_length_asked_for_and_the_file_s_stands_beside_it() -> None:
    arm = longer(1.1)
    said: list[str] = []
    found = diagnose(arm, recorded(), jobs=1, progress=said.append)
    first = next(i for i, text in enumerate(said) if text.startswith("screening"))
    assert "again, with links of other lengths" in said[:first]  # a search would take long and for nothing
    assert (found.verdict, found.named) == ("no_gap", ())
    assert [text for text in found.warnings if "A: the recordings ask for a length of 0.36 m" in text]
    assert found.models["as_given"].joints[0].length == arm.joints[0].length
    assert found.models["corrected"].joints[0].length == pytest.approx(TRUE.joints[0].length, rel=0.01)
    given = next(stage.torque["A"] for stage in found.stages if stage.stage == "as_given")
    assert given == pytest.approx(_as_given(arm, recorded()), rel=0.3)  # by the file's length, whatever the band


def _as_given(arm: Arm, runs: tuple[Run, ...]) -> float:
    prepared = prepare(arm, runs)
    path = SignalPath(arm)
    return float(np.sqrt(np.mean(Residual(path, prepared.held, ()).value(values_of(path.entries))[:, 0] ** 2)))


def test_the_file_s_arm_is_what_is_given_wherever_it_is_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    prepared = prepare(longer(1.1), recorded())
    other = replace(prepared, arm=longer(1.0))
    simulated: list[Arm] = []

    def of_arm(arm: Arm) -> tuple[dict[str, float], str]:
        simulated.append(arm)
        return {}, ""

    motions: Any = SimpleNamespace(prepared=other, of_arm=of_arm, of=lambda model: ({}, ""))
    none = np.zeros((1, 2))
    stages_of(motions, none, [begun(NOMINAL, recorded()).base], [none], np.ones(2))
    asked: list[Arm] = []

    def as_recorded(arm: Arm) -> Iterator[Convention]:
        asked.append(arm)
        yield Convention("", np.eye(2), np.eye(2))

    monkeypatch.setattr(conventions_module, "conventions", as_recorded)
    given = np.full((sum(len(run.analysis_index) for run in other.held), 2), 1e3)
    told = told_conventions(other, given)
    assert simulated == asked == [longer(1.1)]
    assert len(told) == 1


def test_no_warning_without_another_length() -> None:
    assert told_lengths(prepare(NOMINAL, recorded())) == []


def test_a_fit_that_runs_away_asks_for_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    def astray(prepared: Prepared, floor: np.ndarray, placed: object, known: object) -> Model:
        return replace(found.base, held=np.full_like(found.base.held, np.inf))

    found = begun(longer(1.1), recorded())
    monkeypatch.setattr(module, "retune", astray)
    assert asked_lengths(found.prepared, found.base, found.noise.rms) is None
