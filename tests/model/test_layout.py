"""The parameter vector: order, priors and bounds come from the arm file's tolerances and the effects."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import Arm, Friction, Joint, Tolerance
from stribeck.effects.registry import registry
from stribeck.errors import StribeckError
from stribeck.model.layout import Placed, layout, values_of
from stribeck.model.path import SignalPath
from stribeck.model.values import Parameter

EVEN = Friction(2.0, 0.5, 0.7, 0.05)
A = Joint("A", "revolute", 0.3, 2.0, (0.15, -0.02), 0.03, 0.05, EVEN, EVEN)
ARM = Arm("layout", (9.81, 0.0), (A, replace(A, name="B", mass=1.0)), tolerance=Tolerance(0.05, 0.3))


def test_order_and_values() -> None:
    entries = layout(ARM, [])
    keys = [entry.key for entry in entries]
    constants = ["C0", "C1", "C2", "alpha"]
    one = ["mass", "com_x", "com_y", "inertia", "rotor_inertia", *[f"friction.{c}" for c in constants]]
    assert keys == [f"{joint}.{key}" for joint in "AB" for key in one]
    values = dict(zip(keys, values_of(entries), strict=True))
    assert values["A.mass"] == 2.0
    assert values["B.mass"] == 1.0
    assert values["A.com_y"] == -0.02
    assert values["B.friction.alpha"] == 0.05


def test_priors_are_the_tolerances() -> None:
    entries = {entry.key: entry for entry in layout(ARM, [])}
    assert entries["A.com_y"].sd == pytest.approx(0.05 * 0.02)
    assert entries["A.friction.C1"].sd == pytest.approx(0.3 * 0.5)
    assert entries["A.mass"].lower > 0.0
    assert entries["A.friction.C0"].lower == 0.0
    assert entries["A.com_x"].lower == -math.inf


@pytest.mark.parametrize(
    ("gravity", "com", "stated", "sd"),
    [
        ((9.81, 0.0), (0.15, 0.0), {}, 0.003),  # a hundredth of the link
        ((9.81, 0.0), (0.02, 0.0), {}, 0.001),  # no more than the centre of mass is known along it
        ((9.81, 0.0), (0.15, 0.0), {"com_y": 0.0}, 0.0),  # held
        ((0.0, 0.0), (0.15, 0.0), {}, 0.0),  # no weight, and nothing before it
    ],
)
def test_a_centre_of_mass_on_the_line_of_its_link_may_lie_beside_it(
    gravity: tuple[float, float], com: tuple[float, float], stated: dict[str, float], sd: float
) -> None:
    """A part of zero would be zero; of the last link it is an encoder offset's place."""
    arm = replace(ARM, gravity=gravity, joints=tuple(replace(j, com=com, tolerance=stated) for j in ARM.joints))
    entries = {entry.key: entry for entry in layout(arm, [])}
    assert entries["A.com_y"].sd == pytest.approx(sd)
    assert entries["B.com_y"].sd == 0.0
    three = replace(arm, joints=(*arm.joints, replace(A, name="C")))
    middle = {entry.key: entry for entry in layout(three, [])}["B.com_y"]
    assert middle.sd == pytest.approx(0.003 if sd == 0.0 and not stated else sd)


def test_what_must_be_above_zero_may_be_as_small_as_it_is() -> None:
    """An axis that creeps by micrometres has an alpha below any bound that would do for an arm."""
    friction = replace(A.friction, alpha=1e-8)
    arm = replace(ARM, joints=(replace(A, mass=1e-7, friction=friction, backward=friction),))
    entries = {entry.key: entry for entry in layout(arm, ())}
    for key in ("A.mass", "A.friction.alpha"):
        assert 0.0 < entries[key].lower < 0.1 * entries[key].value


def test_asymmetric_joint_has_constants_for_both_directions() -> None:
    back = replace(EVEN, C0=1.0)
    arm = replace(ARM, joints=(replace(A, backward=back), ARM.joints[1]))
    keys = [entry.key for entry in layout(arm, [])]
    assert "A.backward.C0" in keys
    assert "B.backward.C0" not in keys
    path = SignalPath(arm)
    assert path.constants(0, -1.0)["C0"].name() == path.parameter("A.backward.C0").name()
    assert path.constants(1, -1.0)["C0"].name() == path.parameter("B.friction.C0").name()


def test_decay_without_a_bend_is_held() -> None:
    flat = replace(EVEN, C1=0.0)
    arm = replace(ARM, joints=(replace(A, friction=flat, backward=flat), ARM.joints[1]))
    held = [entry.key for entry in layout(arm, []) if entry.sd == 0.0]
    assert held == ["A.friction.C1", "A.friction.alpha"]


def test_effect_parameters_follow_with_their_own_bounds() -> None:
    effect = registry()["presliding"]
    entries = layout(ARM, [Placed(effect, 1, {"stiffness": 900.0})])[-2:]
    assert [entry.key for entry in entries] == ["presliding[B].stiffness", "presliding[B].damping"]
    assert [entry.value for entry in entries] == [900.0, 0.0]  # one that is not given takes its null value
    assert [entry.owner for entry in entries] == [0, 0]
    assert all(np.isinf(entry.sd) for entry in entries)
    assert entries[0].log


def test_two_bristles_at_one_joint_are_refused() -> None:
    """The friction of a joint is what its bristle carries: a second one would go unheard."""
    presliding = registry()["presliding"]

    class Other(type(presliding)):  # type: ignore[misc]
        name = "users_bristle"

    with pytest.raises(StribeckError, match=r"users_bristle beside presliding.*\(bristle\)"):
        SignalPath(ARM, [Placed(presliding, 1), Placed(Other(), 1)])
    assert SignalPath(ARM, [Placed(presliding, 0), Placed(Other(), 1)]).state_names == ("0.torque", "1.torque")


def test_two_compliances_at_one_joint_are_refused() -> None:
    effects = registry()
    both = [Placed(effects["backlash"], 0), Placed(effects["joint_flexibility"], 0)]
    with pytest.raises(StribeckError, match=r"joint_flexibility beside backlash.*\(transmission\)"):
        SignalPath(ARM, both)
    path = SignalPath(ARM, [both[0], Placed(effects["joint_flexibility"], 1)])
    assert path.flexible == (0, 1)
    assert path.state_names[:4] == ("link[0].position", "link[0].velocity", "link[1].position", "link[1].velocity")


def test_a_straight_axis_has_its_own_units() -> None:
    axis = replace(ARM, joints=(replace(A, kind="prismatic"),))
    spring, slots = registry()["cable_spring"], registry()["cogging"]
    units = {entry.name: entry.unit for entry in layout(axis, [Placed(spring, 0), Placed(slots, 0)])}
    assert [units[name] for name in ("C0", "C2", "alpha", "rotor_inertia")] == ["N", "N s/m", "m/s", "kg"]
    assert [units[name] for name in ("stiffness", "rest", "sine", "harmonic")] == ["N/m", "m", "N", "1/m"]
    assert {entry.name: entry.unit for entry in layout(ARM, [Placed(spring, 0)])}["stiffness"] == "N m/rad"


def test_places_are_bounded_about_the_middle_of_a_motion() -> None:
    """All else is as it is, and what an arm file states beyond is free, to be corrected either way."""
    spring = registry()["cable_spring"]

    def bounds(values: dict[str, float], middles: Sequence[float] | None) -> list[tuple[float, float]]:
        entries = layout(ARM, [Placed(spring, 1, values)], middles)[-len(spring.parameters) :]
        return [(entry.lower, entry.upper) for entry in entries]

    (stiffness, rest) = bounds({}, [0.0, 50.0])
    assert stiffness == bounds({}, None)[0]
    assert rest == pytest.approx((50.0 - spring.parameters[1].reach, 50.0 + spring.parameters[1].reach))
    assert bounds({"rest": 49.0}, [0.0, 50.0])[1] == rest
    for stated in ({"rest": 9.0}, {"stiffness": 5.0}):  # at 0, where the file leaves it out
        assert bounds(stated, [0.0, 50.0])[1] == (-math.inf, math.inf)
    assert Parameter("rest", "rad", "", 0.0, -3.0, 3.0, reach=2.0).bounds(6.3) == (1.0, 3.0)
    assert bounds({}, None)[1] == (-math.inf, math.inf)
