"""An axis that slides: what can be hidden in it."""

import numpy as np
import pytest

from stribeck.errors import StribeckError
from stribeck.withheld import Injection
from stribeck.withheld.injections import assemble
from stribeck.withheld.own import possible
from stribeck.withheld.plant import Diverged, Drive, simulate


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
