"""The score of answers made by hand, whose worth is known."""

import json
import math

import numpy as np
import pytest

from stribeck.blind.comparable import CONVERT, law_for, same_law, true_values
from stribeck.blind.key import Opened
from stribeck.blind.outcome import CHANNELS, outcome, strength_bin
from stribeck.blind.rates import calibration, detection_limit, rate
from stribeck.blind.score import score
from stribeck.effects.registry import laws, registry
from stribeck.withheld.arms import random_arm
from stribeck.withheld.excitation import programme
from stribeck.withheld.injections import KNOWN, UNKNOWN
from stribeck.withheld.scales import SCALES
from stribeck.withheld.stage import stage_of

LIBRARY = ["delay", "actuator_lag", "payload", "input_disturbance", "gravity_tilt", "torque_offset"]


def effect(name="delay", joint="A", strength=4.0, left=None, **parameters):
    recorded = {} if left is None else {"strength_left": left}  # older keys have none
    return {"effect": name, "joint": joint, "strength": strength, **recorded, "parameters": parameters}


def truth(*effects, disturbances=(), known=True):
    return {
        "effects": list(effects), "disturbances": list(disturbances), "level": "clear" if effects else None,
        "known": known,
    }  # fmt: skip


def cause(name, presence=0.9, joints=("A",), equivalent=(), probability=None, **parameters):
    return {
        "effect": name, "joints": list(joints), "presence": presence, "equivalent": [name, *equivalent],
        "probability": presence if probability is None else probability,
        "parameters": {joints[0]: {k: {"value": v[0], "unit": "1", "ci95": v[1]} for k, v in parameters.items()}},
    }  # fmt: skip


def answer(*causes, named=None, verdict=None, where=(), closed=0.9, leave_out=(), none=None):
    names = [c["effect"] for c in causes] if named is None else named
    rest = [{"effect": "none", "probability": none}] if none is not None else []
    left = 1.0 - sum(c["probability"] for c in (*causes, *rest))
    found = {
        "causes": [*causes, *rest, {"effect": "unknown", "probability": left}], "named": names,
        "verdict": verdict or ("explained" if names else "unexplained"),
        "where": [{"joint": j, "channel": c, "share": 0.5} for j, c in where],
        "gap": {"closed": {"value": closed} if names else None},
    }  # fmt: skip
    return {"diagnosis": found, "leave_out": list(leave_out), "seconds": 10.0, "processor_seconds": 9.0, "code": "1"}


def judged(true, said):
    return outcome(true, said, LIBRARY)


def opened(*pairs):
    names = [f"case_{i:04d}" for i in range(len(pairs))]
    truths = {name: true for name, (true, _) in zip(names, pairs, strict=True)}
    answers = {name: said for name, (_, said) in zip(names, pairs, strict=True)}
    return Opened("0" * 64, {"library": LIBRARY, "code": "1"}, truths, answers)


@pytest.mark.parametrize(
    ("said", "first", "in_class", "found", "extra", "column"),
    [
        (answer(cause("delay")), True, True, ["delay"], [], "delay"),
        (answer(cause("actuator_lag", equivalent=("delay",))), False, True, ["delay"], [], "delay"),
        (answer(cause("delay"), cause("payload")), True, True, ["delay"], ["payload"], "delay"),
        (answer(cause("payload"), cause("delay")), False, False, ["delay"], ["payload"], "delay"),
        (answer(cause("payload")), False, False, [], ["payload"], "payload"),
        (answer(cause("delay"), named=[]), False, False, [], [], "unknown"),
        (answer(named=[], verdict="no_gap", none=0.9), False, False, [], [], "none"),
    ],
)
def test_one_effect(said, first, in_class, found, extra, column):
    row = judged(truth(effect()), said)
    assert row["kind"] == "single"
    got = (row["first"], row["class"], row["found"], row["extra"], row["answer"])
    assert got == (first, in_class, found, extra, column)


def test_two_effects():
    pair = truth(effect(strength=4.0), effect("payload", "B", 2.0))
    row = judged(pair, answer(cause("delay"), cause("payload", joints=("B",))))
    assert (row["kind"], row["found"], row["extra"], row["bin"]) == ("pair", ["delay", "payload"], [], "fair")
    row = judged(pair, answer(cause("delay"), cause("actuator_lag")))
    assert (row["found"], row["extra"]) == (["delay"], ["actuator_lag"])


@pytest.mark.parametrize(
    ("said", "found"),
    [
        ([cause("delay", equivalent=("actuator_lag",))], ["delay"]),
        ([cause("actuator_lag", equivalent=("delay",))], ["actuator_lag"]),
        ([cause("torque_offset", equivalent=("delay", "actuator_lag"))], ["delay"]),
        ([cause("delay", equivalent=("actuator_lag",)), cause("actuator_lag")], ["delay", "actuator_lag"]),
        ([cause("delay", equivalent=("actuator_lag",)), cause("torque_offset", equivalent=("delay",))], None),
    ],
)
def test_a_name_stands_for_one_of_two_hidden_effects(said, found):
    row = judged(truth(effect(time=0.01), effect("actuator_lag", "B", time=0.01)), answer(*said))
    assert row["found"] == (found or ["delay", "actuator_lag"])
    assert row["extra"] == []


@pytest.mark.parametrize(
    ("true", "leave_out", "why"),
    [
        (truth(effect("friction_jumps"), known=False), (), "unknown"),
        (truth(effect()), ("delay", "payload"), "left_out"),
        (truth(effect("velocity_filter")), (), "not_held"),
        (truth(effect("input_disturbance", amplitude=0.0, noise=0.1)), (), "not_held"),
    ],
)
def test_outside_the_library_any_name_is_wrong(true, leave_out, why):
    row = judged(true, answer(cause("torque_offset"), leave_out=leave_out))
    assert (row["kind"], row["why"], row["extra"]) == ("outside", why, ["torque_offset"])
    assert judged(true, answer(leave_out=leave_out))["extra"] == []


def test_coloured_noise_may_be_called_a_disturbance():
    noise = effect("input_disturbance", amplitude=0.0, noise=0.1)
    for true in (truth(noise), truth(disturbances=[noise])):
        assert judged(true, answer(cause("input_disturbance")))["extra"] == []
    assert judged(truth(), answer(cause("input_disturbance")))["extra"] == ["input_disturbance"]
    assert judged(truth(effect("input_disturbance", amplitude=0.2)), answer())["kind"] == "single"


def test_place():
    at_a = truth(effect())
    assert judged(at_a, answer(cause("delay")))["joint"] is True
    assert judged(at_a, answer(cause("delay", joints=("B",))))["joint"] is False
    assert judged(at_a, answer(cause("delay", joints=("A", "B"))))["joint"] is False  # blames more than it should
    assert judged(at_a, answer(where=[("A", "unknown")]))["joint"] is True
    assert judged(at_a, answer(where=[("A", "unknown")]))["channel"] is None
    assert judged(at_a, answer(where=[("A", "actuator"), ("B", "friction")]))["channel"] is True
    assert judged(at_a, answer(where=[("A", "friction")]))["channel"] is False
    tilt = truth(effect("gravity_tilt", x=1.0))
    assert judged(tilt, answer(cause("gravity_tilt")))["joint"] is None  # sits in no joint


def test_a_wall_in_the_plane_is_in_no_joint():
    """It pushes at all of them; a stop of one joint is in that joint."""
    plane = truth(effect("contact", stiffness=9.0, position=0.4, direction=0.0))
    stop = truth(effect("contact", stiffness=9.0, position=0.4, side=1.0))
    said = answer(cause("contact", joints=("A", "B")))
    assert outcome(plane, said, [*LIBRARY, "contact"])["joint"] is None
    assert outcome(stop, said, [*LIBRARY, "contact"])["joint"] is False


@pytest.mark.parametrize(
    ("parameters", "law"),
    [({}, "one_pole"), ({"again": 0.01, "damping": 0.0}, "two_poles"), ({"damping": 0.7}, "magnitude_optimum")],
)
def test_a_lag_is_compared_with_the_same_lag(parameters, law):
    for said in ("one_pole", "two_poles", "magnitude_optimum"):
        assert same_law("actuator_lag", {"time": 0.01, **parameters}, said) == (said == law)


def test_a_failure_is_no_silence():
    failed = {"error": "ValueError: x", "leave_out": [], "seconds": 1.0, "processor_seconds": 1.0, "code": "2"}
    result = score(opened((truth(), failed), (truth(effect("friction_jumps"), known=False), failed)), {})
    assert result["none"]["false_alarms"]["value"] == 1.0
    assert result["outside"]["abstained"]["value"] == 0.0


@pytest.mark.parametrize(("parameters", "law"), [
    ({"stiffness": 9.0}, "rocking"), ({"stiffness": 9.0, "direction": 0.0}, "sliding"),
    ({"stiffness": 9.0, "direction": -2.0}, "sliding"),
])  # fmt: skip
def test_a_base_with_a_direction_slides(parameters, law):
    for said in ("rocking", "sliding"):
        assert same_law("base_flexibility", parameters, said) == (said == law)
    assert law_for("base_flexibility", parameters).law == law


@pytest.mark.parametrize("name", sorted(SCALES))
def test_what_the_plant_hides_has_units_in_the_library(name):
    """Of every effect that is drawn, in each of its laws: the values that compare are some law's parameters."""
    arm = random_arm(np.random.default_rng(1), 2)
    motions = programme(arm, np.random.default_rng(0), ("multisine",), 3.0)
    for seed in range(8):
        rng = np.random.default_rng(seed)
        parameters = SCALES[name].build(stage_of(arm, 1, motions, rng))(0.1)
        law = law_for(name, parameters)
        assert (law is None) == (name in UNKNOWN)
        assert law is None or set(true_values(name, parameters)) <= {p.name for p in law.parameters}


def test_intervals_are_judged_in_the_right_joint_only():
    true = truth(effect(time=0.011))
    inside = judged(true, answer(cause("delay", time=(0.0105, [0.010, 0.012]))))["intervals"]
    assert [(row["name"], row["inside"]) for row in inside] == [("time", True)]
    outside = judged(true, answer(cause("delay", time=(0.0145, [0.014, 0.015]))))["intervals"]
    assert [row["inside"] for row in outside] == [False]
    open_end = judged(true, answer(cause("delay", time=(0.0145, [0.010, None]))))["intervals"]
    assert [row["inside"] for row in open_end] == [True]
    assert judged(true, answer(cause("delay", joints=("B",), time=(0.01, [0.0, 1.0]))))["intervals"] == []


def test_a_law_of_another_kind_does_not_count_against_intervals():
    true = truth(effect("presliding", stiffness=100.0))
    said = answer(cause("presliding", stiffness=(70.0, [60.0, 80.0])))
    row = outcome(true, said, [*LIBRARY, "presliding"])
    assert [(item["inside"], item["same_law"]) for item in row["intervals"]] == [(False, False)]
    held = opened((true, said))
    held.settings["library"] = [*LIBRARY, "presliding"]
    result = score(held)["intervals"]
    assert (result["coverage"]["n"], result["parameters"][0]["value"]) == (0, 0.0)


@pytest.mark.parametrize(("name", "shared", "further", "plain", "law"), [
    ("load_dependent_friction", "ratio", "input", "proportional", "directional"),
    ("torque_saturation", "limit", "fade", "constant", "back_emf"),
    ("cable_spring", "stiffness", "cubic", "linear", "hardening"),
    ("position_dependent_friction", "harmonic", "overtone", "one_wave", "harmonics"),
    ("torque_dead_zone", "width", "jump", "shifted", "threshold"),
])  # fmt: skip
@pytest.mark.parametrize("is_further", [False, True])
@pytest.mark.parametrize("said_further", [False, True])
def test_only_the_plants_own_of_two_laws_is_held_to_it(name, shared, further, plain, law, is_further, said_further):
    true = truth(effect(name, **{shared: 0.3, further: float(is_further)}))
    said = cause(name, **{shared: (0.25, [0.24, 0.26])})
    said["law"] = dict.fromkeys(said["parameters"], law if said_further else plain)
    row = outcome(true, answer(said), [*LIBRARY, name])
    assert [(item["inside"], item["same_law"]) for item in row["intervals"]] == [(False, is_further == said_further)]


@pytest.mark.parametrize(
    ("number", "own"), [(0.0, "proportional"), (1.0, "directional"), (2.0, "motor"), (3.0, "weight"), (4.0, "net")]
)
@pytest.mark.parametrize("said", ["proportional", "directional", "motor", "weight", "net"])
def test_of_several_further_laws_each_has_its_number(number, own, said):
    assert same_law("load_dependent_friction", {"ratio": 0.3, "input": number}, said) == (said == own)


def test_statements():
    rows = judged(truth(effect()), answer(cause("delay", 0.8), cause("payload", 0.3, probability=0.1)))["statements"]
    assert rows == [[0.8, True, "delay"], [0.3, False, "payload"], [pytest.approx(0.1), False, "unknown"]]
    assert judged(truth(), answer(none=0.7))["statements"][0] == [0.7, True, "none"]
    left = judged(truth(effect()), answer(leave_out=("delay",)))["statements"]
    assert left == [[1.0, True, "unknown"]]


def test_rates_are_wilson_intervals():
    got = rate([True] * 9 + [False])
    z, n, p = 1.959964, 10, 0.9
    middle, half = p + z**2 / (2 * n), z * math.sqrt(p * (1 - p) / n + z**2 / (4 * n**2))
    expected = [(middle - half) / (1 + z**2 / n), (middle + half) / (1 + z**2 / n)]
    assert (got["k"], got["n"], got["value"]) == (9, 10, 0.9)
    assert got["ci95"] == pytest.approx(expected, abs=1e-4)
    assert rate([]) == {"k": 0, "n": 0, "value": None, "ci95": None}


def test_calibration_error_of_known_size():
    stated = [(0.95, True)] * 15 + [(0.95, False)] * 5 + [(0.25, True)] * 5 + [(0.25, False)] * 15
    got = calibration(stated)
    assert got["ece"] == pytest.approx(0.5 * (0.95 - 0.75))
    assert [(b["stated"], b["held"]["value"]) for b in got["bins"]] == [(0.25, 0.25), (0.95, 0.75)]
    assert got["ci95"][0] < got["ece"] < got["ci95"][1]
    assert calibration([(1.0, True)])["ece"] == 0.0


def test_calibration_error_by_chance_is_what_true_probabilities_show():
    rng = np.random.default_rng(0)
    p = rng.random(200)
    errors = [calibration([(x, rng.random() < x) for x in p], seed=k)["ece"] for k in range(20)]
    assert calibration([(x, True) for x in p])["ece_by_chance"] == pytest.approx(np.mean(errors), rel=0.2)


def test_detection_limit_of_a_known_curve():
    rng = np.random.default_rng(1)
    strengths = np.geomspace(0.2, 20.0, 120)
    found = rng.random(120) < 1.0 / (1.0 + (2.0 / strengths) ** 4)
    got = detection_limit(strengths, found)
    assert got is not None
    assert got["ci95"][0] < 2.0 < got["ci95"][1]
    assert got["strength"] == pytest.approx(2.0, rel=0.35)
    assert got["outside"] is None


def test_a_case_without_strength_says_nothing_of_a_limit():
    strengths, found = [0.5, 1.0, 2.0, 4.0, 8.0], [False, False, True, True, True]
    assert detection_limit([*strengths, 0.0, 0.0], [*found, True, False]) == detection_limit(strengths, found)
    assert detection_limit([0.0] * 8, [True] * 8) is None


@pytest.mark.parametrize(("found", "outside", "at"), [(True, "below", 0.5), (False, "above", 8.0)])
def test_a_limit_beyond_what_was_tried_is_said(found, outside, at):
    got = detection_limit([0.5, 1.0, 2.0, 4.0, 8.0], [found] * 5)
    assert got is not None
    assert (got["outside"], got["strength"]) == (outside, at)
    assert detection_limit([1.0], [True]) is None


def test_strength_bins():
    assert [strength_bin(s) for s in (3.0, 2.99, 1.0, 0.99, 0.0)] == ["strong", "fair", "fair", "faint", "faint"]


def test_the_whole_score():
    result = score(
        opened(
            (truth(effect(time=0.01)), answer(cause("delay", time=(0.01, [0.009, 0.011])), where=[("A", "actuator")])),
            (truth(effect(time=0.01)), answer(cause("payload"), where=[("B", "rigid_body")])),
            (truth(effect("payload", "B", 2.0)), answer()),
            (
                truth(effect("payload", "B", 0.5)),
                {"error": "ValueError: x", "leave_out": [], "seconds": 30.0, "processor_seconds": 9.0, "code": "2"},
            ),
            (truth(), answer(none=0.9, verdict="no_gap")),
            (truth(), answer(cause("delay"))),
            (truth(effect("friction_jumps"), known=False), answer()),
            (truth(effect()), answer(cause("actuator_lag"), leave_out=("delay",))),
            (truth(effect(), effect("payload", "B")), answer(cause("delay"), cause("payload", joints=("B",)))),
        ),
        {"case_0000": {"claimed": 0.9, "true": 0.86}, "case_0001": {"claimed": 0.9, "true": 0.5}},
    )
    json.dumps(result, allow_nan=False)
    single = result["single"]
    assert (single["all"]["named"]["k"], single["all"]["named"]["n"]) == (1, 4)
    assert (single["strong"]["named"]["k"], single["strong"]["named"]["n"]) == (1, 2)
    assert single["all"]["wrong_name"]["k"] == 1
    assert (single["all"]["class_size"], single["faint"]["class_size"], result["sources"]) == (1.0, None, 2)
    assert (single["fair"]["abstained"]["value"], single["faint"]["abstained"]["value"]) == (1.0, 1.0)
    assert (result["failed"]["k"], result["cases"]) == (1, 9)
    assert (result["none"]["false_alarms"]["k"], result["none"]["no_gap"]["k"]) == (1, 1)
    assert (result["outside"]["abstained"]["k"], result["outside"]["left_out"]["k"]) == (1, 0)
    assert result["outside"]["effects"]["friction_jumps"]["value"] == 1.0
    assert result["pairs"]["all"]["both"]["value"] == 1.0
    assert result["intervals"]["coverage"]["value"] == 1.0
    assert result["shrinkage"]["within_5_points"]["value"] == 0.5
    assert result["shrinkage"]["median_true"] == pytest.approx(0.68)
    assert result["shrinkage"]["bias"] == pytest.approx(0.22)  # more is claimed than is true
    assert single["all"]["channel"] == {**single["all"]["channel"], "k": 1, "n": 2}
    table = result["confusion"]
    assert table["hidden"] == ["delay", "friction_jumps", "payload", "left_out", "none"]
    assert table["said"] == ["actuator_lag", "delay", "payload", "none", "unknown", "failed"]
    assert table["counts"] == [
        [0, 1, 1, 0, 0, 0], [0, 0, 0, 0, 1, 0], [0, 0, 0, 0, 1, 1], [1, 0, 0, 0, 0, 0], [0, 1, 0, 1, 0, 0],
    ]  # fmt: skip
    held = {line["what"]: line["holds"] for line in result["targets"]}
    assert held["named, strength 3 and more"] is False
    assert held["both of a pair named"] is True
    line = next(line for line in result["targets"] if line["what"] == "wrong name, of all single effects")
    assert (line["k"], line["n"]) == (single["all"]["wrong_name"]["k"], single["all"]["wrong_name"]["n"])
    assert "n" not in next(line for line in result["targets"] if line["what"] == "calibration error")


def test_of_several_effects_each_is_counted_and_each_name():
    hidden = truth(
        effect("delay", left=5.0),
        effect("payload", left=2.0),
        effect("torque_offset", left=0.0),
        effect("gravity_tilt"),
    )
    said = answer(cause("delay"), cause("torque_offset"), cause("actuator_lag"))
    silent = answer(named=[], verdict="unexplained", none=0.0)
    found = score(opened((hidden, said), (hidden, silent), (truth(effect()), said)))["several"]
    counts = {name: (shown["k"], shown["n"]) for name, shown in found.items()}
    assert counts == {
        "found": (2, 8), "strong": (1, 2), "fair": (0, 2), "faint": (1, 2),  # one without a strength
        "wrong": (1, 3), "wrong_name": (1, 2), "none_named": (1, 2),
    }  # fmt: skip


def test_what_is_named_is_counted_again_by_what_re_tuning_leaves():
    said = answer(cause("delay"))
    cases = [
        (truth(effect(strength=4.0, left=3.5)), said),
        (truth(effect("payload", strength=5.0, left=0.2)), answer(named=[], verdict="no_gap", none=0.9)),
        (truth(effect(left=2.0), effect("payload", strength=2.0, left=0.4)), said),
        (truth(), answer(named=[], verdict="no_gap", none=0.9)),
    ]
    result = score(opened(*cases))
    assert (result["single"]["strong"]["named"]["k"], result["single"]["strong"]["named"]["n"]) == (1, 2)
    assert result["single_left"]["strong"]["named"]["value"] == 1.0
    assert result["single_left"]["faint"]["named"] == {**result["single_left"]["faint"]["named"], "k": 0, "n": 1}
    assert result["single_levels"]["clear"]["named"]["n"] == 2
    assert result["pairs_left"]["faint"]["at_least_one"]["n"] == 1
    assert [row["bin_left"] for row in result["rows"]] == ["strong", "faint", "faint", None]
    older = score(opened(*cases, (truth(effect()), said)))
    assert (older["single_left"], older["effects"]["delay"]["detection_limit_left"]) == (None, None)
    assert older["pairs_left"] is not None


def test_limits_are_told_by_strength_and_by_what_is_left():
    sizes = [0.5, 1.0, 2.0, 4.0, 8.0]
    cases = [(truth(effect(strength=s, left=0.5 * s)), answer(*[cause("delay")] * (s > 1.5))) for s in sizes]
    found = score(opened(*cases))["effects"]["delay"]
    plain, left = (found[key]["strength"] for key in ("detection_limit", "detection_limit_left"))
    assert left == pytest.approx(0.5 * plain, rel=0.05)


def test_every_effect_of_the_plant_has_a_channel_that_the_library_agrees_with():
    assert set(CHANNELS) == set(KNOWN)
    assert all(CHANNELS[name] == known.channel for name, known in registry().items() if name in CHANNELS)


@pytest.mark.parametrize("name", sorted(CONVERT))
def test_comparable_parameters_are_the_library_s(name):
    given = dict.fromkeys(KNOWN[name].parameters, 0.5) | {"C1": 0.0}
    values = true_values(name, given)
    assert values
    assert set(values) <= {
        parameter.name for key, law in laws().items() if key[0] == name for parameter in law.parameters
    }


def test_a_wave_by_size_and_phase_is_one_by_sine_and_cosine():
    q = np.linspace(0.0, 6.0, 50)
    got = true_values("cogging", {"amplitude": 0.7, "harmonic": 4.0, "phase": 0.9})
    wave = got["sine"] * np.sin(4.0 * q) + got["cosine"] * np.cos(4.0 * q)
    assert wave == pytest.approx(0.7 * np.sin(4.0 * q + 0.9))
    assert true_values("history", {"change": 0.1}) == {}


def test_parameters_are_converted_by_their_numbers():
    assert true_values("asymmetric_friction", {"C0": 0.8, "C1": 0.0, "C2": 0.2}) == {"coulomb": 0.4, "viscous": 0.1}
    assert true_values("actuator_lag", {"time": 0.006, "again": 0.004})["time_constant"] == pytest.approx(0.01)
