"""The analysis as a whole: methods side by side, their trust, and ``limit_cycle.json``."""

from __future__ import annotations

import json
import math
import time
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import pytest

from stribeck.arm import Arm, EffectEntry, Friction, Joint
from stribeck.errors import InputError, StribeckError
from stribeck.loop import analyse as module
from stribeck.loop import surroundings
from stribeck.loop.analyse import analyse_loop
from stribeck.loop.answers import Analysis, JointAnswer
from stribeck.loop.approximate import approximate
from stribeck.loop.beyond import beyond
from stribeck.loop.cycle import Cycle
from stribeck.loop.describing import Compensator, find_roots, linear_part
from stribeck.loop.exact.critical import k_critical
from stribeck.loop.exact.engine import RoundsEngine
from stribeck.loop.files import limit_cycle_json, write_limit_cycle
from stribeck.loop.surroundings import SLOW, SLOW_WINDING, Grid, grid_of, map_of
from stribeck.loop.watched import _too_short, watched
from stribeck.simulate import Compensation, JointLoop, Loop, Reference, simulate_loop

A = Friction(5.0, 1.25, 1.5, 0.05)
COULOMB = Friction(5.0, 0.0, 0.0, 0.05)
METHODS = ["describing_function", "harmonic_balance", "shooting", "simulation"]
KEYS = {
    "verdict", "amplitude", "period", "peak_velocity", "stick_fraction", "multipliers", "stable", "steady_error",
    "k_critical", "kp_max", "methods",
}  # fmt: skip


def arm(friction: Friction = A) -> Arm:
    joint = Joint("A", "revolute", 0.3, 1.0, (0.0, 0.0), 0.5, 0.5, friction, friction)
    return Arm("one joint", (0.0, 0.0), (joint,))


def loop(step: float = 0.0, reference: Reference | None = None, **values: object) -> Loop:
    entry = JointLoop("A", 30.0, reference or Reference("regulate", initial_error=0.2))
    return Loop(step, 20.0, (replace(entry, **values),))  # type: ignore[arg-type]


def answer(friction: Friction, given: Loop, grid: Grid | None = None) -> tuple[Analysis, JointAnswer]:
    found = analyse_loop(arm(friction), given, grid=grid or Grid(wanted=False))
    return found, found.joints[0]


def test_a_coulomb_cycle_by_every_method() -> None:
    """A = (k-1)(C0/Kp) coth(pi zeta / (2 sqrt(1-zeta^2))), T = 2 pi/omega_d, cycles from k = 1 on."""
    zeta = 0.2
    law = Compensation("feedback", 1.3, at_zero="error_sign")
    _, found = answer(COULOMB, loop(kv=2.0 * zeta * math.sqrt(30.0), compensation=law))
    root = math.sqrt(1.0 - zeta**2)
    amplitude = 0.3 * 5.0 / 30.0 / math.tanh(math.pi * zeta / (2.0 * root))
    period = 2.0 * math.pi / (math.sqrt(30.0) * root)
    assert found.notes == ()
    assert found.cycle.verdict == "sliding_cycle"
    assert list(found.methods) == METHODS
    for name, close in zip(METHODS, (0.03, 1e-4, 1e-6, 1e-6), strict=True):
        method = found.methods[name]
        assert method.cycle
        assert method.trusted, method.why
        assert (method.amplitude, method.period) == pytest.approx((amplitude, period), rel=close)
    assert found.methods["describing_function"].amplitude_error == pytest.approx(-0.013, abs=2e-3)
    assert found.k_critical == pytest.approx(1.0, abs=1e-3)
    assert found.margins.damping == pytest.approx(zeta)


@pytest.mark.long
@pytest.mark.parametrize(
    ("effect", "values", "linear"),
    [
        ("torque_dead_zone", {"width": 0.3}, False),
        pytest.param("torque_saturation", {"limit": 20.0}, False, marks=pytest.mark.slow),
        ("joint_flexibility", {"stiffness": 2e3, "damping": 1.0}, True),
    ],
)
def test_an_effect_that_is_taken_for_linear_costs_it_as_well(
    effect: str, values: dict[str, float], linear: bool
) -> None:
    bent = replace(arm(), effects=(EffectEntry(effect, ("A",), {"A": values}),))
    found = analyse_loop(bent, loop(kv=5.0), grid=Grid(wanted=False)).joints[0]
    for name in ("describing_function", "harmonic_balance"):
        assert found.methods[name].trusted == linear
        assert (f"takes the effect {effect} for linear" in found.methods[name].why) != linear
    assert found.margins.stable
    assert any(effect in note for note in found.notes) == (effect == "torque_dead_zone")


def _fails(*_: object) -> None:
    raise StribeckError("the motor is on fire")


@pytest.mark.long
@pytest.mark.parametrize(
    ("kind", "search", "why"),
    [
        ("none", k_critical, "not sought: it is of a compensation of kind feedback"),
        ("feedforward", k_critical, "not sought: it is of a compensation of kind feedback"),
        ("feedback", _fails, "not found: the search failed"),
        ("feedback", lambda *_: None, "none: no ratio makes it cycle"),
        ("feedback", lambda *_: 1.0, ""),
    ],
)
def test_why_there_is_no_critical_ratio(
    monkeypatch: pytest.MonkeyPatch, kind: Literal["none", "feedforward", "feedback"], search: object, why: str
) -> None:
    monkeypatch.setattr(module, "k_critical", search)
    _, found = answer(COULOMB, loop(kv=10.0, compensation=Compensation(kind, 0.9)))
    assert (found.k_critical is None, found.k_why) == (why != "", why)


@pytest.mark.long
def test_damping_costs_the_describing_function_its_trust() -> None:
    law = Compensation("feedback", 1.3, at_zero="error_sign")
    _, found = answer(COULOMB, loop(kv=2.0 * 0.5 * math.sqrt(30.0), compensation=law))
    method = found.methods["describing_function"]
    assert not method.trusted
    assert "damping ratio 0.5" in method.why
    assert (method.amplitude_error, method.period_error) == pytest.approx((-0.0837, -0.134), abs=1e-3)
    assert found.methods["harmonic_balance"].trusted
    exact = 0.05 / math.tanh(math.pi * 0.5 / (2.0 * math.sqrt(0.75)))
    assert found.cycle.amplitude == pytest.approx(exact, rel=1e-5)


@pytest.mark.parametrize(
    ("exact", "says"),
    [
        (Cycle("rest", steady_error=0.0), "the integral would wind up where the joint sticks"),
        (
            Cycle("sliding_cycle", 0.1, 1.0, stick_fraction=0.0),
            "predicts no cycle where there is a sliding cycle; the ",
        ),
        (Cycle("hunting", 0.1, 9.0, stick_fraction=0.9), "the integral winds up while the joint sticks"),
    ],
)
def test_doubts_are_said_in_words_of_what_the_joint_does(exact: Cycle, says: str) -> None:
    method = approximate(arm(), loop(ki=30.0, kv=8.0), "A", exact, 0.7).describing_function
    assert (method.cycle, method.trusted) == (False, False)
    assert says in method.why
    assert "_" not in method.why


@pytest.mark.long
def test_a_joint_with_bristles_is_said_to_have_no_time_stuck() -> None:
    stiff = EffectEntry("presliding", ("A",), {"A": {"stiffness": 2e4, "damping": 60.0}}, "lugre")
    found = analyse_loop(replace(arm(), effects=(stiff,)), loop(0.0125), grid=Grid(wanted=False))
    assert found.joints[0].notes == (module.BRISTLES,)


@pytest.mark.long
def test_a_joint_beside_one_with_bristles_is_not_said_to_have_them() -> None:
    """B, the only joint that the loop controls, is not the arm's first, and A has the bristles."""
    stiff = EffectEntry("presliding", ("A",), {"A": {"stiffness": 2e4, "damping": 60.0}}, "lugre")
    single = arm().joints[0]
    two = Arm("two joints", (0.0, 0.0), (single, replace(single, name="B")), effects=(stiff,))
    given = Loop(0.0125, 20.0, (JointLoop("B", 30.0, Reference("regulate", initial_error=0.2)),))
    found = analyse_loop(two, given, grid=Grid(wanted=False))
    assert found.joints[0].notes == ()


@pytest.mark.slow
def test_hunting_is_missed_by_the_describing_function_and_it_is_said_so() -> None:
    law = Compensation("feedback", 0.9)
    _, found = answer(A, loop(0.0125, ki=30.0, compensation=law))
    assert found.cycle.verdict == "hunting"
    assert found.cycle.amplitude == pytest.approx(0.091, abs=1e-3)
    method = found.methods["describing_function"]
    assert (method.cycle, method.trusted) == (False, False)
    assert "predicts no cycle where there is hunting" in method.why
    seen = found.methods["simulation"]
    assert seen.amplitude == pytest.approx(found.cycle.amplitude, rel=5e-3)


@pytest.mark.slow
def test_a_false_cycle_is_not_trusted_and_rest_is() -> None:
    _, over = answer(A, loop(0.0125, compensation=Compensation("feedback", 1.3)))
    assert over.cycle.verdict == "rest"
    method = over.methods["describing_function"]
    assert (method.cycle, method.trusted) == (True, False)
    assert "predicts a cycle where the exact answer is rest" in method.why
    _, under = answer(A, loop(0.0125))
    assert under.methods["describing_function"].trusted
    assert under.k_critical is None
    assert under.cycle.steady_error is not None
    assert abs(under.cycle.steady_error) <= 6.25 / 30.0


def test_a_ramp_has_no_describing_function_but_a_fold() -> None:
    _, found = answer(A, loop(0.0, Reference("ramp", velocity=0.02), kv=5.0))
    assert found.cycle.verdict == "stick_slip"
    assert found.methods["describing_function"].status == "not_applicable"
    assert found.nyquist is None
    assert found.fold_velocity is not None
    assert found.fold_velocity > 0.02


@pytest.mark.slow
def test_gains_without_a_stable_loop_and_long_delays_are_labelled() -> None:
    _, found = answer(A, loop(0.0125, kp=5000.0))
    assert found.cycle.verdict in ("unbounded", "chatter")
    assert any("no stable loop" in note for note in found.notes)
    assert not found.margins.stable
    assert found.kp_max.stability == pytest.approx(3150.0, rel=1e-3)
    begin, law, far = time.process_time(), Compensation("feedback", 1.3), Reference("regulate", initial_error=0.5)
    _, late = answer(A, loop(0.0125, far, delay_samples=100, compensation=law))
    assert any("the delay, 1.25 s, is longer than the loop's own period, 1.147 s" in note for note in late.notes)
    assert not late.margins.stable
    assert late.methods["shooting"].status == "unbounded"
    _, longest = answer(A, loop(0.0125, far, delay_samples=1000, compensation=law))
    assert longest.cycle.verdict == "unbounded"
    assert (longest.kp_max.stability, longest.locus) == (None, None)
    assert "too many samples" in longest.kp_max.why
    assert time.process_time() - begin < 30.0


def test_json_is_the_contracts(tmp_path: Path) -> None:
    found, _ = answer(A, loop(0.0, kv=5.0, compensation=Compensation("feedback", 1.3, at_zero="error_sign")))
    write_limit_cycle(found, tmp_path)
    content = json.loads((tmp_path / "limit_cycle.json").read_text())
    assert content["schema"] == "stribeck.limit_cycle/1"
    assert content["units"]["amplitude"] == "rad"
    joint = content["joints"]["A"]
    assert set(joint) >= KEYS
    assert set(joint["kp_max"]) >= {"stability", "ms2"}
    assert list(joint["methods"]) == METHODS
    for method in joint["methods"].values():
        assert set(method) >= {"status", "trusted", "why", "amplitude", "period"}
    assert joint["amplitude"] == pytest.approx(0.0821, abs=2e-4)
    assert joint["stable"] is True
    assert joint["kind"] == "revolute"
    assert all(isinstance(root, (float, list)) for root in joint["multipliers"])
    assert joint["kp_max"]["stability"] is None  # continuous and critically damped: no gain is too high
    assert limit_cycle_json(found)["joints"]["A"]["branch"]["setting"] == "k"


def test_a_prismatic_axis_is_in_metres() -> None:
    found, joint = answer(A, loop(0.0, kv=5.0))
    content = limit_cycle_json(replace(found, joints=(replace(joint, kind="prismatic"),)))
    assert content["joints"]["A"]["kind"] == "prismatic"
    here, there = content["units"], limit_cycle_json(found)["units"]
    assert {name: unit for name, unit in here.items() if unit != there[name]} == {
        "amplitude": "m", "peak_velocity": "m/s", "steady_error": "m", "kp_max": "N/m", "kp": "N/m", "kv": "N s/m",
        "inertia": "kg", "fold_velocity": "m/s", "velocity": "m/s",
    }  # fmt: skip


def test_the_branch_and_the_map_hold_this_loop() -> None:
    law = Compensation("feedback", 1.3, at_zero="error_sign")
    _, found = answer(COULOMB, loop(kv=5.0, compensation=law), Grid(5, 4))
    assert found.branch is not None
    i = list(found.branch.values).index(1.3)
    assert found.branch.cycles[i].amplitude == pytest.approx(found.cycle.amplitude, rel=1e-6)
    resting = found.branch.values < 0.99
    assert all(c.verdict == "rest" for c, r in zip(found.branch.cycles, resting, strict=True) if r)
    assert np.isnan(found.branch.predicted[resting]).all()
    assert found.map is not None
    assert found.map.codes.shape == (4, 5)


@pytest.mark.parametrize("text", ["0x0", "61x1", "61", "ax3", "-3x4", "317x316", ""])
def test_an_empty_or_unreadable_grid_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="grid"):
        grid_of(text)
    assert grid_of("none") == Grid(wanted=False)
    assert grid_of("5x4") == Grid(5, 4)


def test_a_reference_that_drives_the_loop_is_refused() -> None:
    with pytest.raises(InputError, match="limit cycle is what a loop does of itself"):
        analyse_loop(arm(), loop(0.0, Reference("sine", amplitude=0.1, frequency=1.0)))


def test_a_record_too_short_for_two_rounds_says_so() -> None:
    given = loop(0.0125, ki=30.0, compensation=Compensation("feedback", 0.9))
    assert isinstance(watched(simulate_loop(arm(), replace(given, duration=6.0)), 0), str)
    assert watched(simulate_loop(arm(), loop(0.0125)), 0) == "rest"


def test_a_cycle_that_shooting_finds_is_seen_in_the_record() -> None:
    """Torques and positions of millionths: a swing of half a microradian is no rest to one of the methods alone."""
    scale = 2e-6
    fine = Friction(scale * A.C0, scale * A.C1, A.C2, scale * A.alpha)
    given = loop(
        0.0125, Reference("regulate", initial_error=0.3 * scale), kv=math.sqrt(30.0),
        compensation=Compensation("feedback", 1.9, at_zero="zero"),
    )  # fmt: skip
    _, found = answer(fine, given)
    shot, seen = found.methods["shooting"], found.methods["simulation"]
    assert shot.cycle
    assert shot.amplitude == pytest.approx(5.5e-7, rel=0.05)
    assert seen.cycle
    assert seen.amplitude == pytest.approx(shot.amplitude, rel=1e-3)


@pytest.mark.parametrize(
    ("error", "says"),
    [
        (np.exp(-np.linspace(0.0, 3.0, 100)), "its error still dies down, from 1 to 0.22 m"),
        (1.0 - np.exp(-np.linspace(0.0, 3.0, 100)), "its error still grows"),
        (np.sin(np.linspace(0.0, 6.0, 100)), "less than two whole periods of its motion are seen"),
    ],
)
def test_what_is_seen_of_less_than_two_rounds_is_said(error: np.ndarray, says: str) -> None:
    assert _too_short(error, "m") == says


@pytest.mark.parametrize(("kp", "told"), [(700.0, True), (60.0, False)])
def test_what_happens_beyond_an_unstable_sinusoid_is_told(kp: float, told: bool) -> None:
    joint, friction = "A", Friction(5.0, 1.25, 1.5, 0.05)
    given = loop(0.0125, kp=kp, delay_samples=1)
    engine = RoundsEngine(arm(friction))
    part = linear_part(engine.arm, given, joint)
    roots = find_roots(part, friction, Compensator(friction, 0.0))
    known = Cycle("rest", basin={"own": "rest", "small": "rest", "large": "rest"})
    found = beyond(engine, given, joint, roots, known)
    lost = "from an error of 893 mrad it grows without bound"
    assert found == (f"{lost}: the describing function has an unstable sinusoid of ±179 mrad" if told else "")


def test_a_swing_that_dies_down_or_grows_is_no_cycle() -> None:
    light = Friction(0.2, 0.05, 0.1, 0.05)
    given = replace(loop(0.001, Reference("regulate", initial_error=1.0), kp=60.0, kv=0.1), duration=5.0)
    dying = watched(simulate_loop(arm(light), given), 0)
    assert isinstance(dying, str)
    assert dying.startswith("its swing still dies down")
    wild = replace(given, joints=(replace(given.joints[0], kv=-1.0),))
    growing = watched(simulate_loop(arm(light), wild), 0)
    assert isinstance(growing, str)
    assert growing.startswith("its swing still grows")


def test_a_map_of_many_slow_cells_is_cut_down(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[dict[str, np.ndarray]] = []

    def label(engine: object, loop: Loop, joint: str, axes: dict[str, np.ndarray], **_: object) -> None:
        asked.append(axes)
        raise InterruptedError

    monkeypatch.setattr(surroundings, "label_map", label)
    engine = RoundsEngine(replace(arm(), gravity=(9.81, 0.0)))  # which the quick kernel cannot take
    for ki, cells in ((0.0, SLOW), (10.0, SLOW_WINDING)):
        with pytest.raises(InterruptedError):
            map_of(engine, loop(0.0, ki=ki), "A", Grid(), None)
        assert len(asked[-1]["kp"]) == cells[1]
        assert max(len(values) for name, values in asked[-1].items() if name != "kp") == cells[0]
