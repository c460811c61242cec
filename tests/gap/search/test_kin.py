"""What only fills in for a stronger effect of its own phenomenon is not named; what is of another kind, is."""

from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest

from stribeck.effects.registry import effect_named, laws
from stribeck.gap.answer.verdict import NAMED_OVER, causes_of
from stribeck.gap.search.kin import EDGED, filling_in
from stribeck.gap.search.step import Step
from stribeck.model.layout import Placed
from stribeck.model.scale import BENDS, Scale

from ..conftest import fitted, taken_steps, with_effects

FLOOR = np.ones(2)
SCALES = (Scale(1.0, 1.0, 1.0, 1.0, 1.0, 1e-3, middle=0.2),) * 2


def taken(*found: tuple[str, int, float], late: float = 0.01, left: float = 4.0) -> list[Step]:
    """The steps of a search: each an effect, its joint, what it takes of the squared residual and leaves, in floors."""
    values = {"time": late, "time_constant": late, "harmonic": 6.0}
    placed = [Placed(effect_named(name), joint, values) for name, joint, _ in found]
    return taken_steps(placed, [size for _, _, size in found], gap=FLOOR, floor=FLOOR, left=left)


@pytest.mark.parametrize(
    ("found", "fills"),
    [
        ([("actuator_lag", 0, 9.0), ("delay", 0, 4.0)], [False, True]),
        ([("delay", 0, 4.0), ("actuator_lag", 0, 9.0)], [True, False]),
        ([("actuator_lag", 0, 9.0), ("delay", 1, 4.0)], [False, False]),
        (
            [("position_dependent_friction", 1, 9.0), ("torque_ripple", 1, 5.0), ("cogging", 1, 2.0)],
            [False, True, True],
        ),
        ([("contact", 0, 9.0), ("torque_ripple", 0, 5.0)], [False, False]),
        ([("presliding", 0, 9.0), ("payload", 0, 5.0)], [False, False]),
    ],
)
def test_the_weaker_of_two_of_a_kind_at_a_joint_fills_in(
    found: list[tuple[str, int, float]], fills: list[bool]
) -> None:
    assert filling_in(taken(*found), SCALES) == fills


@pytest.mark.parametrize(
    ("larger", "smaller"),
    [
        ("torque_ripple", "encoder_eccentricity"),
        ("negative_damping", "quadratic_damping"),
        ("actuator_lag", "time_shift"),  # of the drive, and of the record
    ],
)
def test_what_ends_at_the_noise_is_there_beside_its_kin(larger: str, smaller: str) -> None:
    both = (larger, 0, 20.0), (smaller, 0, 9.0)
    assert filling_in(taken(*both, left=1.5), SCALES) == [False, False]
    assert filling_in(taken(*both, left=2.5), SCALES) == [False, True]


def test_an_edge_that_ends_at_the_noise_is_there_beside_a_wave() -> None:
    """Laid over a wave, it would leave a thirtieth; and so would the wave laid over what it leaves."""
    for larger, smaller in permutations(("cogging", "contact")):
        assert filling_in(taken((larger, 0, 20.0), (smaller, 0, 9.0), left=1.1), SCALES) == [False, False]
        assert filling_in(taken((larger, 0, 20.0), (smaller, 0, 9.0), left=1.5), SCALES) == [False, True]
    assert filling_in(taken(("cable_spring", 0, 20.0), ("contact", 0, 9.0), left=1.1), SCALES) == [False, True]


def test_a_wall_before_the_tip_and_a_spring_at_one_joint_are_two_where_nothing_is_left() -> None:
    """The wall is felt at all joints, by where they all are; on one joint the two are curves over the same angle."""
    wall, spring = (Placed(effect_named(*law), 0, {}) for law in (("contact", "plane"), ("cable_spring",)))
    for left, fills in ((1.1, False), (2.5, True)):
        steps = taken_steps([wall, spring], [20.0, 9.0], gap=FLOOR, floor=FLOOR, left=left)
        assert filling_in(steps, SCALES) == [False, fills]
        assert filling_in(steps, SCALES[:1]) == [False, True]
    steps = taken_steps([wall, spring], [20.0, 9.0], gap=FLOOR, floor=FLOOR, left=1.1)
    power = steps[1].worth.power.copy() if steps[1].worth else steps[1].ranking.power.copy()
    power[:, 1] = 30.0  # where only the wall is felt, its law leaves much: so the spring may be the rest of it
    shown = replace(steps[1].worth or steps[1].ranking, power=power)
    elsewhere = replace(steps[1], worth=shown) if steps[1].worth else replace(steps[1], ranking=shown)
    assert filling_in([steps[0], elsewhere], SCALES) == [False, True]
    ripple = Placed(effect_named("cogging"), 0, {"harmonic": 0.5})
    assert filling_in(taken_steps([wall, ripple], [20.0, 9.0], gap=FLOOR, floor=FLOOR, left=1.5), SCALES) == [
        False,
        True,
    ]


def test_many_periods_are_no_kin_of_a_spring() -> None:
    """Of a line over its range, beside a constant, a wave of BENDS periods takes less than a tenth at any phase."""
    both = ("cogging", 0, 20.0), ("cable_spring", 0, 9.0)
    for travel, fills in ((1.0, True), (2.0 * np.pi * BENDS / 6.0 * 1.01, False)):
        assert filling_in(taken(*both), (replace(SCALES[0], travel=travel),) * 2) == [False, fills]
    q = np.linspace(-1.0, 1.0, 2000)
    wave = np.stack([np.sin(np.pi * BENDS * q), np.cos(np.pi * BENDS * q)], axis=1)
    wave -= wave.mean(axis=0)
    left = q - wave @ np.linalg.lstsq(wave, q, rcond=None)[0]
    assert 1.0 - left @ left / (q @ q) < 0.1


@pytest.mark.parametrize("lobes", [2.0, 3.0, 4.0, 6.0, 8.0])
@pytest.mark.parametrize("exponent", [1.0, 1.5])
def test_no_edge_bends_like_a_wave(lobes: float, exponent: float) -> None:
    """Over two radians, beside what is re-tuned anyway: a constant, a line, and gravity."""
    q = np.linspace(-1.0, 1.0, 400)
    retuned = np.linalg.qr(np.stack([np.ones_like(q), q, np.sin(q), np.cos(q)], axis=1))[0]
    edges = np.maximum(q - np.linspace(-0.95, 0.95, 60)[:, None], 0.0) ** exponent
    for phase in np.linspace(0.0, np.pi, 12, endpoint=False):
        wave, *bent = (y - retuned @ (retuned.T @ y) for y in (np.sin(lobes * q + phase), *edges, *edges[:, ::-1]))
        left = [1.0 - (edge @ wave) ** 2 / ((edge @ edge + 1e-9) * (wave @ wave)) for edge in bent]
        assert min(left) > EDGED


@pytest.mark.parametrize(("larger", "smaller"), [("actuator_lag", "delay"), ("cable_spring", "cogging")])
def test_two_of_a_kind_that_make_up_any_third_fill_in_wherever_they_end(larger: str, smaller: str) -> None:
    assert filling_in(taken((larger, 0, 20.0), (smaller, 0, 9.0), left=1.0), SCALES) == [False, True]


def test_what_is_kin_to_what_was_retuned_fills_in() -> None:
    steps = taken(("time_shift", 0, 9.0), ("contact", 0, 4.0), ("time_shift", 1, 9.0))
    steps[0] = with_effects(steps[0], [Placed(effect_named("delay"), 0, {"time": 0.001})])
    assert filling_in(steps, SCALES) == [True, False, False]
    slight = {"sine": 0.001, "cosine": 0.001, "harmonic": 3.0}
    waves = taken(("torque_ripple", 0, 9.0))
    waves[0] = with_effects(waves[0], [Placed(effect_named("cogging"), 0, slight)])
    assert filling_in(waves, SCALES) == [False]
    steps[0] = with_effects(steps[0], [Placed(effect_named("delay"), 0, {"time": 0.01})])  # the arm file's own
    assert filling_in(steps, SCALES) == [False, False, False]


def test_it_keeps_half_of_its_presence_and_no_name() -> None:
    alone, _ = causes_of(taken(("delay", 0, 4.0)), ("A", "B"), SCALES)
    causes, left = causes_of(taken(("actuator_lag", 0, 9.0), ("delay", 0, 4.0)), ("A", "B"), SCALES)
    presences = {cause.effect: cause.presence or 0.0 for cause in causes}
    assert presences["actuator_lag"] > NAMED_OVER > presences["delay"]
    assert presences["delay"] == pytest.approx(0.5 * (alone[0].presence or 0.0), rel=0.01)
    assert left + sum(cause.probability for cause in causes) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("law", "as_good", "named"),
    [
        ("linear", "torque_offset", True),
        ("linear", "gravity_tilt", False),  # as many parameters
        ("hardening", "gravity_tilt", True),
        ("hardening", "contact/linear", False),  # fewer, but the stop's kin too
    ],
)
def test_what_a_simpler_law_of_another_kind_does_as_well_does_not_fill_in(law: str, as_good: str, named: bool) -> None:
    """A spring that pulls alike everywhere is an offset beside a stop, whichever of them the search took."""
    stop = Placed(effect_named("contact", "linear"), 0, {"stiffness": 5.0, "position": 0.5})
    spring = Placed(effect_named("cable_spring", law), 0, {"stiffness": 5.0, "rest": -9.0, "cubic": 9.0})
    other = effect_named(*as_good.split("/"))
    steps = taken_steps([stop, spring], [9.0, 5.0], gap=FLOOR, floor=FLOOR, left=4.0)
    steps[1] = replace(steps[1], as_good=(fitted([Placed(other, 0)], FLOOR),))
    causes, _ = causes_of(steps, ("A", "B"), SCALES)
    (found,) = (cause for cause in causes if cause.effect == "cable_spring")
    assert other.name in found.equivalent
    assert ((found.presence or 0.0) > NAMED_OVER) == named


@pytest.mark.parametrize("effect", ["delay", "actuator_lag", "time_shift"])
def test_what_every_drive_has_some_of_is_not_named(effect: str) -> None:
    (small,), _ = causes_of(taken((effect, 0, 9.0), late=0.0005), ("A", "B"), SCALES)
    (large,), _ = causes_of(taken((effect, 0, 9.0), late=0.005), ("A", "B"), SCALES)
    assert (small.presence or 0.0) < 0.2 < NAMED_OVER < (large.presence or 0.0)


def test_a_joint_with_no_more_than_every_drive_has_is_not_listed() -> None:
    steps = [*taken(("delay", 0, 9.0)), *taken(("delay", 1, 9.0), late=0.0005)]
    (cause,), _ = causes_of(steps, ("A", "B"), SCALES)
    assert cause.joints == ("A",)


def test_nothing_is_alone_of_its_kind() -> None:
    words = [word for effect in laws().values() for word in effect.kin]
    names = {word: {effect.name for effect in laws().values() if word in effect.kin} for word in words}
    assert all(len(families) > 1 for families in names.values())
