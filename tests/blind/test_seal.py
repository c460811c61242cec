"""Sealed cases: nothing in them tells what is hidden, and only the sealed key opens the score."""

import hashlib
import json
import re
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from stribeck.blind.batch import case_files, case_names, diagnose_cases
from stribeck.blind.farm import Processes
from stribeck.blind.key import open_sealed
from stribeck.errors import InputError
from stribeck.withheld.injections import RULES
from stribeck.withheld.plan import CLASH, LEVELS, Order, plans
from stribeck.withheld.seal import drawn_case, read_digest, record_sealed


def test_the_digest_is_that_of_the_key(sealed):
    cases, key = sealed
    assert read_digest(cases) == hashlib.sha256(key.read_bytes()).hexdigest()


def test_two_keys_of_the_same_cases_have_different_digests(tmp_path, maker):
    """Or whoever guesses the seed could find the answers by trying."""
    order = Order(single=1, effects=("delay",), joints=(1,))
    made = {record_sealed(order, tmp_path / f"c{k}", tmp_path / f"{k}", seed=1, jobs=1, make=maker) for k in range(2)}
    assert len(made) == 2


def test_the_cases_tell_nothing(sealed):
    cases, key = sealed
    truths = json.loads(key.read_text())["cases"]
    for name in case_names(cases):
        files = case_files(cases, name)
        assert sorted(files) == ["arm.toml", "case.json", "run_00.csv"]
        text = b"".join(content for file, content in files.items() if file != "case.json").decode()
        assert not any(re.search(rf"\b{effect}\b", text) for effect in RULES)
        assert json.loads(files["case.json"])["leave_out"] == truths[name]["leave_out"]
    assert {path.name for path in cases.iterdir()} == {*truths, "digest.txt"}


def test_the_order_of_cases_tells_nothing():
    order = Order(single=300, none=100, unknown=60)
    kinds = [plan.kind for plan in plans(order, np.random.default_rng(0))]
    place = {kind: np.mean([i for i, k in enumerate(kinds) if k == kind]) for kind in set(kinds)}
    assert all(abs(mean - 229.5) < 60 for mean in place.values())  # three standard deviations at most
    assert kinds != [plan.kind for plan in plans(order, np.random.default_rng(1))]


@pytest.mark.parametrize("count", [1, 2, 3, 6, 7, 30])
def test_every_effect_meets_every_level(count):
    names = tuple(RULES)[:count]
    made = plans(Order(single=3 * count, effects=names), np.random.default_rng(0))
    assert Counter((plan.effects[0], plan.level) for plan in made) == Counter(
        {(name, level): 1 for name in names for level in LEVELS}
    )


def test_pairs_are_two_effects_that_can_be_in_one_arm():
    made = plans(Order(pairs=400), np.random.default_rng(0))
    assert all(len(set(plan.effects)) == 2 and set(plan.effects) != CLASH for plan in made)


def test_several_are_three_to_five_effects_that_can_be_in_one_arm():
    made = plans(Order(several=300), np.random.default_rng(0))
    assert {plan.kind for plan in made} == {"several"}
    assert Counter(len(set(plan.effects)) for plan in made) == {3: 100, 4: 100, 5: 100}
    assert not any(set(plan.effects) >= CLASH for plan in made)
    assert {(len(plan.effects), plan.level) for plan in made} == {(n, level) for n in (3, 4, 5) for level in LEVELS}


def test_what_is_left_out_hides_among_decoys():
    made = plans(Order(left_out=90), np.random.default_rng(0))
    assert all(plan.effects[0] in plan.leave_out and len(set(plan.leave_out)) == 3 for plan in made)
    places = Counter(plan.leave_out.index(plan.effects[0]) for plan in made)
    assert all(15 < places[k] < 45 for k in range(3))


def test_a_third_of_the_quiet_cases_is_disturbed():
    made = plans(Order(none=9), np.random.default_rng(0))
    assert sum(plan.disturbed for plan in made) == 3


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"effects": ("dely",)}, "no such effect: found dely"),
        ({"levels": ("huge",)}, "no such level: found huge"),
        ({"joints": (5,)}, "1 to 4 joints: found 5"),
        ({"single": 0}, "no cases to record"),
        ({"pairs": 1, "effects": ("delay",)}, "--pairs need two effects"),
        ({"several": 1, "effects": ("delay", "payload")}, "--several need 6 effects to draw from"),
    ],
)
def test_an_order_that_cannot_be_recorded_is_refused(tmp_path, change, says):
    with pytest.raises(InputError, match=re.escape(says)):
        record_sealed(replace(Order(single=1), **change), tmp_path / "cases", tmp_path / "key.json")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("key", "says"), [("cases/key.json", "among the cases"), ("old.json", "key file exists")])
def test_a_key_lies_apart_and_is_never_overwritten(tmp_path, key, says):
    (tmp_path / "old.json").write_text("{}")
    with pytest.raises(InputError, match=says):
        record_sealed(Order(single=1), tmp_path / "cases", tmp_path / key)
    assert [path.name for path in tmp_path.iterdir()] == ["old.json"]


def test_a_key_that_cannot_be_written_is_told_before_the_work(tmp_path):
    def never(seed, plan):
        raise AssertionError("recorded")

    (tmp_path / "file").touch()
    with pytest.raises(InputError, match=r"file.key\.json: cannot be written"):
        record_sealed(Order(single=1), tmp_path / "cases", tmp_path / "file" / "key.json", jobs=1, make=never)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_another_key_does_not_open(tmp_path, sealed, straw):
    cases, key = sealed
    diagnose_cases(cases, tmp_path / "answers", farm=Processes(1), diagnoser=straw)
    changed = json.loads(key.read_text())
    changed["cases"]["case_0001"]["effects"] = []
    (tmp_path / "changed.json").write_text(json.dumps(changed))
    with pytest.raises(InputError, match="is not the key of these cases"):
        open_sealed(tmp_path / "answers", tmp_path / "changed.json")


def test_answers_to_other_recordings_do_not_count(tmp_path, sealed, straw):
    cases, key = sealed
    run = cases / "case_0003" / "run_00.csv"
    run.write_text(run.read_text().replace("\n0,", "\n0.0,", 1))
    diagnose_cases(cases, tmp_path / "answers", farm=Processes(1), diagnoser=straw)
    with pytest.raises(InputError, match=r"case_0003.json: answers another recording"):
        open_sealed(tmp_path / "answers", key)


@pytest.mark.long
def test_the_plant_records_a_sealed_case(tmp_path):
    order = Order(single=1, effects=("delay",), levels=("clear",), joints=(1,))
    record_sealed(order, tmp_path / "cases", tmp_path / "key.json", seed=4, jobs=1, make=drawn_case)
    (truth,) = json.loads((tmp_path / "key.json").read_text())["cases"].values()
    assert truth["effects"][0]["effect"] == "delay"
    assert truth["effects"][0]["strength"] >= truth["effects"][0]["strength_left"] > 0.0
    assert truth["arm_true"] != truth["arm_nominal"]
    runs = [name for name in case_files(tmp_path / "cases", "case_0001") if name.startswith("run_")]
    assert 4 <= len(runs) <= 6
