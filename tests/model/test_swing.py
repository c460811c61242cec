"""The states one sample later: a link behind a stiff compliance, on a motion that is sampled slowly."""

import math

import casadi as ca
import numpy as np
import pytest
from scipy.optimize import brentq

from stribeck.arm import Arm, Friction, Joint
from stribeck.effects.registry import effect_named, registry
from stribeck.model.balance import Balance
from stribeck.model.cut import Cut
from stribeck.model.drive import DRIVE
from stribeck.model.forward import Forward
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath
from stribeck.model.swing import NEWTON, _newton

INERTIA, STEP, HERTZ = 0.2, 0.008, 3.0  # kg m^2, s, of the motor's motion
NONE = Friction(0.0, 0.0, 0.0, 0.05)


def arm(inertia: float) -> Arm:
    return Arm("link", (0.0, 0.0), (Joint("A", "revolute", 0.3, 1e-6, (0.0, 0.0), inertia, 0.01, NONE, NONE),))


def drives(count: int, step: float = STEP) -> np.ndarray:
    """Return the drive (signals, count) of a sine of 1 rad."""
    w, t = 2.0 * math.pi * HERTZ, np.arange(count) * step
    known = {
        "time": t, "position": np.sin(w * t), "velocity": w * np.cos(w * t), "acceleration": -(w**2) * np.sin(w * t),
        "velocity_sd": np.full(count, 1e-9),
    }  # fmt: skip
    return np.array([known.get(name, np.zeros(count)) for name in DRIVE])


def loads(name: str, values: dict[str, float], count: int, inertia: float = INERTIA) -> np.ndarray:
    """Return the torque (count,) that is handed to the link, N m."""
    return followed(SignalPath(arm(inertia), (Placed(registry()[name], 0, values),)), drives(count), STEP)[0]


def followed(path: SignalPath, drive: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the load (count,) of the first joint, N m, and its link's position (count,), rad."""
    cut, p, n, count = Cut(path, step, (), observe=False), values_of(path.entries), path.n, drive.shape[1]
    late = np.zeros((len(path.placed), count))
    start = cut.begin(drive[:, 0], p, late[:, 0])
    values = np.repeat(p[:, None], count, axis=1)
    rest = cut.follow.mapaccum(count - 1)(start, drive[:, :-1], drive[:, 1:], values[:, 1:], late[:, 1:])
    states = np.hstack([np.array(start), np.array(rest)])
    stages = np.array(cut.balance.map(count)(drive, cut.settled(states), values, late)[1])
    return stages[2 * n], states[0]


@pytest.mark.parametrize("turned", [0.3, 1.0, 2.0])  # rad of the link's natural frequency from sample to sample
def test_a_stiff_link_takes_its_inertial_torque(turned: float) -> None:
    """T / theta = J s^2 (k + d s) / (J s^2 + d s + k), whatever the samples of a slow motion are to the stiffness."""
    w0, s = turned / STEP, 2.0j * math.pi * HERTZ
    k, d = INERTIA * w0**2, 0.6 * INERTIA * w0
    found = loads("joint_flexibility", {"stiffness": k, "damping": d}, 150)
    law = INERTIA * s**2 * (k + d * s) / (INERTIA * s**2 + d * s + k)
    expected = np.imag(law * np.exp(s * np.arange(150) * STEP))
    late = slice(100, None)  # the start's transient has died
    assert np.max(np.abs(found - expected)[late]) < 0.01 * abs(law)


def test_a_base_is_a_compliant_joint_whose_inertias_are_divided_otherwise() -> None:
    """With J of the link and J_b of the base: J_b J / (J_b + J) of it rigid, the rest behind a spring of its own."""
    k, d, base, count = 300.0, 2.0, 0.05, 150
    share = INERTIA / (base + INERTIA)
    rocking = loads("base_flexibility", {"stiffness": k, "damping": d, "inertia": base}, count)
    joint = {"stiffness": k * share**2, "damping": d * share**2}
    rigid = base * share * drives(count)[DRIVE.index("acceleration")]
    late = slice(100, None)
    found = (loads("joint_flexibility", joint, count, INERTIA * share) + rigid)[late]
    assert found == pytest.approx(rocking[late], abs=0.01 * float(np.max(np.abs(rocking))))


def test_at_one_joint_a_base_is_a_mass_that_swings_on_the_link() -> None:
    """With J_a of the link's J on the spring: J (J - J_a) / J_a rocks, on a spring and damper (J / J_a)^2 as stiff."""
    swings, k, d, count, s = 0.2 * INERTIA, 60.0, 0.4, 150, 2.0j * math.pi * HERTZ
    more = (INERTIA / swings) ** 2
    base = {"stiffness": k * more, "damping": d * more, "inertia": INERTIA * (INERTIA / swings - 1.0)}
    law = s**2 * (INERTIA - swings + swings * (k + d * s) / (swings * s**2 + d * s + k))
    expected = np.imag(law * np.exp(s * np.arange(count) * STEP))[100:]
    assert loads("base_flexibility", base, count)[100:] == pytest.approx(expected, abs=0.01 * abs(law))
    assert abs(law - INERTIA * s**2) > 0.05 * abs(law)


def test_a_play_hands_on_nothing_across_the_whole_on_its_faces_and_no_less_in_all() -> None:
    """Faces far stiffer than the samples resolve: the link does not bounce, and what it misses a blow makes up for."""
    k, gap = INERTIA * (2.0 * math.pi * 400.0) ** 2, 0.02
    found = loads("backlash", {"gap": gap, "stiffness": k, "damping": 1e-6}, 300)[100:]
    rigid = INERTIA * drives(300)[DRIVE.index("acceleration")][100:]
    free, driven = np.abs(found) < 0.2, np.isclose(found, rigid, rtol=0.003, atol=0.1)
    assert np.mean(driven) > 0.7
    assert 0.05 < np.mean(free & ~driven) < 0.2
    assert np.sum(found) == pytest.approx(np.sum(rigid), abs=0.1)  # a blow is some 80 N m in one sample


def test_a_play_of_no_width_is_rigid() -> None:
    k = INERTIA * (2.0 * math.pi * 400.0) ** 2
    found = loads("backlash", {"gap": 0.0, "stiffness": k, "damping": 1e-6}, 150)
    rigid = INERTIA * drives(150)[DRIVE.index("acceleration")]
    assert found[50:] == pytest.approx(rigid[50:], abs=0.02 * float(np.max(np.abs(rigid))))


def test_a_damped_face_gives_way_no_more_than_one_that_is_not() -> None:
    """However strong the damper, whose force ends where the face does: the link does not pass through."""
    drive, gap, k = drives(250), 0.02, INERTIA * (2.0 * math.pi * 400.0) ** 2
    deepest = []
    for damping in (1e-6, 100.0, 500.0, 5000.0):
        play = Placed(registry()["backlash"], 0, {"gap": gap, "stiffness": k, "damping": damping})
        _, link = followed(SignalPath(arm(INERTIA), (play,)), drive, STEP)
        deepest.append(float(np.max(np.abs(drive[1] - link)[100:])) - gap / 2)
    assert 0.0 < deepest[0] < 0.0002
    assert max(deepest) < deepest[0] + 0.0005


def two(*placed: Placed) -> SignalPath:
    joints = (Joint(name, "revolute", 0.3, 1e-6, (0.0, 0.0), INERTIA, 0.01, NONE, NONE) for name in "AB")
    return SignalPath(Arm("two", (0.0, 0.0), tuple(joints)), placed)


def coarse_and_fine(path: SignalPath, count: int, finer: int = 16) -> tuple[np.ndarray, np.ndarray]:
    """Return the first joint's load (count,) by samples of half a STEP and by such as are finer; others rest."""
    out = []
    for times in (1, finer):
        step, rows = 0.5 * STEP / times, (count - 1) * times + 1
        time, *signals = drives(rows, step)
        rest = [np.zeros((path.n - 1, rows))] * (len(signals) - 1) + [np.full((path.n - 1, rows), 1e-9)]
        parts = [np.vstack([own, others]) for own, others in zip(signals, rest, strict=True)]
        out.append(followed(path, np.vstack([time, *parts]), step)[0][::times])
    return out[0], out[1]


def test_a_play_elsewhere_leaves_a_shaft_its_swing() -> None:
    shaft = Placed(registry()["joint_flexibility"], 0, {"stiffness": 500.0, "damping": 1.0})
    play = Placed(registry()["backlash"], 1, {"gap": 1e-9, "stiffness": 1e6, "damping": 1.0})
    beside, exact = coarse_and_fine(two(shaft, play), 300)
    assert np.sqrt(np.mean((beside - exact) ** 2)) < 0.01 * np.std(exact)


@pytest.mark.parametrize(("wall", "off"), [(3e2, 0.005), (3e4, 0.05)])
def test_a_wall_at_a_compliant_link_throws_it_back_as_far(wall: float, off: float) -> None:
    """Torque from outside goes with the link's own position, not with the motor's."""
    shaft = Placed(registry()["joint_flexibility"], 0, {"stiffness": 300.0, "damping": 0.5})
    stop = Placed(registry()["contact"], 0, {"stiffness": wall, "position": 0.5, "damping": 0.2})
    found, exact = coarse_and_fine(SignalPath(arm(INERTIA), (shaft, stop)), 200)
    assert np.sqrt(np.mean((found - exact) ** 2)) < off * np.std(exact)


def test_a_face_with_a_strong_damper_is_found_from_free_flight() -> None:
    """The rate at a step's end against bisection: Newton's steps alone go back and forth between flight and face."""
    gap, k, damping, h = 0.02, INERTIA * (2.0 * math.pi * 60.0) ** 2, 25.0 * INERTIA / 0.008, 0.008
    play = registry()["backlash"]
    balance = Balance(SignalPath(arm(INERTIA), (Placed(play, 0, {"gap": gap, "stiffness": k, "damping": damping}),)))
    newton, p = _newton(balance, h), values_of(balance.path.entries)
    laws = {"gap": ca.DM(gap), "stiffness": ca.DM(k), "damping": ca.DM(damping)}
    rng, off = np.random.default_rng(0), []
    for _ in range(200):
        start, began, free = rng.uniform(0.0, 1.2) * gap / 2, rng.uniform(-0.5, 2.0), rng.uniform(-50.0, 300.0)

        def missing(rate: float, start: float = start, began: float = began, free: float = free) -> float:
            torque = float(play.transmitted(ca.DM(start + h * rate), ca.DM(rate), laws))
            return rate - began - h * (free - torque / INERTIA)

        exact = brentq(missing, -20.0, 20.0, xtol=1e-12)
        found = began + h * free
        for _ in range(NEWTON):
            found = newton(found, start, began, free, [start, began], 1.0 / INERTIA, [0.0, 0.0], p)
        off.append(abs(float(found) - exact) / (abs(began + h * free - exact) + 1e-6))
    assert np.quantile(off, 0.99) < 0.02


@pytest.mark.parametrize("outside", ["cable_spring", "contact/linear"])
@pytest.mark.parametrize(
    ("soft", "values"),
    [
        ("joint_flexibility", {"stiffness": 100.0, "damping": 0.1}),
        ("backlash", {"gap": 0.01, "stiffness": 100.0, "damping": 0.1}),
        ("base_flexibility", {"stiffness": 100.0, "damping": 0.1, "inertia": 0.1}),
    ],
)
def test_a_link_starts_where_a_spring_or_a_wall_lets_it_rest(soft: str, values: dict[str, float], outside: str) -> None:
    """Its compliance is wound up by as much as what pulls at the link from outside, there where the link is."""
    name, _, law = outside.partition("/")
    own = {"rest": -0.5} if not law else {"position": -0.5, "damping": 0.0}
    spring = Placed(effect_named(name, law or None), 0, {"stiffness": 40.0, **own})
    path = SignalPath(arm(INERTIA), (Placed(registry()[soft], 0, values), spring))
    forward, p = Forward(path), values_of(path.entries)
    links = forward.settled([0.0], [0.0], [0.0], p).full().ravel()
    rates = forward.flow(0.0, [0.0, 0.0, *links], [0.0], [0.0], p)[0].full().ravel()
    assert links[0] < -0.1
    assert rates[3] == pytest.approx(0.0, abs=1e-9)
