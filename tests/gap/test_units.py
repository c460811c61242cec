"""The same arm in other units, seen in a mirror, or from a base that is turned has the same gap."""

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from stribeck.arm import Arm, Friction
from stribeck.gap.diagnose import diagnose
from stribeck.gap.result import Diagnosis
from stribeck.run import Run

from .conftest import NOMINAL, recorded

HIDDEN = (("presliding", {"stiffness": 900.0, "damping": 4.0}), ("torque_offset", {"offset": 1.2}))
TWIN = ("asymmetric_friction",)  # of one class with an offset beside a bristle, which takes what is left at rest
Recording = tuple[Arm, tuple[Run, ...]]


def in_units_of_torque(arm: Arm, runs: Sequence[Run], times: float) -> Recording:
    """Masses, inertias and friction go with the torque; a tolerance that is relative stays."""

    def friction(f: Friction) -> Friction:
        return Friction(times * f.C0, times * f.C1, times * f.C2, f.alpha)

    joints = tuple(
        replace(
            j, mass=times * j.mass, inertia=times * j.inertia, rotor_inertia=times * j.rotor_inertia,
            friction=friction(j.friction), backward=friction(j.backward),
            torque_limit=None if j.torque_limit is None else times * j.torque_limit,
        )
        for j in arm.joints
    )  # fmt: skip
    return replace(arm, joints=joints), tuple(replace(run, tau=times * run.tau) for run in runs)


def in_units_of_length(arm: Arm, runs: Sequence[Run], times: float) -> Recording:
    """Torque and angles stay: gravity is a length as well, and a mass goes with one over its square."""
    joints = tuple(
        replace(j, length=times * j.length, com=(times * j.com[0], times * j.com[1]), mass=j.mass / times**2)
        for j in arm.joints
    )
    return replace(arm, joints=joints, gravity=(times * arm.gravity[0], times * arm.gravity[1])), tuple(runs)


def in_a_mirror(arm: Arm, runs: Sequence[Run]) -> Recording:
    joints = tuple(replace(j, com=(j.com[0], -j.com[1]), friction=j.backward, backward=j.friction) for j in arm.joints)
    seen = replace(arm, joints=joints, gravity=(arm.gravity[0], -arm.gravity[1]))
    turned = ("q", "tau", "dq", "q_ref", "dq_ref")
    return seen, tuple(replace(run, **{k: -v for k in turned if (v := getattr(run, k)) is not None}) for run in runs)


def from_a_turned_base(arm: Arm, runs: Sequence[Run], angle: float) -> Recording:
    (x, y), c, s = arm.gravity, math.cos(angle), math.sin(angle)
    turned = np.eye(arm.n)[0] * angle
    moved = [{k: v + turned for k in ("q", "q_ref") if (v := getattr(run, k)) is not None} for run in runs]
    told = tuple(replace(run, **values) for run, values in zip(runs, moved, strict=True))
    return replace(arm, gravity=(c * x - s * y, s * x + c * y)), told


@cache
def as_it_is() -> Diagnosis:
    return diagnose(NOMINAL, recorded(*HIDDEN), jobs=1, leave_out=TWIN)


def offset(d: Diagnosis) -> float:
    (cause,) = (cause for cause in d.causes if cause.effect == "torque_offset")
    return cause.parameters["A"]["offset"].value


@pytest.mark.long
def test_a_diagnosis_is_the_same_in_other_units() -> None:
    """Torque in kN m, lengths in units of 125 mm, angles from elsewhere: the same numbers, but for rounding."""
    there = from_a_turned_base(*in_units_of_length(*in_units_of_torque(NOMINAL, recorded(*HIDDEN), 1e-3), 8.0), 2.1)
    told, known = diagnose(*there, jobs=1, leave_out=TWIN), as_it_is()
    assert told.verdict == known.verdict == "explained"
    assert told.named == known.named
    assert set(known.named) == {name for name, _ in HIDDEN}
    for same, cause in zip(told.causes, known.causes, strict=True):
        assert same.effect == cause.effect
        assert same.presence == pytest.approx(cause.presence, abs=1e-3)
    assert offset(told) == pytest.approx(1e-3 * offset(known), rel=1e-4)
    assert told.closed is not None
    assert known.closed is not None
    assert told.closed.value == pytest.approx(known.closed.value, abs=1e-5)


@pytest.mark.long
def test_a_diagnosis_is_the_same_in_a_mirror() -> None:
    """Noise that is drawn has not the sign of the motion, so that numbers differ a little."""
    told, known = diagnose(*in_a_mirror(NOMINAL, recorded(*HIDDEN)), jobs=1, leave_out=TWIN), as_it_is()
    assert told.verdict == known.verdict
    assert set(told.named) == set(known.named)
    for cause in known.causes:
        (same,) = (c for c in told.causes if c.effect == cause.effect)
        assert same.presence == pytest.approx(cause.presence, abs=0.02)
    assert offset(told) == pytest.approx(-offset(known), rel=0.01)


@pytest.mark.long
def test_an_offset_and_its_twin_beside_bristles_are_one_class() -> None:
    found = diagnose(NOMINAL, recorded(*HIDDEN), jobs=1)
    classes = {cause.effect: set(cause.equivalent) for cause in found.causes if cause.effect in found.named}
    assert classes.keys() <= {"presliding", "torque_offset", *TWIN}
    assert {"torque_offset", *TWIN} in [same & {"torque_offset", *TWIN} for same in classes.values()]
