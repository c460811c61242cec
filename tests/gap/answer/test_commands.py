"""Commands that are not what the arm file is about are told of in a diagnosis."""

from dataclasses import replace

from stribeck.effects.registry import registry
from stribeck.gap.diagnose import diagnose

from ..conftest import NOMINAL, recorded


def test_a_wrong_unit_is_told_of_in_a_diagnosis() -> None:
    """A wrong sign is as well, as one of several conventions."""
    others = [name for name in registry() if name != "delay"]
    runs = recorded()
    right = diagnose(NOMINAL, runs, jobs=1, leave_out=others)
    wrong = diagnose(NOMINAL, [replace(run, tau=0.1 * run.tau) for run in runs], jobs=1, leave_out=others)
    assert not any("check its unit" in text for text in right.warnings)
    assert any("check its unit" in text for text in wrong.warnings)
