"""Rivals in the place of what was taken, once the others are there."""

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from joblib import Parallel

from stribeck.effects.registry import effect_named, registry
from stribeck.gap.answer.verdict import causes_of
from stribeck.gap.experiment.proposal import open_question
from stribeck.gap.fitted.model import Model, fit_model, retune, weights_of
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.gap.search.beside import idle, weighed, without_each
from stribeck.gap.search.gates import LEAST_FURTHER, LEAST_GAIN
from stribeck.gap.search.instead import _one_of_each, instead, outdone, with_as_good
from stribeck.gap.search.ordinary import is_ordinary
from stribeck.gap.search.rank import rank
from stribeck.gap.search.screen import screen
from stribeck.gap.search.setting import Setting
from stribeck.gap.search.step import Step
from stribeck.model.layout import Placed

from ..conftest import NOMINAL, recorded

FLOOR = np.array([0.02])
POOL = Parallel(n_jobs=1)


def two_steps(
    hidden: Sequence[tuple[str, dict[str, float]]], first: str, rival: str, second: str
) -> tuple[Prepared, tuple[Step, ...]]:
    """Return recordings, and a search that took one effect before its rival and another one after it."""
    prepared = prepare(NOMINAL, recorded(*hidden))
    base = retune(prepared, FLOOR)

    def fitted(model: Model, name: str) -> Model:
        placed, weights = (*model.placed, Placed(effect_named(name), 0)), weights_of(model, prepared, FLOOR)
        start = dict(screen(prepared, model, weights, placed[-1].effect, 0).start)
        found = fit_model(prepared, placed, weights, model.fit, start)
        return fit_model(prepared, placed, weights_of(found, prepared, FLOOR), found.fit)

    one, other = fitted(base, first), fitted(base, rival)
    steps = []
    for before, *rivals in ((base, one, other), (one, fitted(one, second))):
        ranking = replace(rank(prepared, [before, *rivals], FLOOR, 0), best=1)
        steps.append(Step(before, tuple(rivals), ranking, (1,), (), FLOOR))
    return prepared, tuple(steps)


def setting_of(prepared: Prepared, *library: str) -> Setting:
    """A setting in which only some effects are candidates."""
    out = tuple(name for name in registry() if name not in library)
    return Setting(prepared, FLOOR, 0, POOL, out, frozenset(), lambda text: None)


@pytest.mark.parametrize(
    ("hidden", "first", "gives_way"),
    [("asymmetric_friction", "torque_offset", True), ("torque_offset", "torque_offset", False)],
)
def test_what_was_taken_first_may_be_outdone_later(hidden: str, first: str, gives_way: bool) -> None:
    """A relative that was taken for what a later effect adds to it gives way; the true effect does not."""
    values = {"torque_offset": {"offset": 1.0}, "asymmetric_friction": {"C0": 3.0}}[hidden]
    other = "asymmetric_friction" if first != hidden else "gravity_tilt"
    prepared, steps = two_steps([(hidden, values), ("delay", {"time": 0.02})], first, other, "delay")
    others = instead(prepared, steps, POOL)
    assert [(one.place.key, one.model.placed[-1].effect.name) for one in others] == [((first, 0), other)]
    assert outdone(prepared, steps, others, 0) == ((first, 0) if gives_way else None)
    assert outdone(prepared, steps[:1], [], 0) is None


def test_what_every_arm_has_does_all_the_work_where_it_can() -> None:
    """Beside an offset that was taken first, the sides of friction are unlike by little; without it they are all."""
    hidden = [("asymmetric_friction", {"C0": 3.0})]
    prepared, (first, _) = two_steps(hidden, "torque_offset", "gravity_tilt", "payload")
    offset = first.rivals[0]
    placed = (*offset.placed, Placed(effect_named("asymmetric_friction"), 0, {"coulomb": 0.02, "viscous": 0.02}))
    both = fit_model(prepared, placed, weights_of(offset, prepared, FLOOR), offset.fit, evaluations=1)
    assert is_ordinary(both.placed[1], prepared.scales)
    step = Step(offset, (both,), replace(rank(prepared, [offset, both], FLOOR, 0), best=1), (1,), (), FLOOR)
    found = weighed(prepared, (first, step), without_each(prepared, (first, step), POOL), 0)
    assert idle(found) == (("torque_offset", 0), LEAST_GAIN)


@pytest.mark.parametrize(
    ("gain", "t", "power", "goes"), [(0.1, 1.2, 30.0, True), (0.1, 20.0, 1.2, False), (0.2, 1.2, 30.0, False)]
)
def test_what_is_hardly_there_beside_a_later_effect_goes(gain: float, t: float, power: float, goes: bool) -> None:
    """It keeps half of what the later one would do by itself; what takes as much as a further effect must stays."""
    hidden = [("torque_offset", {"offset": 1.0}), ("delay", {"time": 0.02})]
    prepared, (first, second) = two_steps(hidden, "torque_offset", "gravity_tilt", "delay")
    found = weighed(prepared, (first, second), without_each(prepared, (first, second), POOL), 0)
    assert idle(found) is None
    assert found[0].worth is not None
    faint = replace(
        found[0].worth,
        overall=np.array([0.0, gain]),
        t=np.array([0.0, t]),
        sure=np.array([0.0, 1.0]),
        power=np.array([[power], [power * (1.0 - gain)]]),
    )
    unneeded = idle((replace(found[0], worth=faint), found[1]))
    assert unneeded == ((("torque_offset", 0), LEAST_FURTHER) if goes else None)


@pytest.mark.parametrize(
    ("hidden", "first", "rival", "near"),
    [
        (("delay", {"time": 0.005}), "time_shift", "delay", True),
        (("torque_offset", {"offset": 1.0}), "torque_offset", "gravity_tilt", False),
    ],
)
def test_beside_one_effect_alone_only_what_came_all_but_as_near_is_fitted_again(
    hidden: tuple[str, dict[str, float]], first: str, rival: str, near: bool
) -> None:
    """By weights of what is left, not of the whole gap: constants that are re-tuned had decided there."""
    prepared, steps = two_steps([hidden], first, rival, "payload")
    dear = replace(steps[0].ranking, prior_gain=np.array([0.0, 9.0, 0.0]))  # as if its rival had cost too much
    alone = (replace(steps[0], ranking=dear),)
    assert dear.twins() == [1]
    assert dear.near() == ([1, 2] if near else [1])
    others = instead(prepared, alone, POOL)
    assert [one.model.placed[-1].effect.name for one in others] == ([rival] if near else [])
    found = with_as_good(prepared, alone, without_each(prepared, alone, POOL), others, 0)
    (cause,) = causes_of(found, ("A",), prepared.scales)[0]
    assert cause.equivalent == ((first, rival) if near else (first,))
    assert instead(prepared, (replace(steps[0], passing=()),), POOL) == []  # where nothing was taken


TURNED = [("encoder_offset", {"offset": 0.05}), ("payload", {"mass": 0.5})]  # of one pendulum, as gravity would be
LATE = [("torque_offset", {"offset": 1.0}), ("delay", {"time": 0.02})]


@pytest.mark.parametrize(
    ("hidden", "first", "rival", "second", "alike"),
    [
        (TURNED, "gravity_tilt", "encoder_offset", "payload", True),
        (LATE, "torque_offset", "gravity_tilt", "delay", False),
    ],
)
def test_what_does_as_well_beside_the_others_is_named_along(
    hidden: Sequence[tuple[str, dict[str, float]]], first: str, rival: str, second: str, alike: bool
) -> None:
    """Whether or not the step itself could tell the two apart."""
    prepared, steps = two_steps(hidden, first, rival, second)
    told_apart = replace(steps[0].ranking, prior_gain=np.array([0.0, 9.0, 0.0]))  # as if its rival had cost too much
    steps = (replace(steps[0], ranking=told_apart), steps[1])
    without = without_each(prepared, steps, POOL)
    found = with_as_good(prepared, steps, without, instead(prepared, steps, POOL), 0)
    assert [model.placed[-1].effect.name for model in found[0].as_good] == ([first, rival] if alike else [])
    assert found[1].as_good == ()
    if alike:
        assert {cause.effect: cause.equivalent for cause in causes_of(found, ("A",), prepared.scales)[0]} == {
            first: (first, rival),
            second: (second,),
        }
        assert open_question(found, {first}) == found[0].as_good
        assert open_question(found, {second}) == ()  # what is not named is no question
        assert found[0].as_good[0].rms() == pytest.approx(steps[1].best.rms(), rel=0.02)  # type: ignore[union-attr]


def test_what_was_needless_may_still_do_as_well_as_what_took_its_place() -> None:
    """The search made again without it has not seen it: one pendulum's late command is its late record."""
    prepared, steps = two_steps([("delay", {"time": 0.02})], "time_shift", "torque_offset", "payload")
    late, other = (Placed(effect_named(name), 0, values) for name, values in (("delay", {"time": 0.02}), OFFSET))
    alone = (replace(steps[0], ranking=replace(steps[0].ranking, prior_gain=np.zeros(3))),)
    for gone, named in ((late, ["time_shift", "delay"]), (other, [])):
        others = instead(prepared, alone, POOL, (), [gone])
        assert [one.model.placed[-1].key for one in others] == [gone.key]
        found = with_as_good(prepared, alone, without_each(prepared, alone, POOL), others, 0)
        assert [model.placed[-1].effect.name for model in found[0].as_good] == named
    assert instead(prepared, alone, POOL, ("delay",), [late]) == []


OFFSET = ("torque_offset", {"offset": 0.1})


def test_no_rival_is_tried_where_a_later_effect_has_its_place(monkeypatch: pytest.MonkeyPatch) -> None:
    """A base that rocks is no rival beside a soft shaft at the same joint, though one that slides would be."""
    offset, shaft = Placed(effect_named("torque_offset"), 0), Placed(effect_named("joint_flexibility"), 0)
    rocking, sliding = (Placed(effect_named("base_flexibility", law), 0) for law in ("rocking", "sliding"))

    def model(*placed: Placed) -> Any:
        return SimpleNamespace(placed=placed, fit=None)

    def tried(rival: Placed) -> list[tuple[Placed, ...]]:
        ranking: Any = SimpleNamespace(best=1, order=(2,), overall=np.array([0.0, 0.9, 0.8]))
        first = Step(model(), (model(offset), model(rival)), ranking, (1,), (), FLOOR)
        alone: Any = SimpleNamespace(best=1, order=(), overall=np.array([0.0, 0.9]))
        second = Step(model(offset), (model(offset, shaft),), alone, (1,), (), FLOOR)
        seen: list[tuple[Placed, ...]] = []

        def pool(fits: Any) -> list[Any]:
            seen.extend(given[1] for _, given, _ in fits)
            return [SimpleNamespace(whole=np.array([np.nan])) for _ in fits]

        assert instead(prepared, (first, second), pool) == []
        return seen

    prepared: Any = SimpleNamespace(arm=NOMINAL)
    monkeypatch.setattr("stribeck.gap.search.instead.weights_of", lambda *given: None)
    assert tried(rocking) == []
    assert [placed[-1].effect.law for placed in tried(sliding)] == ["sliding"]


def test_of_models_that_end_in_the_same_effect_the_cheapest_stands() -> None:
    def model(name: str, cost: float) -> Any:
        return SimpleNamespace(placed=(Placed(effect_named(name), 0),), fit=SimpleNamespace(cost=cost))

    dear, cheap, other = model("cogging", 3.0), model("cogging", 2.0), model("delay", 9.0)
    assert _one_of_each([dear, other, cheap]) == [cheap, other]
