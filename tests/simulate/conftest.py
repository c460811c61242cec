"""Arms and engines that several tests share; everything compiled goes into a folder of the test session."""

from collections.abc import Sequence

import pytest

from stribeck.arm import Arm, EffectEntry, Friction, Joint
from stribeck.simulate import Engine, path_of

A = Friction(5.0, 1.25, 1.5, 0.05)
B = Friction(2.2, 0.6, 0.8, 0.04)


def two_links(*effects: EffectEntry, gravity: tuple[float, float] = (0.0, 0.0)) -> Arm:
    """The direct-drive arm of the paper, joints A and B."""
    joints = (
        Joint("A", "revolute", 0.35, 4.0, (0.17, 0.02), 0.06, 0.15, A, A),
        Joint("B", "revolute", 0.26, 2.0, (0.13, -0.01), 0.02, 0.08, B, B),
    )
    return Arm("two links", gravity, joints, effects=tuple(effects))


def one_joint(friction: Friction) -> Arm:
    """One joint of 1 kg m^2."""
    return Arm("one joint", (0.0, 0.0), (Joint("A", "revolute", 0.3, 1.0, (0.0, 0.0), 0.5, 0.5, friction, friction),))


def entry(effect: str, joints: Sequence[str], **values: float) -> EffectEntry:
    return EffectEntry(effect, tuple(joints), dict.fromkeys(joints, values))


@pytest.fixture(scope="session")
def level_arm(_own_cache: None) -> Engine:
    """Two links in a horizontal plane."""
    return Engine(path_of(two_links()))


@pytest.fixture(scope="session")
def hanging_arm(_own_cache: None) -> Engine:
    """Two links in a vertical plane, measured from the downward vertical."""
    return Engine(path_of(two_links(gravity=(9.81, 0.0))))


@pytest.fixture(scope="session")
def joint_a(_own_cache: None) -> Engine:
    return Engine(path_of(one_joint(A)))


@pytest.fixture(scope="session")
def joint_b(_own_cache: None) -> Engine:
    return Engine(path_of(one_joint(B)))


@pytest.fixture(scope="session")
def coulomb(_own_cache: None) -> Engine:
    return Engine(path_of(one_joint(Friction(5.0, 0.0, 0.0, 0.05))))
