"""A joint's loop by itself: where the others are held, and the gains that it keeps."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import Arm, Friction, Joint
from stribeck.loop.exact.engine import RoundsEngine
from stribeck.loop.linear import assemble, free
from stribeck.loop.maps import Map, label_map
from stribeck.loop.surroundings import Grid, alone, branch_of, map_of
from stribeck.simulate import JointLoop, Loop, Reference, simulate_loop

FRICTION = Friction(2.2, 0.6, 0.8, 0.04)


def two_links() -> Arm:
    joint = Joint("A", "revolute", 0.35, 4.0, (0.17, 0.0), 0.06, 0.15, FRICTION, FRICTION)
    return Arm("two links", (0.0, 0.0), (joint, replace(joint, name="B", mass=3.0)))


def inertia_of_a(bend: float) -> float:
    """What A moves with B held there, kg m^2, B's rotor riding along."""
    arm_a = 0.06 + 4.0 * 0.17**2 + 0.15
    return arm_a + 0.06 + 3.0 * (0.35**2 + 0.17**2 + 2.0 * 0.35 * 0.17 * math.cos(bend))


def both(reference: Reference, start: float = 0.0, velocity: str = "true") -> Loop:
    a = JointLoop("A", 30.0, Reference("regulate", initial_error=0.3), velocity=velocity)  # type: ignore[arg-type]
    b = JointLoop("B", 30.0, reference, velocity=velocity, start=start)  # type: ignore[arg-type]
    return Loop(0.0125, 1.0, (a, b))


STEPS = Reference("steps", times=(0.0, 0.5), values=(1.0, 2.5))
FAR = Reference("regulate", initial_error=2.5)


@pytest.mark.parametrize(
    ("reference", "start", "begins", "ends"),
    [(STEPS, 0.3, 0.3, 2.5), (FAR, 0.3, -2.2, 0.3), (Reference("ramp", velocity=0.1), 0.3, 0.3, 0.3)],
)
def test_one_joint_moves_what_it_moves_at_the_end_with_the_gain_of_the_start(
    reference: Reference, start: float, begins: float, ends: float
) -> None:
    given = both(reference, start)
    single = alone(two_links(), given, "A")
    kv = 2.0 * math.sqrt(30.0 * inertia_of_a(begins))
    assert [(entry.joint, entry.kv) for entry in single.joints] == [("A", pytest.approx(kv))]
    assert single.clamp == {"B": ends}
    assembly = assemble(two_links(), given, free(two_links(), given))
    assert (assembly.inertia[0], assembly.tuned[0]) == pytest.approx((inertia_of_a(ends), inertia_of_a(begins)))
    run = simulate_loop(two_links(), given).run("one")
    assert run.q_ref is not None
    assert run.dq is not None
    moving = np.abs(run.dq[:, 0]) > 1e-3
    seen = (30.0 * (run.q_ref[:, 0] - run.q[:, 0]) - run.tau[:, 0])[moving] / run.dq[moving, 0]
    assert seen == pytest.approx(kv)  # the controller's own


def test_critical_damping_follows_kp_from_the_gain_of_the_start(monkeypatch: pytest.MonkeyPatch) -> None:
    engine, given = RoundsEngine(two_links()), both(FAR)
    seen: list[Loop] = []
    monkeypatch.setattr("stribeck.loop.surroundings.continue_through", lambda _, loops, joint: seen.extend(loops) or [])
    branch_of(engine, given, "A", None)
    gains = np.array([[loop.joints[0].kp, loop.joints[0].kv] for loop in seen], dtype=float)
    assert np.count_nonzero(gains[:, 0] == 30.0) == 1  # its own
    assert np.diff(gains[:, 0]).max() < -1e-3
    assert gains[:, 1] == pytest.approx(2.0 * np.sqrt(gains[:, 0] * inertia_of_a(2.5)))
    grids: list[dict[str, np.ndarray]] = []
    ramp = replace(given.joints[0], reference=Reference("ramp", velocity=0.02), kp=20.0)

    def label(arm: Arm, loop: Loop, joint: str, axes: dict[str, np.ndarray], **_: object) -> Map:
        grids.append(axes)
        return label_map(arm, loop, joint, {**axes, "kp": [20.0], "velocity": [0.02]})

    monkeypatch.setattr("stribeck.loop.surroundings.label_map", label)
    found = map_of(engine, replace(given, joints=(ramp, given.joints[1])), "A", Grid(2, 2), None)
    assert found.axes.names == ("kp", "velocity")
    assert found.codes.shape == found.axes.shape
    assert grids[0]["zeta"] ** 2 == pytest.approx(inertia_of_a(2.5) / inertia_of_a(0.0))
