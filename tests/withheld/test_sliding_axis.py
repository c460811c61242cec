"""An axis that slides: what can be hidden in it, and what is a mass or a length there."""

import math

import numpy as np
import pytest

from stribeck.arm import Friction
from stribeck.errors import StribeckError
from stribeck.withheld import Injection
from stribeck.withheld.injections import assemble
from stribeck.withheld.motions import Motion, multisine
from stribeck.withheld.own import possible
from stribeck.withheld.plant import Diverged, Drive, simulate
from stribeck.withheld.scales import SCALES
from stribeck.withheld.stage import stage_of

KINDS = {"revolute": 0.01 + 1.0 * 0.25**2, "prismatic": 1.0}  # what moves: an inertia, or the mass


def axis(bench, **changes):
    return bench.one_link(kind="prismatic", **changes)


@pytest.mark.parametrize(
    ("effect", "params"),
    [
        ("base_flexibility", {"stiffness": 1e9}),
        ("base_flexibility", {"stiffness": 1e9, "direction": 0.0}),
        ("contact", {"stiffness": 1e3, "direction": 0.0}),
        ("sloshing_mass", {"mass": 0.1}),
    ],
)
def test_what_turns_or_swings_has_no_place_on_an_axis_that_slides(bench, effect, params):
    with pytest.raises(StribeckError, match=f"{effect} needs an arm that turns: found an axis that slides"):
        assemble(axis(bench), [Injection(effect, "A", params)])


def test_what_has_no_place_is_not_tried(bench):
    turning, sliding = possible(bench.one_link()), possible(axis(bench))
    assert set(turning) - set(sliding) == {"base_flexibility"}
    assert "negative_damping" in sliding


def test_the_plant_itself_takes_no_second_body_on_an_axis_that_slides(bench):
    plant = assemble(axis(bench), []).plant.with_world(base_stiffness=1e9, base_inertia=1.0)
    still, ones = np.zeros((20, 1)), np.ones((21, 1))
    drive = Drive(1e-3, np.zeros((20, 1, 2)), still, still, 0.0 * ones, ones, np.zeros((1, 2)), np.zeros(1))
    with pytest.raises(Diverged, match="the mass matrix is not positive"):
        simulate(plant, drive)


@pytest.mark.parametrize(("kind", "link"), KINDS.items())
def test_a_shaft_rings_down_at_three_per_cent_of_critical(bench, kind, link):
    """Peaks a period apart shrink by exp(-2 pi ratio / sqrt(1 - ratio^2)); ends are mixed by their inertias."""
    hidden, rotor = (Injection("joint_flexibility", "A", {"stiffness": 300.0}),), 0.02
    arm = bench.one_link(kind=kind)
    _, trace = bench.open_loop(arm, lambda t: np.where(t < 2e-3, 5.0, 0.0)[:, None], 0.5, hidden, rate=4000.0)
    twist = (trace.motor - trace.link)[:, 0]
    peak = np.flatnonzero((twist[1:-1] > twist[:-2]) & (twist[1:-1] >= twist[2:])) + 1
    shrinks = np.mean(np.diff(np.log(twist[peak[:6]])))
    assert -shrinks / (2.0 * math.pi) == pytest.approx(0.03, rel=0.02)
    reduced = rotor * link / (rotor + link)
    assert np.mean(np.diff(peak[:6])) / 4000.0 == pytest.approx(2.0 * math.pi * math.sqrt(reduced / 300.0), rel=0.01)


@pytest.mark.parametrize(("kind", "link"), KINDS.items())
def test_flanks_of_a_play_are_damped_by_a_fifth_of_critical(bench, kind, link):
    plant = assemble(bench.one_link(kind=kind), [Injection("backlash", "A", {"gap": 1e-3})]).plant
    reduced = 0.02 * link / (0.02 + link)
    assert plant.get(0, "damping") == pytest.approx(0.4 * math.sqrt(plant.get(0, "stiffness") * reduced))


LENGTHS = {  # power of the unit of length in a parameter's unit; 0 for those that are not listed
    **dict.fromkeys(("C0", "C1", "amount", "rise", "offset", "limit", "amplitude", "torque", "load"), 1),
    **dict.fromkeys(("velocity", "speed", "distance", "gap", "resolution", "rest", "position", "centre", "width"), 1),
    **dict.fromkeys(("harmonic", "coefficient", "fade"), -1),
    **dict.fromkeys(("power", "work"), 2),
    "cubic": -2,
}
ELSEWHERE = {"gravity_tilt", "base_flexibility", "tendon_coupling", "sloshing_mass"}


def drawn(bench, name, length):
    """The parameters of an effect in an axis whose unit of length is 1 / `length` m, over the length of its motions."""
    rough = Friction(8.0 * length, 3.0 * length, 20.0, 0.02 * length)
    way = multisine(np.array([0.05 * length]), np.array([0.5]), np.array([0.0]), 0.0, 3.0)
    motion = Motion("a", 3.0, (way,))
    return SCALES[name].build(stage_of(axis(bench, friction=rough), 0, [motion], np.random.default_rng(1)))(0.01)


@pytest.mark.parametrize("name", sorted(set(SCALES) - ELSEWHERE))
def test_sizes_on_an_axis_that_slides_hold_in_any_unit_of_length(bench, name):
    metres, centimetres = drawn(bench, name, 1.0), drawn(bench, name, 100.0)
    powers = LENGTHS | ({"stiffness": 1.0 - metres["exponent"], "damping": -1} if name == "contact" else {})
    assert centimetres == pytest.approx({key: value * 100.0 ** powers.get(key, 0) for key, value in metres.items()})


@pytest.mark.parametrize("name", ["backlash", "encoder_quantisation", "encoder_eccentricity", "encoder_offset"])
def test_half_the_way_stands_for_a_radian(bench, name):
    params = drawn(bench, name, 1.0)
    size = next(abs(params[key]) for key in ("gap", "resolution", "amplitude", "offset") if key in params)
    assert size == pytest.approx(0.01 * 0.042, rel=0.01)
