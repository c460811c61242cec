"""``diagnosis.json`` and ``corrected.toml``: the contract's keys, JSON for every reader, six digits."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import Arm, EffectEntry, Friction, Joint, load_arm
from stribeck.gap.answer.files import diagnosis_json, write_diagnosis
from stribeck.gap.result import Candidate, Cause, Diagnosis, Estimate, Place, Region, Stage, Tuned

PRESLIDING = {"A": {"stiffness": 1500.0, "damping": 5.0}}


def arm(kind="revolute", effects=()):
    friction = Friction(4.6, 1.65, 1.4, 0.06)
    return Arm("a", (0.0, 0.0), (Joint("A", kind, 0.35, 4.0, (0.17, 0.0), 0.06, 0.15, friction, friction),), None,
               effects=effects)  # fmt: skip


@pytest.fixture
def diagnosis():
    corrected = arm(effects=(EffectEntry("presliding", ("A",), PRESLIDING),))
    part = Estimate(0.9123456789, 0.88, 0.93)
    stiffness = Estimate(1500.123456, 1400.0, 1600.0, "N m/rad")
    return Diagnosis(
        arm="a",
        joints=("A",),
        fit_runs=("run_00.csv",),
        held_out_runs=("run_03.csv",),
        verdict="explained",
        named=("presliding",),
        horizon=0.5,
        stages=(
            Stage("as_given", {"A": 1.9}, {"A": math.nan}),
            Stage("retuned", {"A": 1.2}, {}),
            Stage("presliding", {"A": 0.2}, {"A": 0.01}),
            Stage("noise_floor", {"A": 0.1}, {}),
        ),
        closed=part,
        where=(Place("A", "friction", "velocity reversal", Estimate(0.62, 0.5, 0.7)),),
        regions=(Region("A", "velocity", "velocity reversal", Estimate(0.62, 0.5, 0.7), 0.1, 2.0, 0.2),),
        causes=(
            Cause("presliding", 0.97, ("A",), ("presliding",), {"A": {"stiffness": stiffness}}, part),
            Cause("backlash", 0.02, ("A",), ("backlash",)),
            Cause("unknown", 0.01),
        ),
        candidates=(Candidate(1, "presliding", "A", part, 12.0, "Solve_Succeeded", True),),
        tuned=(Tuned("A.C0", "N m", 4.6, 1.4, Estimate(5.2, 5.1, 5.3)),),
        traces=(),
        models={"as_given": arm(), "retuned": arm(), "corrected": corrected},
        notes=("a note",),
        warnings=("a warning",),
        settings={"seed": np.int64(1), "filter": np.float64(25.0), "rule": "t"},
    )


def test_the_law_of_a_family_is_said_where_there_are_several(diagnosis, tmp_path):
    assert all("law" not in cause for cause in diagnosis_json(diagnosis)["causes"])
    chosen = replace(diagnosis.causes[0], law={"A": "maxwell_slip"})
    corrected = arm(effects=(EffectEntry("presliding", ("A",), PRESLIDING, "maxwell_slip"),))
    said = replace(diagnosis, causes=(chosen,), models={**diagnosis.models, "corrected": corrected})
    assert diagnosis_json(said)["causes"][0]["law"] == {"A": "maxwell_slip"}
    write_diagnosis(said, tmp_path)
    assert load_arm(tmp_path / "corrected.toml").effects[0].law == "maxwell_slip"


def test_keys_and_nesting_are_those_of_the_contract(diagnosis):
    data = diagnosis_json(diagnosis)
    head = [
        "schema",
        "version",
        "arm",
        "runs",
        "verdict",
        "named",
        "gap",
        "where",
        "causes",
        "next_experiment",
        "warnings",
    ]
    assert list(data)[: len(head)] == head
    assert data["schema"] == "stribeck.diagnosis/1"
    assert data["runs"] == {"fit": ["run_00.csv"], "held_out": ["run_03.csv"]}
    assert data["gap"]["metrics"] == {
        "torque": "N m, rms per joint along the recorded motion",
        "motion": "rad, rms per joint over the horizon",
    }
    assert list(data["gap"]) == ["metrics", "horizon", "stages", "closed"]
    assert data["gap"]["stages"][1] == {"stage": "retuned", "torque": {"A": 1.2}, "motion": {}}
    assert data["gap"]["closed"] == {"value": 0.912346, "ci95": [0.88, 0.93]}
    assert data["where"] == [
        {
            "joint": "A",
            "channel": "friction",
            "region": "velocity reversal",
            "share": 0.62,
            "ci95": [0.5, 0.7],
            "channels": ["friction"],
        }
    ]
    assert data["causes"][0] == {
        "effect": "presliding",
        "joints": ["A"],
        "probability": 0.97,
        "equivalent": ["presliding"],
        "parameters": {"A": {"stiffness": {"value": 1500.12, "unit": "N m/rad", "ci95": [1400.0, 1600.0]}}},
        "closes": {"value": 0.912346, "ci95": [0.88, 0.93]},
    }
    assert data["causes"][1]["closes"] is None
    assert data["causes"][2] == {"effect": "unknown", "probability": 0.01}
    assert data["next_experiment"] is None


def test_extensions_carry_what_the_report_shows(diagnosis):
    data = diagnosis_json(diagnosis)
    assert data["retuned"][0] == {
        "key": "A.C0", "unit": "N m", "nominal": 4.6, "tolerance": 1.4, "value": 5.2, "ci95": [5.1, 5.3],
        "at_limit": False, "identified": True, "moved": False,
    }  # fmt: skip
    assert data["regions"][0]["rms_corrected"] == 0.2
    assert data["candidates"][0]["chosen"] is True
    assert data["settings"] == {"seed": 1, "filter": 25.0, "rule": "t"}
    assert data["notes"] == ["a note"]


def test_prismatic_axis_has_newton_and_metre(diagnosis):
    models = {**diagnosis.models, "as_given": arm("prismatic")}
    metrics = diagnosis_json(replace(diagnosis, models=models))["gap"]["metrics"]
    assert metrics["torque"].startswith("N,")
    assert metrics["motion"].startswith("m,")


def test_files_are_strict_json_and_a_readable_arm(diagnosis, tmp_path):
    odd = replace(
        diagnosis,
        arm="bad \udc80 name \u2028 é",
        closed=Estimate(math.inf, -math.inf, math.nan),
        next_experiment={"what": "chirp", "band": (0.1, np.float64(20.0)), "ok": np.bool_(True), "x": np.arange(2.0)},
    )
    write_diagnosis(odd, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {"diagnosis.json", "corrected.toml"}
    text = (tmp_path / "diagnosis.json").read_text(encoding="utf-8")
    data = json.loads(text, parse_constant=pytest.fail)
    assert data["arm"] == odd.arm
    assert data["gap"]["closed"] == {"value": None, "ci95": [None, None]}
    assert data["gap"]["stages"][0]["motion"] == {"A": None}
    assert data["next_experiment"] == {"what": "chirp", "band": [0.1, 20.0], "ok": True, "x": [0.0, 1.0]}
    back = load_arm(tmp_path / "corrected.toml")
    assert back == diagnosis.models["corrected"]


def test_the_same_diagnosis_gives_the_same_bytes(diagnosis, tmp_path):
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        write_diagnosis(diagnosis, tmp_path / name)
    assert (tmp_path / "a/diagnosis.json").read_bytes() == (tmp_path / "b/diagnosis.json").read_bytes()


def test_a_cause_that_may_be_at_any_of_its_joints_says_so(diagnosis):
    first, *others = diagnosis.causes
    scattered = replace(diagnosis, causes=(replace(first, anywhere=True), *others))
    assert [cause.get("anywhere") for cause in diagnosis_json(scattered)["causes"]] == [True, None, None]
