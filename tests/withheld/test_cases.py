"""Blind cases and the example: repeatable, as strong as they say, and nothing hidden where nothing is hidden."""

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import stribeck
from stribeck.arm import load_arm
from stribeck.errors import StribeckError
from stribeck.run import load_run, save_run
from stribeck.withheld.cases import make_case
from stribeck.withheld.example import EFFECTS, example_runs, nominal_arm, true_arm, write_example
from stribeck.withheld.injections import RULES
from stribeck.withheld.scales import SCALES
from stribeck.withheld.severity import SHARES, severity

SHIPPED = Path(stribeck.__file__).parent / "example"


made = cache(make_case)


@pytest.fixture(scope="module")
def quiet():
    return make_case(1, None, n_joints=1)


@pytest.mark.long
def test_same_seed_same_case(quiet):
    a, b = made(11, "torque_gain", "weak", 1), make_case(11, "torque_gain", "weak", 1)
    assert a.arm_nominal == b.arm_nominal
    assert a.truth == b.truth
    assert all(x.q.tobytes() == y.q.tobytes() for x, y in zip(a.runs, b.runs, strict=True))
    assert quiet.arm_true.joints[0] != a.arm_true.joints[0]


def test_case_with_nothing_hidden_is_worth_nothing(quiet):
    case = quiet
    assert case.truth["effects"] == []
    assert max(case.truth["worth"].values()) < 0.02
    assert 4 <= len(case.runs) <= 6
    assert all(8.0 <= run.duration <= 10.0 for run in case.runs)


@pytest.mark.long
@pytest.mark.parametrize(
    ("effect", "level"),
    [
        ("delay", "clear"),
        ("torque_gain", "weak"),
        pytest.param("cogging", "medium", marks=pytest.mark.slow),
        # what is clear may be made stronger, so that re-tuning leaves enough of it
        pytest.param("load_dependent_friction", "medium", marks=pytest.mark.slow),
    ],
)
def test_effect_is_worth_what_its_level_says(effect, level):
    truth = made(11, effect, level, 1).truth
    joint = truth["effects"][0]["joint"]
    low, high = SHARES[level]
    assert 0.7 * low < truth["worth"][joint] < 1.3 * high


@pytest.mark.long
def test_what_is_clear_is_not_taken_in_by_retuning():
    """A quarter of the torque lies within the tolerance of the last link's mass: 0.4 noise floors would be left."""
    hidden = make_case(22, "payload", "clear", 1).truth["effects"][0]
    assert hidden["strength_left"] > 3.0


@pytest.mark.long
def test_every_effect_has_a_scale_and_truth_is_json():
    assert set(SCALES) == set(RULES)
    case = make_case(5, ("position_dependent_friction", "payload"), "medium", 1)
    assert len(json.loads(json.dumps(case.truth))["effects"]) == 2
    assert case.truth["known"]
    assert not make_case(6, "friction_jumps", n_joints=1).truth["known"]


def test_unknown_level_is_refused():
    with pytest.raises(StribeckError, match="no such effect or level"):
        severity("delay", true_arm(), "A", [], "huge", np.random.default_rng(0))


def test_tendon_needs_two_joints():
    with pytest.raises(StribeckError, match="second joint"):
        make_case(2, "tendon_coupling", n_joints=1)


@pytest.mark.long
def test_negative_damping_is_news_to_the_data_sheet():
    case = make_case(2, "negative_damping", n_joints=1)
    joint = case.truth["effects"][0]["joint"]
    assert {j.name: j.friction.C1 for j in case.arm_nominal.joints}[joint] == 0.0


@pytest.fixture(scope="module")
def recorded():
    return example_runs()


def test_shipped_example_is_what_the_plant_records(recorded):
    """Up to the last digits, in which the mathematical functions of two machines may differ."""
    assert load_arm(SHIPPED / "arm.toml") == nominal_arm()
    for made in recorded:
        shipped = load_run(SHIPPED / f"{made.name}.csv", 2)
        np.testing.assert_allclose(shipped.q, made.q, rtol=0, atol=1e-4)
        assert np.mean(np.abs(shipped.tau - made.tau)) < 1e-2
    truth = json.loads((Path(__file__).parent / "example_truth.json").read_text())
    assert [e["effect"] for e in truth["effects"]] == [e.effect for e in EFFECTS]


def test_example_is_written_byte_for_byte_alike(tmp_path, recorded, monkeypatch):
    monkeypatch.setattr("stribeck.withheld.example.example_runs", lambda effects: recorded)  # once is enough
    folder = tmp_path / "example"
    write_example(folder, tmp_path / "truth.json")
    files = sorted(p.name for p in folder.iterdir())
    assert files == ["arm.toml", *(f"run_{i:02d}.csv" for i in range(6))]
    for run in recorded:
        save_run(run, tmp_path / "again.csv")
        assert (folder / f"{run.name}.csv").read_bytes() == (tmp_path / "again.csv").read_bytes()
    assert sum((folder / f).stat().st_size for f in files) < 3e6
    assert "effects" not in (folder / "arm.toml").read_text()
