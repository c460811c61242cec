"""The stages of the gap, and what is said where re-tuning helps nobody."""

from dataclasses import replace

from stribeck.gap.answer.stages import WORSE, told_worse
from stribeck.gap.result import Stage

from ..conftest import JOINT, TRUE

ARM = replace(TRUE, joints=(JOINT, replace(JOINT, name="B")))


def stages(given: float, tuned: float) -> list[Stage]:
    return [
        Stage("as_given", {"A": 0.3, "B": given}, {}),
        Stage("retuned", {"A": 0.1, "B": tuned}, {}),
        Stage("noise_floor", {"A": 0.05, "B": 0.05}, {}),
    ]


def test_retuning_that_makes_it_worse_is_told_of() -> None:
    (said,) = told_worse(stages(0.2, 0.6), ARM)
    assert said.startswith("B: re-tuned values leave 0.6 N m rms on what was held out, the nominal ones 0.2")
    assert told_worse(stages(0.2, 0.99 * WORSE * 0.2), ARM) == []
    assert told_worse(stages(0.0, 0.0), ARM) == []
    assert len(told_worse(stages(0.0, 0.6), ARM)) == 1
