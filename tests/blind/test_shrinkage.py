"""True shrinkage: a model with the hidden effect closes the gap on motions it never saw, one without closes nothing."""

import json
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest

import stribeck
from stribeck.arm import EffectEntry, arm_to_toml
from stribeck.blind.key import Opened
from stribeck.blind.shrinkage import closed_on, true_shrinkage
from stribeck.withheld.bench import Bench
from stribeck.withheld.example import nominal_arm, true_arm
from stribeck.withheld.fresh import fresh_runs

EXAMPLE = Path(stribeck.__file__).parent / "example"
BENCH = Bench(200.0, 20, 1e-6, 2.0, 0.8, 0.1, "inertial", 0.005, 3.0, ("multisine",), False, ())
OFFSET = {"effect": "torque_offset", "joint": "A", "parameters": {"offset": 8.0}}
TRUTH = {"seed": 3, "laboratory": asdict(BENCH), "effects": [OFFSET], "disturbances": []}


def corrected(offset: float):
    return replace(true_arm(), effects=(EffectEntry("torque_offset", ("A",), {"A": {"offset": offset}}),))


@pytest.fixture(scope="module")
def runs():
    return fresh_runs(TRUTH, true_arm(), nominal_arm())


def test_fresh_runs_are_the_same_arm_on_another_motion(runs):
    again = fresh_runs(json.loads(json.dumps(TRUTH)), true_arm(), nominal_arm())
    assert [run.q.tobytes() for run in runs] == [run.q.tobytes() for run in again]
    other = fresh_runs({**TRUTH, "seed": 4}, true_arm(), nominal_arm())
    assert not np.allclose(runs[0].q, other[0].q, atol=1e-2)


@pytest.mark.parametrize(("offset", "closes"), [(8.0, 1.0), (4.0, 0.75), (0.0, 0.0)])
def test_what_a_model_closes_is_what_it_explains(runs, offset, closes):
    """Half of an offset leaves half of it: a quarter of its square."""
    assert closed_on(runs, true_arm(), corrected(offset), 10.0) == pytest.approx(closes, abs=0.03)


def test_a_wrong_correction_closes_less_than_nothing(runs):
    closed = closed_on(runs, true_arm(), corrected(-8.0), 10.0)
    assert closed is not None
    assert closed < -1.0


@pytest.mark.parametrize("seed", [3, 4, 7])
def test_without_a_gap_there_is_nothing_to_close(seed):
    """Nor does what is left out at rest, as too fast for the analysis, leave any."""
    quiet = fresh_runs({**TRUTH, "seed": seed, "effects": []}, true_arm(), nominal_arm())
    assert closed_on(quiet, true_arm(), corrected(0.0), 15.0) is None


def test_only_claims_on_drawn_motions_are_judged():
    truth = {**TRUTH, "arm_true": arm_to_toml(true_arm()), "arm_nominal": arm_to_toml(nominal_arm())}
    own = {**truth, "laboratory": {**truth["laboratory"], "kinds": []}}
    claim = {"gap": {"closed": {"value": 0.9}}, "settings": {"cutoff_hz": 10.0}}
    said = {"diagnosis": claim, "retuned": arm_to_toml(true_arm()), "corrected": arm_to_toml(corrected(8.0))}
    silent = {**said, "diagnosis": {**claim, "gap": {"closed": None}}}
    broken = {**said, "corrected": "no arm"}
    opened = Opened(
        "0", {}, {"a": truth, "b": own, "c": truth, "d": truth, "e": truth},
        {"a": said, "b": said, "c": silent, "d": {"error": "x"}, "e": broken},
    )  # fmt: skip
    found = true_shrinkage(opened, jobs=1)
    assert set(found) == {"a", "e"}
    assert found["a"]["claimed"] == 0.9
    assert found["a"]["true"] == pytest.approx(1.0, abs=0.03)
    assert found["e"]["true"] is None
    assert "InputError" in found["e"]["not_judged"]


@pytest.mark.parametrize(("band", "closes"), [({}, None), ({"corner_hz": 2.0}, 1.0)])
def test_a_claim_is_judged_by_the_band_in_which_it_was_made(band, closes):
    """Beside the noise of the upper part of the band a faint gap is next to nothing; below that it shows."""
    faint = {**OFFSET, "parameters": {"offset": 0.1}}
    loud = {**TRUTH["laboratory"], "noise": 3e-5}
    arms = {"arm_true": arm_to_toml(true_arm()), "arm_nominal": arm_to_toml(nominal_arm())}
    claim = {"gap": {"closed": {"value": 0.9}}, "settings": {"cutoff_hz": 15.0, **band}}
    said = {"diagnosis": claim, "retuned": arm_to_toml(true_arm()), "corrected": arm_to_toml(corrected(0.1))}
    opened = Opened("0", {}, {"a": {**TRUTH, **arms, "laboratory": loud, "effects": [faint]}}, {"a": said})
    true = true_shrinkage(opened, jobs=1)["a"]["true"]
    assert true == (closes if closes is None else pytest.approx(closes, abs=0.05))
