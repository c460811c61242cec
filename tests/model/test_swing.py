"""The states one sample later: a link behind a stiff compliance, on a motion that is sampled slowly."""

import math
from typing import Any

import numpy as np
import pytest

from stribeck.arm import Arm, Friction, Joint
from stribeck.effects.registry import registry
from stribeck.model.cut import Cut
from stribeck.model.drive import DRIVE
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath

INERTIA, STEP, HERTZ = 0.2, 0.008, 3.0  # kg m^2, s, of the motor's motion
NONE = Friction(0.0, 0.0, 0.0, 0.05)


def arm(inertia: float) -> Arm:
    return Arm("link", (0.0, 0.0), (Joint("A", "revolute", 0.3, 1e-6, (0.0, 0.0), inertia, 0.01, NONE, NONE),))


def drives(count: int) -> np.ndarray:
    """Return the drive (signals, count) of a sine of 1 rad."""
    w, t = 2.0 * math.pi * HERTZ, np.arange(count) * STEP
    known = {
        "time": t, "position": np.sin(w * t), "velocity": w * np.cos(w * t), "acceleration": -(w**2) * np.sin(w * t),
        "velocity_sd": np.full(count, 1e-9),
    }  # fmt: skip
    return np.array([known.get(name, np.zeros(count)) for name in DRIVE])


def loads(name: str, values: dict[str, float], count: int, inertia: float = INERTIA) -> np.ndarray:
    """Return the torque (count,) that is handed to the link, N m."""
    path = SignalPath(arm(inertia), (Placed(registry()[name], 0),))
    p = values_of(path.entries)
    own = [i for i, entry in enumerate(path.entries) if entry.owner == 0]
    p[own] = [values[path.entries[i].name] for i in own]
    cut, drive = Cut(path, STEP, ()), drives(count)
    states: Any = [cut.begin(drive[:, 0], p, [0.0])]
    for i in range(count - 1):
        states.append(cut.follow(states[-1], drive[:, i], drive[:, i + 1], p, [0.0]))
    along = cut.settled(np.hstack([np.array(one) for one in states]))
    return np.array([float(cut.balance(drive[:, i], along[:, i], p, [0.0])[1][2]) for i in range(count)])


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
