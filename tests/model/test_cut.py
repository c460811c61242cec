"""The path cut at the measured joint: a motion that the model makes leaves nothing, and rest is an interval."""

import math
from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import Arm, Friction, Joint
from stribeck.effects.registry import effect_named, laws, registry
from stribeck.model.cut import Cut
from stribeck.model.drive import DRIVE
from stribeck.model.effect import Effect
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath

FORWARD, BACKWARD = Friction(2.0, 0.5, 0.7, 0.05), Friction(1.5, 0.8, 0.4, 0.08)
M, R, INERTIA, ROTOR, G = 2.0, 0.2, 0.03, 0.05, 9.81


def pendulum(gravity: float = G) -> Arm:
    joint = Joint("A", "revolute", 0.3, M, (R, 0.0), INERTIA, ROTOR, FORWARD, BACKWARD)
    return Arm("pendulum", (gravity, 0.0), (joint,))


def instant(q: float, dq: float, ddq: float, u: float, sd: float = 1e-9) -> np.ndarray:
    known = {"position": q, "velocity": dq, "acceleration": ddq, "command": u, "velocity_sd": sd, "sliding": 1.0}
    return np.array([known.get(name, 0.0) for name in DRIVE])


def residual(arm: Arm, drive: np.ndarray, placed: tuple[Placed, ...] = ()) -> tuple[float, dict[str, float]]:
    path = SignalPath(arm, placed)
    r, stages = Cut(path, 0.01).balance(drive, np.zeros(0), values_of(path.entries), np.zeros(len(placed)))
    names = ("actuator", "rotor", "load", "friction")
    return float(r), dict(zip(names, stages.full().ravel(), strict=True))


def needed(q: float, dq: float, ddq: float) -> float:
    """Torque of the pendulum in closed form."""
    f = FORWARD if dq > 0 else BACKWARD
    dry = math.copysign(f.C0 + f.C1 * math.exp(-abs(dq) / f.alpha), dq)
    return (INERTIA + M * R**2 + ROTOR) * ddq + M * G * R * math.sin(q) + dry + f.C2 * dq


@pytest.mark.parametrize("dq", [0.9, 0.03, -0.03, -0.9])
def test_its_own_motion_leaves_no_residual(dq: float) -> None:
    r, stages = residual(pendulum(), instant(0.7, dq, -3.0, needed(0.7, dq, -3.0)))
    assert r == pytest.approx(0.0, abs=1e-12)
    assert stages["load"] == pytest.approx((INERTIA + M * R**2) * -3.0 + M * G * R * math.sin(0.7))
    assert stages["rotor"] == pytest.approx(-3.0 * ROTOR)


@pytest.mark.parametrize("extra", [0.4, -0.6])
def test_residual_is_measured_less_needed(extra: float) -> None:
    assert residual(pendulum(), instant(0.7, 0.5, 1.0, needed(0.7, 0.5, 1.0) + extra))[0] == pytest.approx(extra)


def test_stages_add_up() -> None:
    r, s = residual(pendulum(), instant(0.2, -0.4, 2.0, 3.0))
    assert s["actuator"] - s["rotor"] - s["load"] - s["friction"] == pytest.approx(r)


@pytest.mark.parametrize("u", [2.4, 0.3, -2.2])
def test_rest_within_the_break_away_interval_leaves_no_residual(u: float) -> None:
    r, stages = residual(pendulum(0.0), instant(0.3, 0.0, 0.0, u))
    assert r == pytest.approx(0.0, abs=1e-9)
    assert stages["friction"] == pytest.approx(u)


@pytest.mark.parametrize(("u", "left"), [(4.0, 4.0 - 2.5), (-4.0, -4.0 + 2.3)])
def test_rest_beyond_break_away_leaves_the_excess(u: float, left: float) -> None:
    """Friction at rest is at most C0 + C1 of its direction (eq. 9), here 2.5 and 2.3 N m."""
    sd = 1e-3  # erf(2.5 / sqrt 2) leaves 1.2 % of the sign unsure
    assert residual(pendulum(0.0), instant(0.3, 0.0, 0.0, u, sd))[0] == pytest.approx(left, abs=0.05)


def test_sign_is_unsure_within_the_noise_of_velocity() -> None:
    """One standard deviation from rest any friction goes; at eight the sliding law is sure."""
    for dq, share in ((1e-3, 0.0), (8e-3, 1.0)):
        r = residual(pendulum(0.0), instant(0.0, dq, 0.0, 0.0, 1e-3))[0]
        level = 2.0 + 0.5 * math.exp(-dq / 0.05)
        assert r == pytest.approx(-share * level - 0.7 * dq * (share == 1.0), abs=0.2)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_what_breaks_away_is_no_less_for_a_speed_that_is_noise(way: float) -> None:
    """A speed of the whole Stribeck velocity where the joint surely rests: it may do so under C0 + C1."""
    speed, (level, viscous) = FORWARD.alpha, ((2.5, 0.7) if way > 0 else (2.3, 0.4))
    for extra, resting, left in ((-0.01, 1.0, 0.0), (0.3, 1.0, 0.3), (-0.01, 0.0, 0.3)):
        drive = instant(0.0, way * speed, 0.0, way * (level + viscous * speed + extra), sd=speed)
        drive[DRIVE.index("resting")] = resting
        assert residual(pendulum(0.0), drive)[0] * way == pytest.approx(left, abs=0.1)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_no_flutter_takes_a_joint_at_rest_beyond_its_level(way: float) -> None:
    """Near it, noise would do so on one side only; what sliding leaves does not depend on what is flutter."""
    inertia = INERTIA + M * R**2 + ROTOR
    for dq, near, left in ((0.0, -0.3, 0.0), (0.0, 0.2, 0.2), (0.5, 0.2, None)):
        for flutter in (-4.0, 0.0, 4.0):
            level = FORWARD.C0 + FORWARD.C1 if way > 0 else BACKWARD.C0 + BACKWARD.C1
            drive = instant(0.0, dq, way * (flutter - 1.0), way * (level + near - inertia), sd=1e-3)
            plain = residual(pendulum(0.0), drive)[0]
            drive[DRIVE.index("flutter")] = way * flutter
            assert residual(pendulum(0.0), drive)[0] * way == pytest.approx(
                plain * way if left is None else left, abs=1e-9
            )


def test_residual_is_in_units_of_the_command() -> None:
    """With a gain g the drive gives g u: what is left is divided by g, so that no gain makes it small."""
    place = Placed(registry()["torque_gain"], 0, {"gain": 0.5})
    u = 7.0
    plain = residual(pendulum(), instant(0.2, 0.4, 2.0, 0.0))[0]
    assert residual(pendulum(), instant(0.2, 0.4, 2.0, u), (place,))[0] == pytest.approx((0.5 * u + plain) / 0.5)


@pytest.mark.parametrize("velocity", [0.4, -0.4])
@pytest.mark.parametrize("ratio", [0.0, 0.3, 0.6])
@pytest.mark.parametrize("law", ["motor", "net"])
def test_friction_that_goes_with_the_command_makes_none_of_its_noise_small(
    velocity: float, ratio: float, law: str
) -> None:
    """Driving, it takes a share of all that the command has more: noise would seem to be explained by it."""
    place = Placed(effect_named("load_dependent_friction", law), 0, {"ratio": ratio})
    quiet, noisy = (residual(pendulum(), instant(0.2, velocity, 2.0, u), (place,))[0] for u in (9.0, 9.25))
    assert noisy - quiet == pytest.approx(0.25)


def test_where_the_command_is_lost_no_gain_makes_a_residual_small() -> None:
    """Else a low limit, or a wide dead zone, and a large gain of what is left would make any of them small."""
    drive, gain = instant(0.2, 0.4, 2.0, 9.0), 2.5
    limit = Placed(registry()["torque_saturation"], 0, {"limit": 5.0})
    plain = residual(pendulum(), drive, (limit,))[0]
    low = Placed(registry()["torque_saturation"], 0, {"limit": 5.0 / gain})
    after = Placed(registry()["torque_gain"], 0, {"gain": gain})
    assert abs(plain) > 0.5
    assert residual(pendulum(), drive, (low, after))[0] == pytest.approx(plain)
    wide = Placed(registry()["torque_dead_zone"], 0, {"width": 9.0 - 5.0 / gain})
    assert residual(pendulum(), drive, (wide, after))[0] == pytest.approx(plain)


@pytest.mark.parametrize("gain", [0.5, 0.9, 1.0, 1.2, 2.0])
@pytest.mark.parametrize("idle", [("torque_saturation", {"limit": 1e6}), ("torque_dead_zone", {"width": 0.0})])
def test_what_loses_nothing_closes_nothing_beside_a_gain(gain: float, idle: tuple[str, dict[str, float]]) -> None:
    drive, weaker = instant(0.2, 0.4, 2.0, 9.0), Placed(registry()["torque_gain"], 0, {"gain": gain})
    nothing = Placed(registry()[idle[0]], 0, idle[1])
    alone = residual(pendulum(), drive, (weaker,))[0]
    for both in ((weaker, nothing), (nothing, weaker)):
        beside = residual(pendulum(), drive, both)[0]
        assert beside == pytest.approx(alone * max(gain, 1.0))


@pytest.mark.parametrize("recorded", [-2.0, 0.3, 9.0])
def test_true_position_undoes_the_sensor(recorded: float) -> None:
    import casadi as ca

    place = Placed(registry()["encoder_eccentricity"], 0, {"sine": 0.03, "cosine": -0.02})
    path = SignalPath(pendulum(), (place,))
    q = ca.SX.sym("q")
    there = ca.Function("there", [q, path.p], [path.true_position(0, q)])
    back = ca.Function("back", [q, path.p], [path.measured(0, q)])
    p = values_of(path.entries)
    true = float(there(recorded, p))
    assert abs(true - recorded) > 1e-3
    assert float(back(true, p)) == pytest.approx(recorded, abs=1e-7)


@pytest.mark.parametrize("law", laws().values(), ids=["-".join(filter(None, law)) for law in laws()])
@pytest.mark.parametrize("observe", [True, False])
def test_states_are_followed_by_all_that_they_depend_on(law: Effect, observe: bool) -> None:
    """Beside a shaft: no derivative is left out, and none is carried along that is always zero."""
    first = replace(pendulum().joints[0], name="B")
    arm = Arm("double", (G, 0.0), (*pendulum().joints, first))
    shaft = Placed(effect_named("joint_flexibility"), 1)
    path = SignalPath(arm, [shaft, Placed(law, 0)])
    cut = Cut(path, 0.002, observe=observe)
    moves, begins = (f.jac_sparsity(0, where) for f, where in ((cut.follow, 3), (cut.begin, 1)))
    held = {int(c) for s in (moves, begins) for r, c in zip(*s.get_triplet(), strict=True) if r < cut.nx}
    assert set(cut.active) == held & set(cut.columns)
