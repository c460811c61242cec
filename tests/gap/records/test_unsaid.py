"""What an arm file has as zero is re-tuned, not diagnosed; what it states is held to what it states."""

import math
from dataclasses import replace

import pytest

from stribeck.arm import Arm
from stribeck.effects.registry import registry
from stribeck.gap.diagnose import diagnose
from stribeck.gap.records.prepare import prepare
from stribeck.gap.records.unsaid import told_of
from stribeck.gap.result import Estimate, Tuned
from stribeck.identify.run_fit import fit_runs
from stribeck.model.path import SignalPath

from ..conftest import FRICTION, NOMINAL, recorded


def without(arm: Arm, **values: float) -> Arm:
    """Return the arm with other friction constants at its first joint."""
    joint = arm.joints[0]
    friction = replace(joint.friction, **values)
    return replace(arm, joints=(replace(joint, friction=friction, backward=friction), *arm.joints[1:]))


def spreads(arm: Arm) -> dict[str, float]:
    prepared = prepare(arm, recorded())
    return {entry.key.rpartition(".")[2]: entry.sd for entry in SignalPath(prepared.arm).entries}


def test_only_what_is_zero_and_has_no_tolerance_gets_one() -> None:
    arm = without(NOMINAL, C2=0.0)
    said = replace(arm, joints=(replace(arm.joints[0], tolerance={"C2": 0.0}), *arm.joints[1:]))
    nominal, unsaid, held = spreads(NOMINAL), spreads(arm), spreads(said)
    assert nominal["C2"] == pytest.approx(NOMINAL.tolerance.friction * NOMINAL.joints[0].friction.C2)
    assert unsaid["C2"] > 0.0
    assert held["C2"] == 0.0
    assert {key: sd for key, sd in unsaid.items() if key != "C2"} == {k: v for k, v in nominal.items() if k != "C2"}


def test_friction_that_the_file_leaves_out_is_no_effect() -> None:
    arm = without(NOMINAL, C0=0.0, C1=0.0, C2=0.0)
    others = [name for name in registry() if "friction" not in name and name != "presliding"]
    found = diagnose(arm, recorded(), jobs=1, leave_out=others)
    as_given, retuned = found.stages[0].torque, found.stages[1].torque
    assert retuned["A"] < 0.3 * as_given["A"]
    assert "asymmetric_friction" not in found.named
    assert any("friction.C0: 0 in the arm file" in warning for warning in found.warnings)
    assert all(joint.tolerance == {} for arm in found.models.values() for joint in arm.joints)
    level = found.models["corrected"].joints[0].friction.C0
    assert level == pytest.approx(FRICTION.C0, rel=0.3)


@pytest.mark.parametrize(("unit", "said"), [("1", "0.4 by"), ("N m", "0.4 N m by")])
def test_what_moved_is_told_with_its_unit_where_it_has_one(unit: str, said: str) -> None:
    moved = Tuned("position_dependent_friction[A].sine", unit, 0.3, math.inf, Estimate(0.4, 0.39, 0.41), moved=True)
    (told,) = told_of([moved])
    assert said in told


def test_what_identification_reads_off_is_not_held_by_the_file() -> None:
    """A tolerance is meant around the file's value, not around one that was read off the recordings."""
    held = replace(NOMINAL, joints=(replace(NOMINAL.joints[0], tolerance={"C0": 0.0, "C2": 0.0}),))
    prepared = prepare(NOMINAL, recorded())
    found = [fit_runs(arm, prepared.fit, [(True, True)], prepared.cutoff) for arm in (NOMINAL, held)]
    plain, told = (one.arm.joints[0] for one in found)
    assert told.friction == plain.friction
    assert told.backward == plain.backward
