"""The bars before an effect is taken: each of them alone keeps one out."""

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stribeck.effects.registry import effect_named
from stribeck.gap.search.gates import LEAST_GAIN, LEAST_T, MOST_LOST, earns_its_place, needed, strained
from stribeck.gap.search.random_torque import Randomness
from stribeck.model.layout import Placed
from stribeck.model.scale import Scale

SCALES = [Scale(torque=1.0, friction=0.5, speed=1.0, travel=1.0, inertia=0.1, sample_time=0.002, length=0.3)] * 2
DELAY = Placed(effect_named("delay"), 0, {"time": 0.01})


def taken(
    placed: Placed = DELAY, before: Any = (), random: Any = None, scales: Sequence[Scale] = SCALES, **changed: Any
) -> bool:
    """Return whether an effect with good figures, some of them changed, would be taken."""
    figures: dict[str, Any] = {
        "overall": 0.5, "gain": 0.4, "t": 6.0, "sure": 1.0, "lost": -0.5, "prior_gain": 0.0, "after": (1.0, 1.0),
        "power": (4.0, 1.0),
    } | changed  # fmt: skip
    ranking: Any = SimpleNamespace(
        overall=np.array([0.0, figures["overall"]]),
        gain=np.array([[0.0] * 3, [figures["gain"]] * 3]),
        t=np.array([0.0, figures["t"]]),
        sure=np.array([0.0, figures["sure"]]),
        lost=np.array([0.0, figures["lost"]]),
        prior_gain=np.array([0.0, figures["prior_gain"]]),
        power=np.array([figures["power"], figures["after"]]),
    )
    rival: Any = SimpleNamespace(placed=(*before, placed))
    return earns_its_place(ranking, 1, rival, scales, before, random)


def test_good_figures_are_taken() -> None:
    assert taken()


@pytest.mark.parametrize(
    "bad",
    [
        {"overall": 0.5 * LEAST_GAIN},
        {"overall": 0.2, "t": 0.9 * LEAST_T},  # not a large gain, which any choice of blocks may confirm
        {"t": 0.9 * LEAST_T, "sure": 0.9},
        {"gain": -0.3, "lost": 2.0 * MOST_LOST},  # held-out runs speak against it
        {"after": (3.95, 1.0)},  # next to nothing of the noise floor's power
        {"prior_gain": -10.0, "overall": 0.2},  # it is the nominal values that the law bends
    ],
)
def test_one_poor_figure_keeps_it_out(bad: dict[str, Any]) -> None:
    assert not taken(**bad)


def test_a_bound_is_a_strain_but_for_one_that_stands_for_none() -> None:
    shaft = effect_named("joint_flexibility")
    bounds = {parameter.name: (parameter.lower, parameter.upper) for parameter in shaft.parameters}
    fitted = {"stiffness": 60.0, "damping": 0.8}
    assert not strained(Placed(shaft, 0, fitted))
    assert not strained(Placed(shaft, 0, fitted | {"damping": bounds["damping"][0]}))  # no damping has no logarithm
    assert strained(Placed(shaft, 0, fitted | {"damping": bounds["damping"][1]}))
    assert strained(Placed(shaft, 0, fitted | {"stiffness": bounds["stiffness"][0]}))


@pytest.mark.parametrize("middle", [0.4, 0.4 - 40.0 * np.pi])
def test_a_place_far_from_where_the_joint_moves_is_a_strain(middle: float) -> None:
    """A spring that far away is an offset."""
    spring = effect_named("cable_spring")
    (reach,) = (parameter.reach for parameter in spring.parameters if parameter.place)
    scale = replace(SCALES[0], middle=middle)
    for away, told in ((0.0, False), (0.9 * reach, False), (reach, True), (-reach, True)):
        assert strained(Placed(spring, 0, {"stiffness": 2.0, "rest": middle + away}), scale) == told


def test_contacts_that_any_slide_renews_are_no_strain() -> None:
    """They are of some ten micrometres: less than a sample of slow motion, which no recording resolves."""
    for law in ("break_away", "ageing", "at_rest"):
        rest = effect_named("dwell_time", law)
        bounds = {parameter.name: (parameter.lower, parameter.upper) for parameter in rest.parameters}
        fitted = {"rise": 1.0, "time": 0.8, "distance": bounds["distance"][0]}
        assert not strained(Placed(rest, 0, fitted))
        assert strained(Placed(rest, 0, fitted | {"distance": bounds["distance"][1]}))


def test_held_out_runs_that_hardly_excite_it_need_not_confirm() -> None:
    assert taken(gain=-0.1, lost=0.5 * MOST_LOST)
    assert not taken(gain=-0.1, lost=0.5 * MOST_LOST, overall=0.1)


def test_a_little_of_random_torque_is_the_loop_that_answers() -> None:
    little = {"overall": 0.2, "gain": 0.2, "t": 12.0}
    left = Randomness(bandwidth=2.0, share=0.6)
    assert taken(**little)
    assert taken(random={1: left}, **little)
    assert not taken(random={0: left}, **little)
    assert taken(Placed(effect_named("quadratic_damping"), 0, {"gain": 0.1}), random={0: left}, **little)  # no filter
    assert taken(random={0: left})


def test_a_filter_closes_no_more_of_random_torque_than_motion_foretells() -> None:
    assert taken(random={0: Randomness(2.0, share=0.8)})
    assert not taken(random={0: Randomness(2.0, share=0.98)})
    assert taken(random={1: Randomness(2.0, share=0.98)})
    assert taken(Placed(effect_named("quadratic_damping"), 0, {"gain": 0.1}), random={0: Randomness(2.0, share=0.98)})


def test_further_effect_at_a_joint_must_show_more() -> None:
    before = (Placed(effect_named("torque_gain"), 0, {"gain": 1.1}),)
    elsewhere = (Placed(effect_named("torque_gain"), 1, {"gain": 1.1}),)
    assert taken(overall=0.1)
    assert taken(overall=0.1, before=elsewhere)
    assert not taken(overall=0.1, before=before)


def test_a_large_gain_that_few_blocks_show_is_one_unless_an_effect_is_there_already() -> None:
    """A play shows where it is crossed, and nowhere else; beside another law it may be what that one does not fit."""
    seldom = {"overall": 0.8, "t": 0.5 * LEAST_T, "gain": 0.05}
    here, elsewhere = ((Placed(effect_named("torque_gain"), joint, {"gain": 1.1}),) for joint in (0, 1))
    assert taken(**seldom)
    assert taken(before=elsewhere, **seldom)
    assert not taken(before=here, **seldom)
    assert taken(before=here, **seldom | {"t": 0.8 * LEAST_T})
    assert not taken(before=here, **seldom | {"t": 0.8 * LEAST_T, "overall": 0.45})
    assert not taken(sure=0.9, **seldom)


def test_a_large_gain_may_bend_the_nominal_values() -> None:
    assert taken(prior_gain=-10.0, overall=0.3)


def test_a_filter_is_not_taken_for_some_of_the_noise() -> None:
    noise = {"power": (1.1, 1.0), "after": (0.3, 0.9)}
    assert not taken(**noise)
    assert taken(Placed(effect_named("cogging"), 0, {"sine": 0.1, "cosine": 0.0, "harmonic": 6.3}), **noise)


def test_a_drive_s_effect_closes_nothing_at_a_joint_without_a_drive() -> None:
    """There the equations hold at any scale: a gain of the other drive makes everything less, and what is left."""
    free, gain = [SCALES[0], replace(SCALES[0], driven=False)], Placed(effect_named("torque_gain"), 0, {"gain": 0.6})
    here, there, spring = (1.0, 1.0), (4.0, 0.2), Placed(effect_named("cable_spring"), 0, {"stiffness": 1.0})
    assert taken(gain, scales=free, after=here)
    assert taken(gain, after=there)
    assert not taken(gain, scales=free, after=there)
    assert taken(spring, scales=free, after=there)
    assert taken(
        Placed(effect_named("cogging"), 1, {"sine": 0.1, "cosine": 0.0, "harmonic": 6.3}), scales=free, after=there
    )


def test_the_prior_may_ask_for_an_effect() -> None:
    gain = Placed(effect_named("torque_gain"), 0, {"gain": 1.2})
    assert taken(gain, overall=0.0, gain=0.0, t=0.0, prior_gain=20.0)
    assert not taken(overall=0.0, gain=0.0, t=0.0, prior_gain=20.0)  # no delay saves the prior anything


def test_a_fit_at_its_bound_is_none() -> None:
    upper = next(p.upper for p in DELAY.effect.parameters if p.name == "time")
    assert not taken(Placed(DELAY.effect, 0, {"time": upper}))


def test_needed() -> None:
    def ranking(gain: float, t: float, sure: float = 0.5, prior: float = 0.0) -> Any:
        return SimpleNamespace(overall=[0.0, gain], t=[0.0, t], sure=[0.0, sure], prior_gain=[0.0, prior])

    assert needed(ranking(0.3, 5.0))
    assert needed(ranking(0.0, 0.0, prior=20.0))
    assert not needed(ranking(0.5 * LEAST_GAIN, 5.0))
    assert not needed(ranking(0.3, 1.0))
