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
from stribeck.gap.experiment import plan as plan_module
from stribeck.gap.experiment import proposal
from stribeck.gap.experiment.changes import Change, changes
from stribeck.gap.experiment.choice import Choice, Options, SoFar, resolved
from stribeck.gap.experiment.motions import Recorded
from stribeck.gap.experiment.plan import Plan, swung
from stribeck.gap.experiment.programme import Programme
from stribeck.gap.experiment.proposal import without_twins
from stribeck.gap.experiment.separation import ANEW, AS_IT_IS
from stribeck.gap.experiment.wording import told_swung, what_to_do
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

    class Offers:
        def __init__(self, *given: Any) -> None: ...

        def choices(self, *, as_it_is: bool) -> Sequence[Any]:
            return [offer for offer in offers if not as_it_is or offer.change is AS_IT_IS]

    monkeypatch.setattr(proposal, "Plan", Offers)
    monkeypatch.setattr(proposal, "swung", lambda prepared: ())
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


def test_what_a_recording_by_itself_tells_needs_no_change(monkeypatch: pytest.MonkeyPatch) -> None:
    third, half = [TOLD, TOLD, OPEN, OPEN, OPEN, OPEN], [TOLD, TOLD, TOLD, OPEN, OPEN, OPEN]
    assert proposed([(third, AS_IT_IS), (half, ANEW), (half, CHANGE)], monkeypatch) == 1
    assert proposed([(third, AS_IT_IS), (half, ANEW), ([TOLD] * 6, CHANGE)], monkeypatch) == 2
    assert proposed([(half, AS_IT_IS), (half, ANEW)], monkeypatch) == 0
    assert proposed([(third, AS_IT_IS), (half, ANEW)], monkeypatch, as_it_is=True) == 0


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
    late: tuple[str, ...], unexplained: bool, monkeypatch: pytest.MonkeyPatch, swings: tuple[str, ...] = ()
) -> tuple[Any, list[tuple[int, bool]]]:
    """What is said of a delay or a time shift, and of how many models which experiment was asked for."""
    asked: list[tuple[int, bool]] = []
    placed = [Placed(effect_named(name), joint) for name, joint in (("time_shift", 0), ("delay", 0), ("delay", 1))]
    models = tuple(SimpleNamespace(placed=(place,)) for place in placed)
    monkeypatch.setattr(assembly, "open_question", lambda steps, named: models)
    monkeypatch.setattr(assembly, "late_as_one", lambda steps, joints: late)
    monkeypatch.setattr(assembly, "next_experiment", lambda *given, as_it_is: asked.append((len(given[1]), as_it_is)))
    monkeypatch.setattr(assembly, "swung", lambda prepared: swings)
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
    (_, notes), _ = told_of_lateness((), unexplained, monkeypatch, ("B",))
    assert notes == [*said[1], "no motion is planned: joint B moves, but is driven in no recording"]


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


def what_is_told(pairs: np.ndarray, q: Sequence[float], kinds: Sequence[str] = ("revolute", "revolute")) -> str:
    """What is said of a motion at the second of two joints, recorded from -1 to 1 at up to 2 per second."""
    joints = tuple(SimpleNamespace(name=name, kind=kind) for name, kind in zip("AB", kinds, strict=True))
    names = ("torque_offset", "asymmetric_friction", "cogging", "contact")[: len(pairs)]
    plan: Any = SimpleNamespace(
        prepared=SimpleNamespace(arm=SimpleNamespace(joints=joints, names=("A", "B"), kinds=kinds, n=2)),
        recorded=Recorded(np.array([-1.0, -1.0]), np.array([1.0, 1.0]), np.array([2.0, 2.0])),
        step=0.1,
        models=tuple(SimpleNamespace(placed=(Placed(effect_named(name), 0),)) for name in names),
        duration=lambda choice: 6.0,
    )
    apart = np.hstack([pairs, np.zeros((len(pairs), 1))])
    prospect = SimpleNamespace(pairs=pairs, apart=apart, rows=1000.0)
    programme = SimpleNamespace(words=lambda arm: "a chirp, at B alone")
    options = SimpleNamespace(change=AS_IT_IS, wider=1.5)
    choice = Choice(programme, prospect, options, SoFar(0.0, np.zeros(len(pairs))))  # type: ignore[arg-type]
    reference: Any = SimpleNamespace(q=np.stack([np.full(len(q), 0.5), q], axis=1))
    anew = what_to_do(plan, replace(choice, options=SimpleNamespace(change=ANEW, wider=1.5)), reference)  # type: ignore[arg-type]
    assert "(6 s in all), and diagnose that by itself with the same arm file: together with the runs so far, " in anew
    told = what_to_do(plan, choice, reference)
    start = "Record a chirp, at B alone (6 s in all), and diagnose it together with the runs so far."
    assert told.startswith(start)
    return told.removeprefix(start)


@pytest.mark.parametrize(
    ("q", "kind", "says"),
    [
        ([0.0, 0.1, 0.2], "revolute", ""),
        ([-1.0, -0.9, -0.8], "revolute", ""),  # as far as it went
        ([0.0, 0.15, 0.3, 0.45, 0.6, 0.75, 0.9, 1.05, 1.2], "revolute",
         " This goes further than recorded, make sure that the arm has room: B 0 to 1.2 rad (recorded -1 to 1)."),
        ([0.0, 0.3, 0.6], "prismatic", " This is faster than recorded: B 3 m/s (recorded 2)."),
    ],
)  # fmt: skip
def test_what_goes_beyond_the_recordings_is_told(q: list[float], kind: str, says: str) -> None:
    """Of joints for which it does: one that is held still needs no room; nothing of a wider motion that does not."""
    assert what_is_told(np.full((1, 1), TOLD), q, ("revolute", kind)) == says


@pytest.mark.parametrize(
    ("told", "says"),
    [
        ([1, 1, 1, 1, 1, 1], ""),
        ([1, 1, 1, 0, 0, 1],
         " It does not tell apart: asymmetric friction and cogging; asymmetric friction and contact."),
        ([1, 1, 1, 0, 0, 0], " It does not tell apart: asymmetric friction, cogging and contact."),
        ([0, 1, 1, 1, 1, 0], " It does not tell apart: torque offset and asymmetric friction; cogging and contact."),
    ],
)  # fmt: skip
def test_what_is_told_with_little_chance_is_said_not_to_be(told: list[int], says: str) -> None:
    """At 3 standard deviations the search hardly tells two, though they are not the same."""
    pairs = np.zeros((4, 4))
    pairs[np.triu_indices(4, 1)] = np.where(np.array(told) == 1, TOLD, 3.0)
    assert what_is_told(pairs + pairs.T, [0.0, 0.1]) == says


def test_chances_are_those_of_two_models_alone() -> None:
    pairs = np.array([[0.0, 12.5], [12.5, 0.0]])
    apart = np.array([[0.0, 12.5, 50.0], [12.5, 0.0, 10.0]])
    prospect = SimpleNamespace(pairs=pairs, apart=apart, rows=1000.0)
    choice = Choice(Programme(()), prospect, SimpleNamespace(change=CHANGE), SoFar(0.0, np.zeros(2)))  # type: ignore[arg-type]
    chance = resolved(choice.nearest, choice.needed)
    assert choice.chances == pytest.approx(np.array([[0.0, chance], [chance, 0.0]]))


def test_an_effect_that_is_told_from_no_other_is_not_separated(monkeypatch: pytest.MonkeyPatch) -> None:
    chances = np.array([[0.0, 0.9, 0.1], [0.9, 0.0, 0.1], [0.1, 0.1, 0.0]])
    monkeypatch.setattr(proposal, "names_of", lambda models, joints: ("delay", "actuator_lag", "backlash"))
    monkeypatch.setattr(proposal, "what_to_do", lambda plan, choice, reference: "")
    alone = SimpleNamespace(apart=1.0)
    plan: Any = SimpleNamespace(
        reference=lambda choice: None,
        models=(),
        prepared=SimpleNamespace(arm=SimpleNamespace(names=("A",))),
        classic=lambda options: alone,
        at_random=lambda options: [alone],
    )
    choice: Any = SimpleNamespace(
        chances=chances, change=AS_IT_IS, apart=1.0, nearest=np.ones(3), needed=0.0, programme=None,
        options=SimpleNamespace(wider=1.0),
    )  # fmt: skip
    assert proposal._experiment(plan, choice).separates == ("delay", "actuator_lag")


def test_a_change_is_offered_within_what_was_recorded_first(monkeypatch: pytest.MonkeyPatch) -> None:
    """A wider motion must promise more there, too, as it must without one."""
    made: Any = object.__new__(Plan)
    made.prepared, made.joints, made.models = SimpleNamespace(arm=NOMINAL), (0,), ()
    monkeypatch.setattr(plan_module, "changes", lambda arm, joints, tilted: [CHANGE, Change("fix a payload")])
    monkeypatch.setattr(made, "options", lambda wider: Options((None,), (None,), (), wider))  # type: ignore[arg-type]
    monkeypatch.setattr(made, "promised", lambda motions, reach, change: motions)
    monkeypatch.setattr(made, "_makes", lambda prospect: True)
    monkeypatch.setattr(made, "best", lambda options: Choice(None, None, options, None))  # type: ignore[arg-type]
    offered = [(choice.options.wider, choice.change.words, choice.change is ANEW) for choice in made.choices()]
    kinds = (("", False), ("", True), (CHANGE.words, False), ("fix a payload", False))
    assert offered == [(wider, *kind) for kind in kinds for wider in (1.0, plan_module.WIDER)]
    assert [choice.change is AS_IT_IS for choice in made.choices(as_it_is=True)] == [True, True]
    third = [TOLD, OPEN, OPEN], CHANGE
    assert proposed([([OPEN] * 3, AS_IT_IS), third, third], monkeypatch) == 1


def test_a_tilt_of_a_horizontal_arm_is_told_by_turning_it() -> None:
    """Whatever its file says of gravity; without a tilt there is nothing to turn."""
    flat = replace(NOMINAL, gravity=(0.0, 0.0))
    told = {arm.gravity: [change.words for change in changes(arm, (), tilted=True)] for arm in (NOMINAL, flat)}
    assert sum("turn the base" in words for words in told[NOMINAL.gravity]) == 1
    assert [words for words in told[flat.gravity] if "turn the base" in words or "stand" in words] == [
        "turn the base by half a turn in the arm's plane, so that a tilt pulls the other way",
        "stand the arm on its side, so that gravity pulls along its plane",
    ]
    assert not any("turn the base" in change.words for change in changes(flat, ()))
    assert not any("stand" in change.words for change in changes(NOMINAL, ()))


@pytest.mark.parametrize(("still", "idle", "held", "found"), [
    (False, True, False, ("B",)), (True, True, False, ()), (False, False, False, ()), (False, True, True, ()),
])  # fmt: skip
def test_no_motion_is_planned_where_a_joint_is_swung(
    still: bool, idle: bool, held: bool, found: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """It moves, but no command moves it; one that is held, or stands still, is left where it is."""
    run = SimpleNamespace(undriven=np.array([False, idle]), braked=np.array([False, held]))
    prepared: Any = SimpleNamespace(fit=(run,), held=(run,), cutoff=10.0, arm=SimpleNamespace(names=("A", "B")))
    reach = (SimpleNamespace(still=False), SimpleNamespace(still=still))
    monkeypatch.setattr(plan_module, "reaches", lambda runs, cutoff: reach)
    assert swung(prepared) == found
    if found:
        assert proposal.next_experiment(prepared, (), np.ones(2)) is None
        assert told_swung(found) == ["no motion is planned: joint B moves, but is driven in no recording"]
    assert told_swung(("B", "C")) == ["no motion is planned: joints B, C move, but are driven in no recording"]
    assert told_swung(()) == []
