"""One joint of known friction and loops around it; what is compiled goes into a folder of the test session."""

from collections.abc import Callable

import pytest

from stribeck.arm import Arm, Friction, Joint
from stribeck.simulate import Compensation, JointLoop, Loop, Reference

A = Friction(5.0, 1.25, 1.5, 0.05)


@pytest.fixture(scope="session")
def arm() -> Arm:
    """One joint of 1 kg m^2."""
    return Arm("one joint", (0.0, 0.0), (Joint("A", "revolute", 0.3, 1.0, (0.0, 0.0), 0.5, 0.5, A, A),))


@pytest.fixture(scope="session")
def loop_of() -> Callable[..., Loop]:
    def build(
        at_zero: str = "set_valued",
        *,
        sample_time: float = 0.0,
        velocity: float | None = None,
        kind: str = "feedback",
        **settings: float,
    ) -> Loop:
        regulate = Reference("regulate", initial_error=0.5)
        reference = regulate if velocity is None else Reference("ramp", velocity=velocity)
        entry = JointLoop("A", 30.0, reference, compensation=Compensation(kind, 1.0, at_zero), **settings)  # type: ignore[arg-type]
        return Loop(sample_time, 60.0, (entry,))

    return build
