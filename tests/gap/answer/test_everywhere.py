"""A law that holds at all joints alike: every joint is told of, and the arm file holds it once."""

import pytest

from stribeck.effects.placing import placed_effects
from stribeck.effects.registry import registry
from stribeck.gap.diagnose import diagnose

from ...effects.bench import nominal_arm, recorded

EARLY = -0.01  # s


@pytest.mark.long
def test_a_clock_that_is_early_is_told_of_at_every_joint() -> None:
    others = [name for name in registry() if name != "time_shift"]
    found = diagnose(nominal_arm(), recorded("time_shift", ("A", "B"), {"time": EARLY}), jobs=1, leave_out=others)
    assert found.named == ("time_shift",)
    cause = next(cause for cause in found.causes if cause.effect == "time_shift")
    assert (cause.joints, cause.law) == (("A", "B"), dict.fromkeys("AB", "all_joints"))
    assert {joint: own["time"].value for joint, own in cause.parameters.items()} == pytest.approx(
        dict.fromkeys("AB", EARLY), abs=2e-4
    )
    assert [row.joint for row in found.candidates if row.chosen] == ["A, B"]
    (place,) = placed_effects(found.models["corrected"])
    assert place.joints(2) == (0, 1)
