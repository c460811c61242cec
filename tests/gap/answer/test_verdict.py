"""The arithmetic of the verdict: probabilities that behave."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stribeck.effects.registry import effect_named
from stribeck.gap.answer.verdict import (
    NAMED_OVER,
    NONE_OVER,
    UNKNOWN_HELD,
    causes_of,
    named_of,
    no_gap_probability,
    suspected,
    with_idle,
)
from stribeck.gap.records.spread import Noise
from stribeck.gap.result import Cause
from stribeck.gap.search.rank import Ranking
from stribeck.gap.search.step import Step
from stribeck.model.layout import Placed
from stribeck.model.scale import Scale

from ..conftest import fitted, ranked, taken_steps, with_effects

FLOOR = np.array([0.1, 0.4])
SCALES = (Scale(1.0, 1.0, 1.0, 1.0, 1.0, 1e-3),) * 2


def rows(*rms: float) -> np.ndarray:
    """Residual (M, n) of given rms (n,), signs mixed."""
    signs = np.where(np.arange(400) % 2, 1.0, -1.0)
    return np.asarray(signs[:, None] * np.array(rms))


def test_what_came_nearest_is_suspected() -> None:
    """Probabilities sum to what there is to share, nothing suspected comes near a name, "unknown" keeps most."""
    found = suspected(step("delay", "delay", "payload", "cogging"), 0.96, ("A", "B"))
    assert sum(cause.probability for cause in found) == pytest.approx(0.96)
    assert found[-1].effect == "unknown"
    assert found[-1].probability == pytest.approx(UNKNOWN_HELD * 0.96)
    assert all(0.0 < (cause.presence or 0.0) < NAMED_OVER for cause in found[:-1])
    assert [cause.effect for cause in found[:-1]] == ["delay", "payload"]


@pytest.mark.parametrize(
    ("fitted", "held", "torque", "silent"),
    [
        (1.0, 1.0, 10.0, True),
        (4.0, 1.0, 10.0, False),
        (1.0, 4.0, 10.0, False),
        (1e4, 1.0, 10.0, False),
        (1.45, 1.45, 10.0, True),  # the floor is off by as much
        (1.45, 1.45, 0.5, False),  # and hardly by a quarter of the torque
        (1.0, 1.0, 0.5, True),
    ],
)
def test_a_gap_that_either_kind_of_run_shows_is_one(fitted: float, held: float, torque: float, silent: bool) -> None:
    """The more of the torque is left, the fewer floors of it may be nothing."""
    floor = np.array([0.1])
    whole = np.concatenate([fitted * rows(0.1), held * rows(0.1)])
    base: Any = SimpleNamespace(whole=whole, rows=None, rms=lambda: held * floor)
    turned_down: Any = SimpleNamespace(base=base, ranking=SimpleNamespace(probability=np.array([1.0])))
    scales = (replace(SCALES[0], torque=torque),)
    assert (no_gap_probability(turned_down, Noise(rows(0.1), rows(0.1)), floor, scales) > NONE_OVER) == silent


def test_where_nothing_was_tried_all_is_unknown() -> None:
    assert suspected(step(), 0.9, ("A",)) == [Cause("unknown", 0.9)]


def step(*effects: str) -> Step:
    """The last step of a search, its rivals in the order of their score, as far as the question looks at it."""
    models = tuple(fitted([Placed(effect_named(name), k % 2)], FLOOR) for k, name in enumerate(effects))
    ranking = replace(ranked(0.0, 0.0, np.ones((2, 2))), order=tuple(range(1, len(models) + 1)))
    return Step(fitted([], FLOOR), models, ranking, (), (), FLOOR)


def late(
    *times: float, effects: tuple[str, ...] = ("delay", "delay"), candidates: tuple[str, ...] = ("time_shift",)
) -> list[Step]:
    """The steps of a search that took a delay at each of the joints, one after the other."""
    placed = [Placed(effect_named(e), j, {"time": t}) for j, (e, t) in enumerate(zip(effects, times, strict=True))]
    return taken_steps(placed, [8.0] * len(placed), gap=FLOOR, floor=FLOOR, candidates=candidates)


@pytest.mark.parametrize(
    ("steps", "same"),
    [
        (late(0.010, 0.011), True),
        (late(0.010, 0.020), False),  # not by the same
        (late(0.010, effects=("delay",)), False),  # not all joints
        (late(-0.010, -0.010, effects=("time_shift", "time_shift"), candidates=("delay",)), False),  # no law is early
        (late(0.010, 0.010, effects=("time_shift", "time_shift"), candidates=("delay",)), True),
        (late(0.010, 0.010, candidates=()), False),  # left out
    ],
)
def test_late_by_the_same_everywhere(steps: list[Step], same: bool) -> None:
    """Which of the two records is late cannot be told where all joints share it."""
    (cause,), _ = causes_of(steps, ("A", "B"), SCALES)
    other = {"delay": "time_shift", "time_shift": "delay"}[cause.effect]
    assert (other in cause.equivalent) is same


@pytest.mark.parametrize(("time", "same"), [(0.010, True), (-0.010, False)])
def test_records_that_share_a_clock_are_late_at_all_joints(time: float, same: bool) -> None:
    placed = [Placed(effect_named("time_shift", "all_joints"), 0, {"time": time})]
    steps = taken_steps(placed, [8.0], gap=FLOOR, floor=FLOOR, candidates=("delay",))
    (cause,), _ = causes_of(steps, ("A", "B"), SCALES)
    assert cause.joints == ("A", "B")
    assert ("delay" in cause.equivalent) is same
    slight = (Placed(effect_named("delay"), 1, {"time": 1e-5}),)  # what every arm has, re-tuned along
    steps[0] = with_effects(steps[0], slight, (*slight, *placed))
    assert ("delay" in causes_of(steps, ("A", "B"), SCALES)[0][0].equivalent) is same
    (near, _) = suspected(replace(steps[0], passing=()), 0.9, ("A", "B"))
    assert near.joints == ("A", "B")


@pytest.mark.parametrize(
    ("stiffness", "position", "leaned_on"), [(9.0, 0.1, True), (9.0, 0.3, False), (-9.0, 0.3, True), (-9.0, 0.1, False)]
)
def test_a_stop_that_is_leaned_on_most_of_the_time_may_be_a_cable(
    stiffness: float, position: float, leaned_on: bool
) -> None:
    """The joint spends half of its time on either side of 0.2 rad."""
    scale = replace(SCALES[0], middle=0.2)
    values = {"stiffness": stiffness, "position": position, "damping": 0.1}
    assert effect_named("contact").also(values, scale) == (("cable_spring",) if leaned_on else ())
    steps = late(0.01, effects=("contact",), candidates=("cable_spring",))
    steps[0] = with_effects(steps[0], (), [Placed(effect_named("contact"), 0, values)])
    (cause,), _ = causes_of(steps, ("A", "B"), (scale, scale))
    assert cause.equivalent == (("contact", "cable_spring") if leaned_on else ("contact",))


def test_what_closes_nothing_in_the_delivered_model_is_not_named() -> None:
    sure, idle = Cause("delay", 0.6, ("A",), presence=0.97), Cause("cogging", 0.3, ("B",), presence=0.97)
    assert named_of([sure, idle]) == ("delay", "cogging")
    causes, left = with_idle([sure, idle], ["cogging"])
    assert named_of(causes) == ("delay",)
    assert sum(cause.probability for cause in causes) + left == pytest.approx(1.0)
    assert left == pytest.approx(0.1 + 0.15)


def test_a_joint_is_named_as_an_effect_is() -> None:
    """What the search took at another joint as well, and is unsure of there, is not told of that joint."""
    placed = [Placed(effect_named("delay"), j, {"time": time}) for j, time in enumerate((0.02, 0.005))]
    steps = taken_steps(placed, [8.0, 8.0], gap=FLOOR, floor=FLOOR)
    (cause,), _ = causes_of(steps, ("A", "B"), SCALES)
    assert cause.joints == ("A", "B")
    unsure = ranked(0.5, 0.02, steps[0].ranking.power)
    steps[1] = replace(steps[1], ranking=unsure)
    (cause,), _ = causes_of(steps, ("A", "B"), SCALES)
    assert (named_of([cause]), cause.joints) == (("delay",), ("A",))
    steps[0] = replace(steps[0], ranking=unsure)
    (cause,), _ = causes_of(steps, ("A", "B"), SCALES)
    assert (named_of([cause]), cause.joints) == ((), ("A", "B"))


@pytest.mark.parametrize(("first", "last", "named"), [(0.01, 0.05, True), (0.05, 0.01, False)])
def test_what_every_arm_has_is_told_by_the_last_values(first: float, last: float, named: bool) -> None:
    """An encoder's offset of a degree may grow to three once what hid it is there, or shrink."""
    offset = effect_named("torque_offset")
    places = [Placed(effect_named("encoder_offset"), 0, {"offset": first}), Placed(offset, 0, {"offset": 0.5})]
    steps = taken_steps(places, (40.0, 20.0), gap=FLOOR, floor=FLOOR)
    steps[-1] = with_effects(steps[-1], places[:1], (replace(places[0], values={"offset": last}), places[1]))
    causes, _ = causes_of(steps, ("A", "B"), SCALES)
    assert ("encoder_offset" in named_of(causes)) == named


def test_what_may_stand_for_it_is_told_of_the_joint_where_it_does() -> None:
    """A stop at each of two joints, of which one leans on its own all the time."""
    scale = replace(SCALES[0], middle=0.2)
    places = [
        Placed(effect_named("contact"), j, {"stiffness": 9.0, "position": where, "damping": 0.1})
        for j, where in enumerate((0.3, 0.1))
    ]
    steps = taken_steps(places, (40.0, 20.0), gap=FLOOR, floor=FLOOR, candidates=("cable_spring",))
    (cause,), _ = causes_of(steps, ("A", "B"), (scale, scale))
    assert cause.equivalent == ("contact", "cable_spring")
    assert cause.alike == {"A": ("contact",), "B": ("contact", "cable_spring")}


def test_what_may_stand_for_it_is_told_by_the_last_values() -> None:
    """A stop that is leaned on once all is known may be a cable."""
    values = {"stiffness": 9.0, "position": 0.3, "damping": 0.1}
    places = [Placed(effect_named("contact"), 0, values), Placed(effect_named("delay"), 0, {"time": 0.02})]
    scale = replace(SCALES[0], middle=0.2)
    steps = taken_steps(places, (40.0, 20.0), gap=FLOOR, floor=FLOOR, candidates=("cable_spring",))
    leaning = replace(places[0], values={**values, "position": 0.1})
    steps[-1] = with_effects(steps[-1], places[:1], (leaning, places[1]))
    causes, _ = causes_of(steps, ("A", "B"), (scale, scale))
    assert causes[0].equivalent == ("contact", "cable_spring")


@pytest.mark.parametrize(
    ("apart", "together", "joints", "anywhere"),
    [
        ((2.0, 1.5), 12.0, ("A", "B"), True),  # each does the other's work
        ((2.0, 1.5), 2.2, ("A", "B"), True),  # nor is all of it worth much: it is not named
        ((12.0, 1.5), 12.0, ("A",), False),  # one is there for sure
        ((12.0, 11.0), 14.0, ("A", "B"), False),
    ],
)
def test_what_is_there_at_one_joint_or_another(
    apart: tuple[float, float], together: float, joints: tuple[str, ...], anywhere: bool
) -> None:
    def worth(t: float) -> Ranking:
        size = t**2 / 16.0
        power = np.array([[size + 1.0] * 2, [1.0] * 2])
        return ranked(t, size / (size + 1.0), power)

    placed = [Placed(effect_named("presliding"), j, {"stiffness": 50.0, "damping": 1.0}) for j in (0, 1)]
    steps = taken_steps(placed, [8.0, 8.0], gap=FLOOR, floor=FLOOR)
    steps = [replace(step, worth=worth(t), together=worth(together)) for step, t in zip(steps, apart, strict=True)]
    (cause,), left = causes_of(steps, ("A", "B"), SCALES)
    assert cause.joints == joints
    assert cause.anywhere is anywhere
    assert (named_of([cause]) == ("presliding",)) is (max(*apart, together) > 10.0)
    assert cause.probability + left == pytest.approx(1.0)
    steps = [replace(step, together=None) for step in steps]
    (alone,), _ = causes_of(steps, ("A", "B"), SCALES)
    assert (alone.presence == cause.presence) is not anywhere
    assert not alone.anywhere
