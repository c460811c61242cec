"""Which of the promising experiments is proposed: by what each tells whichever model is true, and what it asks for."""

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np
import pytest

from stribeck.effects.registry import effect_named
from stribeck.gap.answer import assembly
from stribeck.gap.answer.assembly import Assembly
from stribeck.gap.experiment import proposal
from stribeck.gap.experiment.changes import Change, changes
from stribeck.gap.experiment.choice import Choice, SoFar
from stribeck.gap.experiment.programme import Programme
from stribeck.gap.experiment.proposal import _words, resolved, without_twins
from stribeck.gap.experiment.separation import AS_IT_IS
from stribeck.gap.result import Cause
from stribeck.gap.search.rank import ALIKE
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath
from stribeck.model.values import Signals

from ..conftest import NOMINAL

TOLD, OPEN = 30.0, 0.0  # t values
CHANGE = Change("turn it round")


def proposed(
    promised: Sequence[tuple[Sequence[float], Change]], monkeypatch: pytest.MonkeyPatch, *, as_it_is: bool = False
) -> int:
    """Return which of the experiments is proposed, told how far the next one is from each model (t), and the change.

    -1 where none is.
    """
    offers = [
        SimpleNamespace(nearest=np.array(far), needed=0.0, apart=far[0], furthest=max(far), change=change, k=k)
        for k, (far, change) in enumerate(promised)
    ]

    class Plan:
        def __init__(self, *given: Any) -> None: ...

        def choices(self, *, as_it_is: bool) -> Sequence[Any]:
            return [offer for offer in offers if not as_it_is or offer.change is AS_IT_IS]

    monkeypatch.setattr(proposal, "Plan", Plan)
    monkeypatch.setattr(proposal, "_experiment", lambda plan, choice: choice)
    found: Any = proposal.next_experiment(None, (), np.ones(1), as_it_is=as_it_is)  # type: ignore[arg-type]
    return -1 if found is None else int(found.k)


def test_one_that_stands_out_is_not_the_whole_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    """The likeliest of four may come out far from the others, and these look alike still."""
    one, half = [TOLD, OPEN, OPEN, OPEN], [TOLD, TOLD, OPEN, OPEN]
    assert proposed([(one, AS_IT_IS), (half, AS_IT_IS)], monkeypatch) == 1
    assert proposed([([TOLD] * 4, AS_IT_IS), (half, AS_IT_IS)], monkeypatch) == 0


def test_a_change_is_laborious(monkeypatch: pytest.MonkeyPatch) -> None:
    """A sixth more is worth a wider motion, and no change; of two changes the better one is made."""
    third, half = [TOLD, TOLD, OPEN, OPEN, OPEN, OPEN], [TOLD, TOLD, TOLD, OPEN, OPEN, OPEN]
    most = [TOLD, TOLD, TOLD, TOLD, OPEN, OPEN]
    assert proposed([(third, AS_IT_IS), (half, AS_IT_IS)], monkeypatch) == 1
    assert proposed([(third, AS_IT_IS), (half, CHANGE)], monkeypatch) == 0
    assert proposed([([OPEN] * 6, AS_IT_IS), (half, CHANGE), (most, CHANGE)], monkeypatch) == 2


def test_a_change_is_not_laborious_where_motions_leave_the_likeliest_beside_another(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    motion = [1e-7, 1e-7, OPEN, TOLD], AS_IT_IS
    assert proposed([motion, ([TOLD, OPEN, OPEN, 7.0], CHANGE)], monkeypatch) == 1
    assert proposed([motion, ([OPEN, OPEN, 7.0, TOLD], CHANGE)], monkeypatch) == 0
    assert proposed([motion, ([TOLD, OPEN, OPEN, OPEN], CHANGE)], monkeypatch) == 0  # no more in all


def test_what_tells_nothing_is_not_proposed(monkeypatch: pytest.MonkeyPatch) -> None:
    """But where the cause may be another one, any motion may bring it out."""
    nothing = [([1e-7] * 3, AS_IT_IS), ([OPEN] * 3, CHANGE)]
    assert proposed(nothing, monkeypatch) == -1
    assert proposed(nothing, monkeypatch, as_it_is=True) == 0
    assert proposed([([OPEN, 7.0, 7.0], AS_IT_IS)], monkeypatch) == 0


@pytest.mark.parametrize(("promised", "found"), [(1.01, -1), (3.0, -1), (4.0, 1)])
def test_the_arm_is_not_changed_for_next_to_nothing(
    promised: float, found: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The probabilities of 1.01, 3 and 4 are 5, 16 and 25 %."""
    assert proposed([([0.9, 0.9], AS_IT_IS), ([promised] * 2, CHANGE)], monkeypatch) == found


def test_what_is_told_at_all_is_that_of_any_two_models() -> None:
    """Two pairs that lie apart, the models of each beside one another."""
    far = np.kron(np.ones((2, 2)) - np.eye(2), np.full((2, 2), TOLD))
    choice = Choice(Programme(()), SimpleNamespace(pairs=far), None, None)  # type: ignore[arg-type]
    assert (choice.apart, choice.furthest) == (0.0, TOLD)


def test_the_more_an_effect_does_the_more_must_lie_between() -> None:
    """Two that do all but the same are one story, however surely they differ: the search calls them a class."""
    rows, gained, so_far = 1000.0, 3000.0, SoFar(400.0, np.array([2000.0, 100.0]))
    apart = np.array([[0.0, 12.5, np.sqrt(gained)], [12.5, 0.0, 10.0]])
    prospect = SimpleNamespace(pairs=np.array([[0.0, 12.5], [12.5, 0.0]]), apart=apart, rows=rows)
    choice = Choice(Programme(()), prospect, SimpleNamespace(change=AS_IT_IS), so_far)  # type: ignore[arg-type]
    left = rows + so_far.rows  # squares with what is true, with its rival, and without either
    saved = np.log((left + gained + 2000.0) / left)
    assert np.log((left + gained + 2000.0) / (left + choice.needed[0] ** 2)) == pytest.approx(ALIKE * saved)
    assert choice.needed[1] < 6.0 < 12.5 < choice.needed[0]
    assert resolved(choice.nearest) == pytest.approx(0.985, abs=0.001)
    assert resolved(choice.nearest, choice.needed) == pytest.approx(0.5 * (0.985 + 0.5), abs=0.01)
    alone = replace(choice, options=SimpleNamespace(change=CHANGE))  # is diagnosed by itself
    left = rows
    saved = np.log((left + gained) / left)
    assert np.log((left + gained) / (left + alone.needed[0] ** 2)) == pytest.approx(ALIKE * saved)


def told_of_lateness(
    late: tuple[str, ...], unexplained: bool, monkeypatch: pytest.MonkeyPatch
) -> tuple[Any, list[tuple[int, bool]]]:
    """What is said of a delay or a time shift, and of how many models which experiment was asked for."""
    asked: list[tuple[int, bool]] = []
    placed = [Placed(effect_named(name), joint) for name, joint in (("time_shift", 0), ("delay", 0), ("delay", 1))]
    models = tuple(SimpleNamespace(placed=(place,)) for place in placed)
    monkeypatch.setattr(assembly, "open_question", lambda steps, named: models)
    monkeypatch.setattr(assembly, "late_as_one", lambda steps, joints: late)
    monkeypatch.setattr(assembly, "next_experiment", lambda *given, as_it_is: asked.append((len(given[1]), as_it_is)))
    arm = SimpleNamespace(names=("x_axis", "B"), n=2)
    told: Any = SimpleNamespace(steps=(), prepared=SimpleNamespace(arm=arm), floor=np.ones(1))
    either = [Cause("delay", 0.9, ("x_axis",), ("delay", "time_shift"), presence=0.9)]
    return Assembly._experiment(told, either, unexplained=unexplained), asked


@pytest.mark.parametrize("unexplained", [True, False])
def test_the_arm_is_changed_only_to_tell_a_class_apart(unexplained: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    said, asked = told_of_lateness((), unexplained, monkeypatch)
    assert asked == [(3, unexplained)]
    note = "no experiment was found that tells apart: time shift at x_axis, delay at x_axis, delay at B"
    assert said == (None, [] if unexplained else [note])


def test_a_late_drive_and_a_late_record_of_all_joints_are_no_question_for_a_motion(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Whatever its planning makes of them: the records are the same."""
    (found, (note,)), asked = told_of_lateness(("time_shift", "delay"), False, monkeypatch)
    assert (found, asked) == (None, [])
    assert note.startswith("no motion tells apart: delay and time shift, as every joint is late by as much")
    lag, *twins = (
        SimpleNamespace(placed=(Placed(effect_named(n), 0),)) for n in ("actuator_lag", "delay", "time_shift")
    )
    assert without_twins((lag, *twins), ("delay", "time_shift")) == (lag, twins[0])  # type: ignore[arg-type]


def test_reversed_leads_turn_what_the_drive_adds_and_not_the_pull_of_the_magnets() -> None:
    """Whichever of the two a search has found first."""
    turned = next(change for change in changes(NOMINAL, (0,)) if "polarity" in change.words)
    offset = Placed(effect_named("torque_offset"), 0, {"offset": 0.5})
    cogging = Placed(effect_named("cogging"), 0, {"sine": 0.2, "cosine": 0.0, "harmonic": 4.0})
    for placed in ((offset, cogging), (cogging, offset)):
        path = SignalPath(NOMINAL, turned.around(placed))
        still = Signals(time=0.0, position=0.3, velocity=0.0, acceleration=0.0, link_position=0.3, link_velocity=0.0)
        torque = path.actuated(0, ca.SX(2.0), still, ca.SX(0, 1))
        got = float(ca.Function("torque", [path.p], [torque])(values_of(path.entries)))
        assert got == pytest.approx(2.0 - 0.5 + 0.2 * np.sin(4.0 * 0.3))
    assert "same arm file" in turned.known_by


@pytest.mark.parametrize(
    ("end", "says"), [(1.5, "make sure that the arm has room (B 0.00 to 1.50 rad)"), (0.9, "speed.")]
)
def test_room_is_asked_for_where_the_reference_goes_further_than_the_recordings(end: float, says: str) -> None:
    """Not where it might have gone: a joint that it holds still needs none."""
    seen = [SimpleNamespace(low=-1.0, high=1.0), SimpleNamespace(low=-1.0, high=1.0)]
    joints = tuple(SimpleNamespace(name=name, kind="revolute") for name in "AB")
    plan: Any = SimpleNamespace(
        prepared=SimpleNamespace(arm=SimpleNamespace(joints=joints, names=("A", "B"), n=2)),
        seen=seen,
        models=(),
        duration=lambda choice: 6.0,
    )
    choice: Any = SimpleNamespace(
        options=SimpleNamespace(wider=1.5),
        prospect=SimpleNamespace(pairs=np.full((1, 1), 9.0)),
        programme=SimpleNamespace(words=lambda arm: "a chirp, at B alone"),
        change=AS_IT_IS,
    )
    reference: Any = SimpleNamespace(q=np.array([[0.5, 0.0], [0.5, end]]))
    told = _words(plan, choice, reference)
    assert told.startswith("Record a chirp, at B alone (6 s in all)")
    assert says in told
    assert "A " not in told.split("beyond")[1]
