"""How the method was chosen, and what other tools say: the rules on made-up residuals, the studies on a few cases."""

import importlib
import json
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter

BLOCKS, ROWS = 40, 60  # a quarter of the blocks is held out
RHO = 0.98  # of neighbouring rows of a coloured residual


def made_up_fits(rng, rho=0.0, amount=0.0):
    """Return the fits of one true rival, one that is noise, and none, to a residual of known colour."""
    from _decision_fits import score_test

    rows = BLOCKS * ROWS
    noise = lfilter([np.sqrt(1.0 - rho**2)], [1.0, -rho], rng.standard_normal(rows + 500))[500:]
    true, other = (lfilter([1.0], [1.0, -rho], rng.standard_normal(rows + 500))[500:] for _ in range(2))
    true, other = true / true.std(), other / other.std()
    residual = noise + amount * true
    block = np.repeat(np.arange(BLOCKS), ROWS)
    held = block >= BLOCKS * 3 // 4
    left = [residual, *(residual - c * (residual @ (c * ~held)) / (c @ (c * ~held)) for c in (true, other))]

    def sums(mask):
        kept = [np.add.reduceat(r[mask] ** 2, np.arange(0, mask.sum(), ROWS))[:, None].tolist() for r in left]
        correlation = [[1.0 + 2.0 * rho / (1.0 - rho)]] * 3
        both = {"torque": kept, "torque_correlation": correlation, "motion": kept, "motion_correlation": correlation}
        return {"rows": [ROWS] * int(mask.sum() // ROWS), **both}

    score = [score_test(c[~held, None], residual[~held], block[~held]) for c in (true, other)]
    return {
        "rivals": [["delay", "A"], ["payload", "A"]], "own": [0, 1, 1], "prior": [0.0] * 3, "candidates": 2,
        "twins": [[1], [2]], "score": score, "fit": sums(~held), "held": sums(held),
    }  # fmt: skip


def share_named(rule, rho, amount=0.0, draws=40):
    from _decision_rules import RULES

    names = [RULES[rule](made_up_fits(np.random.default_rng(seed), rho, amount), "torque") for seed in range(draws)]
    return np.mean(np.array(names) == 1), np.mean(np.array(names) != 0)


@pytest.mark.parametrize("rule", ["BIC", "likelihood ratio", "block score", "held-out gain", "stacking"])
def test_every_rule_names_what_is_plain_and_is_quiet_in_white_noise(rule):
    right, _ = share_named(rule, 0.0, 0.5, 20)
    assert right == 1.0
    _, spoken = share_named(rule, 0.0)
    if rule == "stacking":  # models that predict alike share the weight by chance: it is no probability
        assert spoken > 0.3
    else:
        assert spoken < 0.1


@pytest.mark.parametrize(("rule", "least", "most"), [
    ("BIC", 0.7, 1.0), ("likelihood ratio", 0.85, 1.0), ("block score", 0.0, 0.3), ("held-out gain", 0.0, 0.1),
])  # fmt: skip
def test_coloured_residuals_fool_the_rules_that_take_them_for_white(rule, least, most):
    _, spoken = share_named(rule, RHO)
    assert least <= spoken <= most


def test_stacking_gives_the_better_model_all_and_equals_the_same():
    from _decision_rules import stacking_weights

    rng = np.random.default_rng(0)
    density = rng.standard_normal((2, 30))
    density[1] = density[0] - 1.0
    assert stacking_weights(density) == pytest.approx([1.0, 0.0], abs=1e-3)
    assert stacking_weights(np.zeros((4, 30))) == pytest.approx([0.25] * 4)
    half = np.where(np.arange(30) % 2, 1.0, -1.0)  # each is the better one in every other block
    assert stacking_weights(np.stack([half, -half])) == pytest.approx([0.5, 0.5], abs=1e-6)


def test_both_residuals_count_as_channels_and_motion_has_no_score():
    from _decision_rules import RULES, seen

    fits = made_up_fits(np.random.default_rng(3))
    assert seen(fits, "both").fit.shape == (3, BLOCKS * 3 // 4, 2)
    assert seen(fits, "torque").held.shape == (3, BLOCKS // 4, 1)
    with pytest.raises(ValueError, match="no score"):
        RULES["block score"](fits, "motion")


def test_the_rival_preferred_among_those_above_the_threshold_is_named():
    from _decision_rules import Evidence

    evidence = Evidence(np.array([3.0, 1.0, np.nan]), np.array([0.1, 0.9, 2.0]))
    assert [evidence.named(threshold) for threshold in (0.0, 2.0, 3.0)] == [2, 1, 0]


def test_rare_is_told_from_rarer_beyond_the_smallest_number():
    from _decision_rules import rarity
    from scipy.stats import chi2

    for degrees in np.array([[1.0], [2.0], [3.0], [5.0]]):
        near = np.array([3.0, 499.0, 501.0, 900.0, 1300.0])  # where scipy still has digits
        assert rarity(near, degrees) == pytest.approx(-chi2.logsf(near, degrees), abs=2e-4)
        far = rarity(np.array([1e4, 2e4, 1e6]), degrees)
        assert np.all(np.isfinite(far))
        assert np.all(np.diff(far) > 4e3)


@pytest.mark.long
def test_the_table_counts_names_against_the_key():
    from _decision_fits import diagnosis_of
    from _decision_table import table

    from stribeck.blind.key import Opened

    effect = {"effect": "delay", "joint": "A", "parameters": {}, "strength": 4.0}
    common = {"level": "clear", "disturbances": [], "known": True}
    truths = {"a": {**common, "effects": [effect]}, "b": {**common, "effects": []}}
    spent = {"seconds": 1.0, "processor_seconds": 1.0, "leave_out": []}
    answers = {
        "a": {**spent, "diagnosis": diagnosis_of([("delay", "A", ["delay"])]),
              "fits": made_up_fits(np.random.default_rng(1), 0.0, 0.5)},
        "b": {**spent, "diagnosis": diagnosis_of([]), "fits": made_up_fits(np.random.default_rng(2), RHO)},
    }  # fmt: skip
    result = table(Opened("0" * 64, {"library": ["delay", "payload"]}, truths, answers))
    rows = {(row["rule"], row["domain"]): row for row in result["methods"]}
    assert len(rows) == 5 * 3 - 2 + 2
    assert all(row["class"]["k"] == 1 for row in rows.values())
    assert rows["shipped", "torque"]["false_alarm"]["k"] == 0
    fooled = rows["likelihood ratio", "torque"]
    assert (fooled["false_alarm"]["k"], fooled["false_alarm"]["n"]) == (1, 1)
    assert (fooled["wrong"]["k"], fooled["wrong"]["n"]) == (1, 2)
    best = rows["held-out gain", "torque"]["in_hindsight"]
    assert (best["right"]["k"], best["wrong"]["k"]) == (1, 0)
    curve = np.array(fooled["curve"])
    assert (curve[0, 1:] == 1).all()
    assert (curve[-1, 1:] == 0).all()  # strict enough, it says nothing
    assert (np.diff(curve, axis=0)[:, 0] > 0.0).all()
    assert (np.diff(curve, axis=0)[:, 1:] <= 0.0).all()


def said(*named, alike=(), friction=(), seconds=1.0):
    return {"named": list(named), "confidence": 0.9, "friction": list(friction), "says": "", "ended": "",
            "alike": list(alike), "seconds": seconds}  # fmt: skip


def test_the_likeliest_name_counts_with_what_the_method_itself_calls_as_likely():
    from _side_by_side import METHODS, table

    from stribeck.arm import Arm, Friction, Joint, arm_to_toml
    from stribeck.blind.key import Opened

    friction = Friction(5.0, 0.0, 2.0, 0.05)
    arm = Arm("one joint", (0.0, 0.0), (Joint("A", "revolute", 0.3, 1.0, (0.0, 0.0), 0.5, 0.5, friction, friction),))
    common = {"level": "clear", "disturbances": [], "known": True, "arm_true": arm_to_toml(arm)}
    values = {"C0": 1.0, "C1": 0.0, "C2": 0.0}
    hidden = {"effect": "asymmetric_friction", "joint": "A", "parameters": values, "strength": 4.0}
    truths = {"a": {**common, "effects": [hidden]}, "b": {**common, "effects": []}}
    row = {"joint": "A", "constant": "C0", "value": 4.0, "low": 2.0, "high": 6.0}
    offset, right = ("torque_offset", "A"), ("asymmetric_friction", "A")
    by_case = {
        "a": [said(offset, alike=["asymmetric_friction"], friction=[row]), said(), said(offset), said(right)],
        "b": [said(), said(), said(offset), {"error": "broken", "seconds": 2.0}],
    }
    spent = {"seconds": 1.0, "processor_seconds": 1.0, "leave_out": []}
    methods = {name: dict(zip(METHODS, [*own, *own], strict=True)) for name, own in by_case.items()}
    answers = {name: {**spent, "methods": own} for name, own in methods.items()}
    result = table(Opened("0" * 64, {"library": ["asymmetric_friction", "torque_offset"]}, truths, answers))
    classes, silent, wrong, broken = result["methods"][:4]
    kept = ("right", "exact", "wrong", "silent")
    counted = [[found[key]["k"] for key in kept] for found in (classes, silent, wrong)]
    assert counted == [[1, 0, 0, 1], [0, 0, 0, 1], [0, 0, 1, 0]]
    assert all(classes[key]["n"] == 1 for key in kept)
    assert classes["friction_error"] == {"C0": pytest.approx(0.2), "C2": None}
    assert (classes["friction_held"]["k"], classes["friction_held"]["n"]) == (1, 1)
    assert (broken["failed"], broken["exact"]["k"], broken["silent"]["n"]) == (1, 1, 0)


def test_the_clock_knows_when_what_was_said_first():
    from _side_by_side import _Clock

    clock = _Clock()
    clock.notes = [("re-tuning", 1.0), ("screening 30", 2.0), ("fitting 4", 3.0), ("screening 29", 4.0)]
    assert (clock.at("screening"), clock.at("screening", 2)) == (2.0, 4.0)
    assert clock.at("screening", 3) < 1.0  # not said: it is now


def test_coordinates_of_a_fit_of_all_effects_have_the_slopes_of_their_values():
    from _rival_least_squares import Unknowns

    kind = np.array(["plain", "inverse", "log"])
    x = Unknowns(kind, *(np.array(part) for part in (
        [1.0, 0.01, 0.0], [2.0, 0.1, 1.0], [0.0] * 3, [9.0] * 3, [0.0] * 3, [False] * 3, [0.0, 0.0, np.nan],
    )))  # fmt: skip
    z = x.start / x.unit
    value, slope = x.physical(z)
    assert value == pytest.approx([1.0, 100.0, 1.0])
    moved, _ = x.physical(z + 1e-7)
    assert (moved - value) / 1e-7 == pytest.approx(slope, rel=1e-4)


def test_what_the_data_say_nothing_about_is_not_certain():
    from _rival_least_squares import deviations

    jacobian = np.array([[1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]])
    assert deviations(jacobian)[[0, 2]] == pytest.approx([0.5, 0.5])
    assert deviations(jacobian)[1] > 1e6


def few(study, tmp_path: Path, **options):
    importlib.import_module(study).main(**options)
    folder = tmp_path / "out" / study
    assert [path.read_bytes()[:4] for path in folder.glob("*.png")] == [b"\x89PNG"]
    return json.loads((folder / "result.json").read_text(encoding="utf-8"))


FEW = {"effects": "delay", "levels": "clear", "library": "delay,torque_offset,payload"}


@pytest.mark.slow
def test_decision_rules(tmp_path: Path):
    """A plain delay is named by the shipped rule and by BIC; the shipped one is silent where there is nothing."""
    result = few("decision_rules", tmp_path, single=1, none=1, unknown=0, left_out=0, seed=11, **FEW)
    rows = {(row["rule"], row["domain"]): row for row in result["methods"]}
    assert result["failed"] == 0
    assert rows["shipped", "torque"]["class"]["k"] == 1
    assert rows["shipped", "torque"]["wrong"]["k"] == 0
    assert rows["BIC", "torque"]["class"]["k"] == 1


@pytest.mark.slow
def test_side_by_side(tmp_path: Path):
    """All methods answer; MuJoCo names nothing as its examples use it; a fit of everything is no worse than of none."""
    for tool in ("mujoco", "pysindy", "petab_select"):
        pytest.importorskip(tool, reason=f"{tool} is not installed: the study compares with it")
    result = few("side_by_side", tmp_path, single=1, none=0, seed=11, **FEW)
    rows = {row["method"]: row for row in result["methods"]}
    assert all(row["failed"] == 0 for row in rows.values())
    assert rows["stribeck"]["right"]["k"] == 1
    assert rows["MuJoCo sysid"]["names"] == 0
    (words,) = rows["least squares, all effects"]["says"]
    assert float(words.split(", ")[-1].partition("%")[0]) <= 105.0
    assert all(row["seconds"] > 0.0 for row in rows.values())


def test_side_by_side_says_what_is_missing(capsys, monkeypatch):
    import typer

    study = importlib.import_module("side_by_side")
    monkeypatch.setattr(study, "TOOLS", ("no_such_tool",))
    with pytest.raises(typer.Exit):
        study.main()
    assert "no_such_tool not installed" in capsys.readouterr().out
