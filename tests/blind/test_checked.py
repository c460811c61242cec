"""An answer that lacks what a score takes from it is told of by file and key, whatever is wrong with it."""

import copy
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from stribeck.blind.checked import check_answer
from stribeck.blind.key import open_sealed
from stribeck.errors import InputError

PATH = Path("answers/case_0001.json")
CAUSE = {
    "effect": "delay", "joints": ["A"], "probability": 0.9, "presence": 0.9, "equivalent": ["delay"],
    "parameters": {"A": {"time": {"value": 0.01, "unit": "s", "ci95": [0.009, None]}}}, "closes": {"value": 1.0},
}  # fmt: skip
SAID: dict[str, Any] = {
    "diagnosis": {
        "verdict": "explained", "named": ["delay"], "causes": [CAUSE, {"effect": "unknown", "probability": 0.1}],
        "where": [{"joint": "A", "channel": "actuator", "share": 0.9}], "gap": {"closed": {"value": 0.9}},
        "settings": {"cutoff_hz": 20.0},
    },
    "retuned": "", "corrected": "", "files": "0", "leave_out": [], "code": "1", "seconds": 1, "processor_seconds": 1.0,
}  # fmt: skip


def test_what_is_whole_passes() -> None:
    check_answer(SAID, PATH)
    silent = copy.deepcopy(SAID)
    silent["diagnosis"] |= {"named": [], "where": [], "gap": {"closed": None}}
    check_answer(silent, PATH)
    check_answer(
        {**{key: SAID[key] for key in SAID if key not in ("diagnosis", "retuned", "corrected")}, "error": "x"}, PATH
    )


@pytest.mark.parametrize(
    ("damage", "says"),
    [
        (lambda said: said.pop("files"), "files is missing"),
        (lambda said: said.update(seconds="long"), "seconds"),
        (lambda said: said.update(diagnosis=[]), "diagnosis"),
        (lambda said: said["diagnosis"].pop("named"), "diagnosis.named is missing"),
        (lambda said: said["diagnosis"]["gap"].update(closed=3), "diagnosis.gap.closed"),
        (lambda said: said["diagnosis"]["causes"][0].pop("effect"), "diagnosis.causes[0].effect is missing"),
        (
            lambda said: said["diagnosis"]["causes"][0].pop("equivalent"),
            "diagnosis.named is no cause of diagnosis.causes",
        ),
        (
            lambda said: said["diagnosis"]["causes"][0]["parameters"]["A"]["time"].update(ci95=[1.0]),
            "diagnosis.causes[0].parameters.A.time.ci95",
        ),
        (lambda said: said.pop("diagnosis") and said.update(error=3), "error"),
    ],
)
def test_what_is_wrong_is_told(damage: Callable[[dict[str, Any]], Any], says: str) -> None:
    said = copy.deepcopy(SAID)
    damage(said)
    with pytest.raises(InputError) as caught:
        check_answer(said, PATH)
    assert str(caught.value).startswith(f"{PATH}: ")
    assert says in str(caught.value)


def test_a_score_looks_before_it_counts(tmp_path: Path, sealed: Any, straw: Any) -> None:
    from stribeck.blind.batch import diagnose_cases
    from stribeck.blind.farm import Processes

    diagnose_cases(sealed[0], tmp_path / "answers", farm=Processes(1), diagnoser=straw)
    path = tmp_path / "answers" / "case_0003.json"
    answer = json.loads(path.read_text())
    del answer["diagnosis"]["verdict"]
    path.write_text(json.dumps(answer))
    with pytest.raises(InputError, match=r"case_0003.json: diagnosis.verdict is missing"):
        open_sealed(tmp_path / "answers", sealed[1])
