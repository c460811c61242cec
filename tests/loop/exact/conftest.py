"""Arms of known friction, and loops around them; what is compiled goes into a folder of the test session."""

import math
from collections.abc import Callable

import pytest

from stribeck.arm import Arm, Friction, Joint
from stribeck.loop.exact.engine import RoundsEngine
from stribeck.simulate import Compensation, JointLoop, Loop, Reference

A = Friction(5.0, 1.25, 1.5, 0.05)
B = Friction(2.2, 0.6, 0.8, 0.04)
COULOMB = Friction(5.0, 0.0, 0.0, 0.05)


def one_joint(friction: Friction) -> Arm:
    """One joint of 1 kg m^2."""
    return Arm("one joint", (0.0, 0.0), (Joint("A", "revolute", 0.3, 1.0, (0.0, 0.0), 0.5, 0.5, friction, friction),))


def two_links() -> Arm:
    joints = (
        Joint("A", "revolute", 0.35, 4.0, (0.17, 0.02), 0.06, 0.15, A, A),
        Joint("B", "revolute", 0.26, 2.0, (0.13, -0.01), 0.02, 0.08, B, B),
    )
    return Arm("two links", (0.0, 0.0), joints)


@pytest.fixture(scope="session")
def joint_a(_own_cache: None) -> RoundsEngine:
    return RoundsEngine(one_joint(A))


@pytest.fixture(scope="session")
def joint_b(_own_cache: None) -> RoundsEngine:
    return RoundsEngine(one_joint(B))


@pytest.fixture(scope="session")
def coulomb(_own_cache: None) -> RoundsEngine:
    return RoundsEngine(one_joint(COULOMB))


@pytest.fixture(scope="session")
def level_arm(_own_cache: None) -> RoundsEngine:
    return RoundsEngine(two_links())


@pytest.fixture(scope="session")
def engine_of(_own_cache: None) -> Callable[[Friction], RoundsEngine]:
    return lambda friction: RoundsEngine(one_joint(friction))


@pytest.fixture(scope="session")
def loop_of() -> Callable[..., Loop]:
    """A loop of one joint of 1 kg m^2; ``zeta`` sets kv."""

    def build(
        ratio: float | None = None,
        at_zero: str = "set_valued",
        *,
        kp: float = 30.0,
        zeta: float = 1.0,
        sample_time: float = 0.0,
        kind: str = "feedback",
        velocity: float | None = None,
        error: float = 0.5,
        dead_band: float = 0.0,
        **settings: float,
    ) -> Loop:
        compensation = Compensation() if ratio is None else Compensation(kind, ratio, at_zero, dead_band)  # type: ignore[arg-type]
        regulate = Reference("regulate", initial_error=error)
        reference = regulate if velocity is None else Reference("ramp", velocity=velocity)
        kv = 2.0 * zeta * math.sqrt(kp)
        entry = JointLoop("A", kp, reference, kv=kv, compensation=compensation, **settings)  # type: ignore[arg-type]
        return Loop(sample_time, 60.0, (entry,))

    return build
