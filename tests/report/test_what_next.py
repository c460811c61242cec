"""What to do with the answer."""

from __future__ import annotations

from dataclasses import replace

import pytest

from stribeck.arm import EffectEntry
from stribeck.report.what_next import what_next

EXPERIMENT = {
    "what": "Record a chirp",
    "separates": ["delay", "actuator_lag"],
    "expected_gain": {"probability_resolved": 0.9},
}


@pytest.mark.parametrize(
    ("verdict", "says"),
    [
        ("no_gap", "Use corrected.toml, the arm file with its values re-tuned"),
        ("explained", "Use corrected.toml, in which the model has what is named"),
        ("partly_explained", "What is left is at joints A and B: look there first"),
        ("unexplained", "What is left is at joints A and B: look there first"),
    ],
)
def test_every_verdict_says_what_is_next(diagnosis, verdict, says):
    assert says in what_next(diagnosis(verdict))


def test_a_joint_at_its_floor_is_not_where_one_looks(diagnosis):
    made = diagnosis("partly_explained")
    stages = tuple(
        replace(s, torque={**s.torque, "B": 0.01}) if s.stage in ("presliding", "noise_floor") else s
        for s in made.stages
    )
    assert "What is left is at joint A: look" in what_next(replace(made, stages=stages))


@pytest.mark.parametrize(
    ("verdict", "does"),
    [("explained", "is meant to tell apart what these data cannot"), ("unexplained", "may bring the cause out")],
)
def test_an_experiment_is_said_to_be_poor_where_it_is(diagnosis, verdict, does):
    made = replace(diagnosis(verdict), next_experiment=EXPERIMENT)
    assert f"{does}." in what_next(made)
    poor = {**EXPERIMENT, "expected_gain": {"probability_resolved": 0.05}}
    text = what_next(replace(made, next_experiment=poor)).replace("\u00a0", " ")
    assert f"{does}, though it is unlikely to (probability 5 %)." in text
    assert does not in what_next(replace(made, next_experiment=None))


def test_a_model_of_a_record_that_is_early_is_for_predict_alone(diagnosis):
    made = diagnosis()
    shift = EffectEntry("time_shift", ("A",), {"A": {"time": -0.004}})
    early = replace(made.models["corrected"], effects=(shift,))
    assert "predict takes it; no loop" in what_next(replace(made, models={**made.models, "corrected": early}))
    assert "predict, simulate, limit-cycle and export-fmu take it" in what_next(made)
