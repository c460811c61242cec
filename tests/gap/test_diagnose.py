"""Whole diagnoses of a pendulum that the independent plant recorded: named right, abstaining, repeatable."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from stribeck.arm import Arm, EffectEntry, load_arm, save_arm
from stribeck.effects.registry import registry
from stribeck.errors import InputError
from stribeck.gap.answer import assembly
from stribeck.gap.answer import verdict as verdict_module
from stribeck.gap.answer.verdict import causes_of
from stribeck.gap.diagnose import diagnose
from stribeck.gap.result import VERDICTS, Cause, Diagnosis
from stribeck.gap.search.step import Step
from stribeck.run import Run

from .conftest import NOMINAL, TRUE, recorded, sines

LATE = ("delay", {"time": 0.02})
ALIKE = ("delay", "time_shift", "actuator_lag")
SLOW = (  # to fit
    "backlash", "base_flexibility", "contact", "dwell_time", "encoder_eccentricity", "frictional_lag", "history",
    "joint_flexibility", "presliding",
)  # fmt: skip

FEW = tuple(name for name in registry() if name not in ("delay", "payload", "torque_gain"))  # left out: it is quicker


def found(*hidden: tuple[str, Mapping[str, float]], leave_out: Sequence[str] = (), seed: int = 0) -> Diagnosis:
    return diagnose(NOMINAL, recorded(*[(n, dict(v)) for n, v in hidden]), jobs=1, leave_out=leave_out, seed=seed)


@cache
def late() -> Diagnosis:
    return found(LATE, leave_out=SLOW)


@cache
def nothing() -> Diagnosis:
    return found(leave_out=SLOW)


@cache
def late_among_few() -> Diagnosis:
    return found(LATE, leave_out=FEW)


@cache
def without_its_cause() -> Diagnosis:
    """A drive that is late, and no candidate that could say so."""
    return found(LATE, leave_out=(*ALIKE, *SLOW))


ALL = [late, nothing, without_its_cause]


@pytest.mark.long
def test_values_are_told_as_they_are_delivered() -> None:
    """Beside the named effect; what re-tuning alone makes of them stands in for it."""
    d, joint = late(), NOMINAL.names[0]
    told = {value.key: value for value in d.corrected}
    assert set(told) == {value.key for value in d.tuned}
    written, true = (arm.joints[0].friction.C2 for arm in (d.models["corrected"], TRUE))
    last, before = (values[f"{joint}.friction.C2"].tuned for values in (told, {v.key: v for v in d.tuned}))
    assert last.value == pytest.approx(written)
    assert last.low < true < last.high
    assert abs(before.value - true) > abs(last.value - true)
    assert nothing().corrected == ()


def test_effect_is_named() -> None:
    d = late()
    assert d.verdict == "explained"
    assert d.named == ("delay",)
    (cause,) = [cause for cause in d.causes if cause.effect == "delay"]
    assert cause.joints == ("A",)
    assert cause.presence is not None
    assert cause.presence > 0.9
    assert "delay" in cause.equivalent
    time = cause.parameters["A"]["time"]
    assert time.low <= 0.02 * 1.02
    assert time.high >= 0.02 * 0.98
    assert time.high - time.low < 0.004
    assert time.unit == "s"
    assert d.closed is not None
    assert d.closed.value > 0.9
    assert d.closed.low <= d.closed.value
    assert d.where[0].channel == "actuator"
    assert [c.effect for c in d.candidates if c.chosen] == ["delay"]


def as_they_come(runs: Sequence[Run]) -> list[Run]:
    """The same recordings from a careless log: rows twice, stamped late since 1970, turns begun anew, a wrong one."""
    out, rng = [], np.random.default_rng(0)
    for k, run in enumerate(runs):
        rows = np.repeat(np.arange(len(run.t)), 2)
        step = 0.5 * run.sample_time
        t = 1764201234.0 + 20.0 * k + step * (np.arange(len(rows)) + rng.uniform(0.0, 0.4, len(rows)))
        q = (run.q[rows] + 2.0 * np.pi) % (2.0 * np.pi)
        q[1000:1002] = 6.0
        out.append(replace(run, t=t, q=q, tau=run.tau[rows]))
    return out


@pytest.mark.long
@pytest.mark.parametrize("a_turn", [20.0, 101.0])
def test_friction_that_goes_with_the_fast_side_of_a_gear_is_named(a_turn: float) -> None:
    """As often a turn as the motor turns, or the balls of its bearings pass."""
    diagnosis = found(("position_dependent_friction", {"amplitude": 1.0, "harmonic": a_turn, "phase": 0.7}))
    assert diagnosis.named == ("position_dependent_friction",)
    (values,) = diagnosis.causes[0].parameters.values()
    assert values["harmonic"].value == pytest.approx(a_turn, rel=2e-3)
    assert np.hypot(values["sine"].value, values["cosine"].value) == pytest.approx(1.0 / 4.6, rel=0.1)


@pytest.mark.long
def test_each_of_several_effects_is_named() -> None:
    """As worn arms have them: each is believed once the others are there, for what they leave speaks against it."""
    hidden = (
        ("delay", {"time": 0.012}),
        ("cogging", {"amplitude": 1.0, "harmonic": 12.0, "phase": 0.3}),
        ("quadratic_damping", {"coefficient": 0.8}),
        ("load_dependent_friction", {"ratio": 0.15}),
    )
    diagnosis = found(*hidden, leave_out=SLOW)
    assert sorted(diagnosis.named) == sorted(name for name, _ in hidden)
    assert diagnosis.verdict == "explained"


@pytest.mark.long
def test_logs_may_come_as_they_are() -> None:
    dirty = as_they_come(recorded((LATE[0], dict(LATE[1]))))
    told = diagnose(NOMINAL, dirty, jobs=1, leave_out=FEW)
    assert told.named == ("delay",)
    time, true = (d.causes[0].parameters["A"]["time"].value for d in (told, late_among_few()))
    assert time == pytest.approx(true, abs=0.05 * 0.004)
    said = " ".join(told.notes)
    for what in ("begins anew", "taken from rows around", "counted from 1764000000 s", "ms apart, which makes"):
        assert what in said
    every = ", ".join(run.name for run in dirty)
    assert sum(note.startswith(f"{every}: positions are new in every second row") for note in told.notes) == 1


def test_corrected_arm_carries_the_effect(tmp_path) -> None:  # type: ignore[no-untyped-def]
    """The corrected model is an arm like any other: written, read, and diagnosed with no gap left to name."""
    arm = late().models["corrected"]
    assert arm.effects[0].effect == "delay"
    assert arm.effects[0].parameters["A"]["time"] == pytest.approx(0.02, rel=0.03)
    save_arm(arm, tmp_path / "corrected.toml")
    again = diagnose(load_arm(tmp_path / "corrected.toml"), recorded(LATE), jobs=1, leave_out=FEW)
    assert again.named == ()
    assert again.verdict == "no_gap"


@pytest.mark.slow
def test_what_is_said_of_a_named_effect_is_what_is_written(monkeypatch: pytest.MonkeyPatch) -> None:
    """An effect that was taken but is not believed is not in the corrected arm; so it must not bend what is told."""
    other = ("torque_offset", {"offset": 1.0})

    def doubted(steps: Sequence[Step], *others: Any) -> tuple[list[Cause], float]:
        causes, left_over = causes_of(steps, *others)
        return [replace(c, presence=0.3) if c.effect == other[0] else c for c in causes], left_over

    monkeypatch.setattr(assembly, "causes_of", doubted)
    few = [name for name in FEW if name not in (*ALIKE, other[0])]
    d = diagnose(NOMINAL, recorded(LATE, other), jobs=1, leave_out=[*few, "payload", "torque_gain", "time_shift"])
    assert {cause.effect for cause in d.causes} >= {"delay", other[0]}
    (named,) = (cause for cause in d.causes if cause.effect in d.named)
    (entry,) = d.models["corrected"].effects
    assert entry.effect == named.effect
    told = {name: value.value for name, value in named.parameters["A"].items()}
    assert told == pytest.approx(dict(entry.parameters["A"]))
    assert d.closed is not None
    assert named.closes is not None
    assert named.closes == d.closed


@pytest.mark.long
def test_a_model_that_has_not_followed_the_torque_explains_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(assembly, "missed", lambda *_: [("A", 4.0, 5.0)])
    few = [name for name in FEW if name not in ALIKE]
    d = diagnose(NOMINAL, recorded(LATE), jobs=1, leave_out=few)
    assert d.named == ("delay",)
    assert d.verdict == "partly_explained"
    assert any(said.startswith("A: even corrected, the model leaves 4 of 5 N m rms") for said in d.warnings)


def test_stages_shrink_to_the_floor() -> None:
    stages = {stage.stage: stage for stage in late().stages}
    assert list(stages) == ["as_given", "retuned", "delay", "noise_floor"]
    torque = [stages[name].torque["A"] for name in stages]
    assert torque[0] > torque[1] > 2 * torque[2]
    assert stages["delay"].motion["A"] < stages["retuned"].motion["A"]
    d = late()
    floor, left, before = (stages[name].torque["A"] for name in ("noise_floor", "delay", "retuned"))
    assert d.closed is not None
    expected = 1.0 - max(left**2 - floor**2, 0.0) / (before**2 - floor**2)
    assert d.closed.value == pytest.approx(expected, abs=1e-6)


def test_no_effect_no_gap() -> None:
    d = nothing()
    assert d.verdict == "no_gap"
    assert d.named == ()
    assert d.closed is None
    assert [cause.effect for cause in d.causes] == ["none", "unknown"]
    assert d.causes[0].probability > 0.5
    assert d.models["corrected"].effects == ()
    assert [stage.stage for stage in d.stages] == ["as_given", "retuned", "noise_floor"]
    assert not any(candidate.chosen for candidate in d.candidates)


def test_no_joint_is_blamed_for_what_the_noise_leaves() -> None:
    """A residual above its floor by a few per cent has shares, but they are of nothing."""
    d = diagnose(NOMINAL, recorded(noise=2e-5), jobs=1, leave_out=FEW)
    retuned, floor = (stage.torque["A"] for stage in d.stages[-2:])
    assert retuned > floor
    assert (d.verdict, d.where) == ("no_gap", ())


@pytest.mark.long
def test_missing_candidate_is_not_replaced_by_another() -> None:
    d = without_its_cause()
    assert d.verdict in ("unexplained", "partly_explained")
    assert all((cause.presence or 0.0) <= 0.5 for cause in d.causes)
    assert all(cause.probability <= 0.5 for cause in d.causes if cause.effect != "unknown")
    assert d.named == ()
    assert not {c.effect for c in d.candidates} & set(ALIKE)


@pytest.mark.slow  # the above do without those that are slow to fit
def test_the_answers_are_the_same_with_every_candidate() -> None:
    assert found(LATE).named == ("delay",)
    assert found().verdict == "no_gap"
    d = found(LATE, leave_out=ALIKE)
    assert d.named == ()
    assert d.verdict in ("unexplained", "partly_explained")


@pytest.mark.slow  # `without_its_cause` is the quick one
def test_unknown_effect_is_not_named() -> None:
    """A spot that sticks under load, which no candidate models."""
    d = found(("loaded_sticky_spot", {"torque": 4.0, "centre": 0.2, "width": 0.2, "load": 2.0}))
    assert all(cause.probability <= 0.5 for cause in d.causes if cause.effect != "unknown")
    assert d.verdict != "explained"


@pytest.mark.long
@pytest.mark.parametrize("one", ALL, ids=lambda f: f.__name__)
def test_bookkeeping(one) -> None:  # type: ignore[no-untyped-def]
    """Whatever the answer: probabilities sum to one, what is named is among the causes, and runs are never shared."""
    d = one()
    assert d.verdict in VERDICTS
    assert sum(cause.probability for cause in d.causes) == pytest.approx(1.0)
    assert all(-1e-12 <= cause.probability <= 1.0 for cause in d.causes)
    assert "unknown" in [cause.effect for cause in d.causes]
    assert set(d.named) <= {cause.effect for cause in d.causes}
    for cause in d.causes:
        assert cause.effect in ("none", "unknown") or cause.effect in cause.equivalent
    assert set(d.fit_runs).isdisjoint(d.held_out_runs)
    assert len(d.fit_runs) + len(d.held_out_runs) == 4
    assert sum(len(trace.time) for trace in d.traces) > 0
    for trace in d.traces:
        assert np.isfinite(trace.measured).all()
        assert trace.corrected.shape == trace.retuned.shape == trace.nominal.shape
    shown = {(c.step, c.effect, c.joint) for c in d.candidates}
    assert len(shown) == len(d.candidates)  # each candidate is ranked or screened out, once a step


def test_traces_are_the_stages() -> None:
    """The rms of measured less corrected is the figure of the last stage."""
    d = late()
    left = np.concatenate([trace.measured - trace.corrected for trace in d.traces])
    assert np.sqrt(np.mean(left**2)) == pytest.approx(d.stages[-2].torque["A"])


@pytest.mark.long
def test_same_seed_same_answer() -> None:
    first, again = late_among_few(), found(LATE, leave_out=FEW)
    assert first.causes == again.causes
    assert first.stages == again.stages
    assert first.where == again.where
    assert first.regions == again.regions
    assert first.models == again.models
    assert first.candidates == again.candidates


@pytest.mark.slow
def test_another_seed_draws_other_blocks() -> None:
    first, other = (found(LATE, leave_out=FEW, seed=seed) for seed in (1, 2))
    assert other.named == first.named
    assert other.regions != first.regions  # whose intervals are resampled


def test_effects_of_the_arm_file_are_part_of_the_nominal_model() -> None:
    informed: Arm = replace(NOMINAL, effects=(EffectEntry("delay", ("A",), {"A": {"time": 0.018}}),))
    d = diagnose(informed, recorded(LATE), jobs=1, leave_out=FEW)
    assert d.named == ()
    assert d.verdict == "no_gap"
    retuned = d.models["retuned"].effects
    assert retuned[0].parameters["A"]["time"] == pytest.approx(0.02, rel=0.03)


def test_single_run() -> None:
    d = diagnose(NOMINAL, recorded(LATE)[1:2], jobs=1, leave_out=FEW)
    assert d.fit_runs == d.held_out_runs
    assert any("held out" in note for note in d.notes)
    assert sum(cause.probability for cause in d.causes) == pytest.approx(1.0)


def test_run_of_another_arm_is_refused() -> None:
    two = replace(TRUE, joints=(TRUE.joints[0], replace(TRUE.joints[0], name="B")))
    with pytest.raises(InputError, match="not a recording of this arm"):
        diagnose(two, [sines(3.0)])


def test_runs_of_one_name_are_refused() -> None:
    """Results tell runs apart by their names."""
    with pytest.raises(InputError, match="two runs have the same name: found run"):
        diagnose(NOMINAL, [sines(3.0), sines(4.0)], [sines(3.0, name="other")])
    with pytest.raises(InputError, match="two runs have the same name: found run"):
        diagnose(NOMINAL, [sines(3.0)], [sines(4.0)])


@pytest.mark.long
def test_what_is_pushed_to_its_limits_is_told_of_the_model_that_is_delivered(monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside the payload a friction torque goes to its limit; if the payload is not named, that model is not delivered.

    The warning is then of the model without it, whose values all lie within their limits.
    """
    sure = replace(NOMINAL, tolerance=replace(NOMINAL.tolerance, inertial=0.05))
    runs = recorded(("payload", {"mass": 1.5}))
    others = tuple(name for name in registry() if name != "payload")
    told = "A.friction.C1: the data push it to three standard deviations"
    named = diagnose(sure, runs, jobs=1, leave_out=others)
    assert named.named == ("payload",)
    assert any(told in warning for warning in named.warnings)
    monkeypatch.setattr(verdict_module, "NAMED_OVER", 1.0)
    unnamed = diagnose(sure, runs, jobs=1, leave_out=others)
    assert unnamed.named == ()
    assert not any(told in warning for warning in unnamed.warnings)
