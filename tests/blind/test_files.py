"""Answers that were damaged are refused in one line, by file and key."""

import copy
import hashlib
import json
import math
import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from stribeck.blind.answer import left_out_of
from stribeck.blind.batch import diagnose_cases
from stribeck.blind.farm import Processes
from stribeck.blind.files import read_answer, read_settings
from stribeck.blind.key import open_sealed
from stribeck.errors import InputError

HIDDEN = {"effect": "delay", "joint": "A", "parameters": {"time": 0.01}, "strength": 3.0}
TRUTH = {"files": "0", "level": "clear", "known": True, "effects": [HIDDEN], "disturbances": []}
KEY = {"schema": "stribeck.withheld-key/1", "cases": {"case_1": TRUTH}}
SETTINGS = {"schema": "stribeck.withheld-results/1", "code": "1", "library": ["delay"]}
CAUSE = {"effect": "delay", "joints": ["A"], "probability": 0.9, "equivalent": ["delay"], "parameters": {}}
REST = {"effect": "unknown", "probability": 0.1}
ANSWER = {
    "schema": "stribeck.withheld-answer/1", "files": "0", "leave_out": [], "code": "1", "seconds": 1,
    "processor_seconds": 1.0, "retuned": "", "corrected": "",
    "diagnosis": {
        "verdict": "explained", "named": ["delay"], "causes": [CAUSE, REST], "gap": {"closed": {"value": 0.9}},
        "where": [{"joint": "A", "channel": "actuator", "share": 0.5}],
    },
}  # fmt: skip


def changed(*keys: Any, value: Any = None, of: dict[str, Any] = ANSWER) -> dict[str, Any]:
    """The answer, or another file, with another value at a place, or without it."""
    answer: Any = copy.deepcopy(of)
    inner = answer
    for key in keys[:-1]:
        inner = inner[key]
    if value is None:
        del inner[keys[-1]]
    else:
        inner[keys[-1]] = value
    return answer


@pytest.mark.parametrize(
    ("answer", "says"),
    [
        (changed("diagnosis"), "diagnosis is missing"),
        (changed("diagnosis", value=[]), "diagnosis must be a table: found []"),
        (changed("files"), "files is missing"),
        (changed("corrected"), "must have retuned and corrected, of which gap.closed tells"),
        (changed("seconds", value="x"), 'seconds must be a number: found "x"'),
        (changed("leave_out", value="delay"), 'leave_out must be an array: found "delay"'),
        (changed("diagnosis", "gap", value={}), "diagnosis.gap.closed is missing"),
        (changed("diagnosis", "named", value="delay"), 'diagnosis.named must be an array: found "delay"'),
        (changed("diagnosis", "named", 0, value="cogging"), "diagnosis must have a cause for every name in named"),
        (changed("diagnosis", "where", 0, "channel"), "diagnosis.where[0].channel is missing"),
        (changed("diagnosis", "causes", 0, "equivalent"), "causes[0] must have joints, equivalent and parameters"),
        (changed("diagnosis", "causes", 1, "probability", value=7), "causes[1].probability must not be greater than 1"),
        (changed("diagnosis", "causes", 0, "presence", value=math.nan), "causes[0].presence must be finite: found NaN"),
        (
            changed("diagnosis", "causes", 0, "parameters", value={"A": {"time": 3}}),
            "A.time must be a table",
        ),
        (changed("error", value=7), "error must be text in quotes: found 7"),
    ],
)
def test_a_damaged_answer_is_refused(tmp_path: Path, answer: dict[str, Any], says: str) -> None:
    path = tmp_path / "case_0001.json"
    path.write_text(json.dumps(answer))
    with pytest.raises(InputError, match=re.escape("case_0001.json: ") + ".*" + re.escape(says)):
        read_answer(path)


def test_who_claims_nothing_need_not_deliver_arms(tmp_path: Path) -> None:
    """As another diagnoser, of which names alone are scored."""
    answer = changed("corrected", of=changed("retuned"))
    answer["diagnosis"]["gap"]["closed"] = None
    (tmp_path / "a.json").write_text(json.dumps(answer))
    assert read_answer(tmp_path / "a.json") == answer


def test_what_is_not_scored_is_kept(tmp_path: Path) -> None:
    for answer in (ANSWER, {**ANSWER, "more": [1]}, changed("diagnosis") | {"error": "InputError: no run"}):
        (tmp_path / "a.json").write_text(json.dumps(answer))
        assert read_answer(tmp_path / "a.json") == answer


@pytest.mark.parametrize("text", ["", "[[" * 100_000, "[]", '{"schema": "x"}'])
def test_what_is_no_answer_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(InputError, match=r"a\.json: .*not an answer"):
        read_answer(tmp_path / "a.json")


def test_a_damaged_folder_is_not_opened(
    tmp_path: Path, sealed: tuple[Path, Path], straw: Callable[..., dict[str, Any]]
) -> None:
    answers = tmp_path / "answers"
    diagnose_cases(sealed[0], answers, farm=Processes(1), diagnoser=straw)
    path = answers / "case_0003.json"
    answer = json.loads(path.read_text())
    path.write_text(json.dumps({**answer, "diagnosis": {**answer["diagnosis"], "gap": {}}}))
    with pytest.raises(InputError, match=r"case_0003\.json: diagnosis\.gap\.closed is missing"):
        open_sealed(answers, sealed[1])
    settings = read_settings(answers)
    (answers / "settings.json").write_text(json.dumps({key: settings[key] for key in settings if key != "library"}))
    with pytest.raises(InputError, match=r"settings\.json: library is missing"):
        open_sealed(answers, sealed[1])


@pytest.mark.parametrize("place", ["digest.txt", "case_0002/more.csv", "case_0002/case.json"])
def test_what_never_ends_is_not_read_as_a_case(
    tmp_path: Path, sealed: tuple[Path, Path], straw: Callable[..., dict[str, Any]], place: str
) -> None:
    """Nobody writes into a pipe, and a device gives without end."""
    path = sealed[0] / place
    for make in (os.mkfifo, lambda at: os.symlink("/dev/zero", at)):
        path.unlink(missing_ok=True)
        make(path)
        with pytest.raises(InputError, match=f"{path.name}: is not a regular file; record the cases anew"):
            diagnose_cases(sealed[0], tmp_path / "answers", farm=Processes(1), diagnoser=straw)
    assert not (tmp_path / "answers").exists()


def test_what_never_ends_is_not_read_as_an_answer(tmp_path: Path) -> None:
    for name in ("settings.json", "case_0001.json"):
        os.mkfifo(tmp_path / name)
    with pytest.raises(InputError, match=r"settings\.json: is not a regular file; not a folder of answers"):
        read_settings(tmp_path)
    with pytest.raises(InputError, match=r"case_0001\.json: is not a regular file; not an answer"):
        read_answer(tmp_path / "case_0001.json")
    (tmp_path / "settings.json").unlink()
    (tmp_path / "settings.json").write_text(json.dumps({**SETTINGS, "digest": "0" * 64}))
    with pytest.raises(InputError, match=r"case_0001\.json: is not a regular file; give the key file"):
        open_sealed(tmp_path, tmp_path / "case_0001.json")


def test_a_file_beyond_all_size_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "case_0001.json").write_text(json.dumps(ANSWER))
    monkeypatch.setattr("stribeck.textfile.LARGEST_FILE", 100)
    with pytest.raises(InputError, match=r"case_0001\.json: is too large: found more than"):
        read_answer(tmp_path / "case_0001.json")


@pytest.mark.parametrize(
    ("key", "says"),
    [
        (changed("cases", of=KEY), "cases is missing"),
        (changed("cases", value=[], of=KEY), "cases must be a table: found []"),
        (changed("cases", value={}, of=KEY), "cases must have at least 1 entries"),
        (changed("cases", value={"../a/case_1": TRUTH}, of=KEY), "must be a name like ^case_[0-9]+$"),
        (changed("cases", "case_1", "files", of=KEY), "cases.case_1.files is missing"),
        (changed("cases", "case_1", "known", value="yes", of=KEY), "cases.case_1.known must be true or false"),
        (changed("cases", "case_1", "effects", 0, "strength", value=-1.0, of=KEY), "strength must not be less than 0"),
        (changed("cases", "case_1", "effects", 0, "effect", value="gremlin", of=KEY), "must be an effect of the plant"),
        (
            changed(
                "cases", "case_1", "effects", 0, value={**HIDDEN, "effect": "actuator_lag", "parameters": {}}, of=KEY
            ),
            "must have the parameter time",
        ),
    ],
)
def test_a_damaged_key_is_refused(tmp_path: Path, key: dict[str, Any], says: str) -> None:
    path = tmp_path / "key.json"
    path.write_text(json.dumps(key))
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    (tmp_path / "settings.json").write_text(json.dumps({**SETTINGS, "digest": digest}))
    with pytest.raises(InputError, match=re.escape("key.json: ") + ".*" + re.escape(says)):
        open_sealed(tmp_path, path)


@pytest.mark.parametrize(
    ("note", "says"),
    [
        ({"leave_out": "payload"}, 'leave_out must be an array: found "payload"'),
        ({"leave_out": [1]}, "leave_out[0] must be text"),
        ({}, "leave_out is missing"),
    ],
)
def test_names_to_withhold_are_a_list(note: dict[str, Any], says: str) -> None:
    written = json.dumps({"schema": "stribeck.withheld-case/1", **note}).encode()
    with pytest.raises(InputError, match=re.escape("case.json: ") + ".*" + re.escape(says)):
        left_out_of({"case.json": written})
