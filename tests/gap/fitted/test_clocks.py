"""Clocks: a wave from outside has a phase of its own in every run, and one phase once the clocks are set."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import Arm, EffectEntry
from stribeck.effects.registry import effect_named
from stribeck.gap.diagnose import diagnose
from stribeck.gap.fitted.clocks import in_step, in_step_beside
from stribeck.gap.fitted.model import Model, retune
from stribeck.gap.records.floor import noise_floor
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.gap.search.setting import Asked
from stribeck.gap.search.tuned import retuned
from stribeck.identify.conditioning import Conditioned
from stribeck.identify.conditioning import shaken as noisier
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath
from stribeck.run import Run

from ..conftest import NOMINAL, recorded, sines

FLOOR = np.array([0.02])
HERTZ = 3.1
APART = (0.4, 2.9, -1.3, 1.2)  # rad


def shaken(phases: Sequence[float], amplitude: float = 1.0) -> list[Run]:
    """Runs under a wave that each of them meets at another phase."""
    wave = {"noise": 0.0, "amplitude": amplitude, "frequency": HERTZ}
    return [recorded(("input_disturbance", {**wave, "phase": p}))[i] for i, p in enumerate(phases)]


@pytest.fixture(scope="module")
def apart() -> tuple[Prepared, Model]:
    prepared = prepare(NOMINAL, shaken(APART))
    return prepared, retune(prepared, FLOOR)


def phases_of(prepared: Prepared, base: Model) -> np.ndarray:
    """Return the phase of the wave in the residual of each run, by its clock."""
    runs = (*prepared.fit, *prepared.held)
    rows = np.concatenate([base.fit.residual, base.held])[:, 0]
    parts = np.split(rows, np.cumsum([len(run.analysis_index) for run in runs])[:-1])
    clock = [run.told_time[run.analysis_index] for run in runs]
    turn = -2j * np.pi * HERTZ
    return np.array([np.angle(np.sum(r * np.exp(turn * t))) for r, t in zip(parts, clock, strict=True)])


def spread(phases: np.ndarray) -> float:
    return float(np.max(np.abs(np.angle(np.exp(1j * (phases - phases[0]))))))


def test_runs_are_brought_in_step(apart: tuple[Prepared, Model]) -> None:
    prepared, base = apart
    assert spread(phases_of(prepared, base)) > 1.0
    moved = in_step(prepared, base.whole)
    assert spread(phases_of(moved, base)) < 0.1
    assert moved.fit[0].told_time == pytest.approx(prepared.fit[0].time)  # the first run keeps its clock
    for run, before in zip((*moved.fit, *moved.held), (*prepared.fit, *prepared.held), strict=True):
        assert run.time is before.time
        assert abs(run.told_time[0] - before.time[0]) <= 1.0 / HERTZ + 1e-3


@pytest.mark.parametrize("runs", [[0.4] * 4, None])
def test_clocks_that_are_right_stay(runs: list[float] | None) -> None:
    """One phase in all runs; and nothing that waves."""
    prepared = prepare(NOMINAL, shaken(runs) if runs else recorded())
    assert in_step(prepared, retune(prepared, FLOOR).whole) is prepared


@pytest.mark.parametrize(
    ("phases", "starts", "right"),
    [((0.4,) * 4, (0.0, np.pi, 0.0, np.pi), False), (APART, APART, True)],  # starts in rad of the wave
)
def test_clocks_are_judged_by_the_time_that_is_told(
    phases: Sequence[float], starts: Sequence[float], right: bool
) -> None:
    """Runs that began at one phase of the wave, by clocks that say otherwise; and the other way round."""
    late = np.array(starts) / (2 * np.pi * HERTZ)
    runs = [replace(run, t=run.t + by) for run, by in zip(shaken(phases), late, strict=True)]
    prepared = prepare(NOMINAL, runs)
    base = retune(prepared, FLOOR)
    assert (spread(phases_of(prepared, base)) < 0.1) is right
    moved = in_step(prepared, base.whole)
    assert (moved is prepared) is right
    assert spread(phases_of(moved, base)) < 0.1


def test_a_clock_that_another_law_set_astray_is_set_anew(apart: tuple[Prepared, Model]) -> None:
    prepared, base = apart
    moved = in_step(prepared, base.whole)
    astray = replace(moved.fit[1], clock=moved.fit[1].told_time[0] + 0.2 / HERTZ)
    astray_runs = replace(moved, fit=(moved.fit[0], astray, *moved.fit[2:]))
    offset = Placed(effect_named("torque_offset"), 0, {"offset": 0.0})
    wave = Placed(effect_named("input_disturbance"), 0, {"sine": 0.5, "cosine": 0.5, "frequency": HERTZ})
    model = retune(astray_runs, FLOOR, (offset, wave))
    assert in_step_beside(astray_runs, retune(astray_runs, FLOOR, (offset,))) is astray_runs  # nothing reads them
    again = in_step_beside(astray_runs, model)
    assert spread(phases_of(astray_runs, base)) > 1.0 > 0.1 > spread(phases_of(again, base))
    assert in_step_beside(again, retune(again, FLOOR, (offset, wave))) is again


@pytest.mark.long
def test_a_disturbance_is_named_whatever_its_phases() -> None:
    keep = ("input_disturbance", "cogging", "delay", "torque_offset")
    from stribeck.effects.registry import registry

    out = [name for name in registry() if name not in keep]
    d = diagnose(NOMINAL, shaken(APART), jobs=1, leave_out=out)
    assert d.named == ("input_disturbance",)
    (cause,) = (c for c in d.causes if c.effect == "input_disturbance")
    found = cause.parameters["A"]
    assert found["frequency"].value == pytest.approx(HERTZ, rel=0.01)
    assert np.hypot(found["sine"].value, found["cosine"].value) == pytest.approx(1.0, rel=0.1)
    motion = {stage.stage: stage.motion["A"] for stage in d.stages}
    assert motion["input_disturbance"] < 0.7 * motion["retuned"]  # the clocks hold in simulation too


def test_no_wave_no_clock(apart: tuple[Prepared, Model]) -> None:
    """Nothing at all, something in one run only, and a record that is broken."""
    prepared, base = apart
    total = len(base.fit.residual) + len(base.held)
    nothing = np.zeros((total, 1))
    assert in_step(prepared, nothing) is prepared
    assert in_step(prepared, nothing * np.nan) is prepared
    one = nothing.copy()
    one[-200:, 0] = np.sin(0.4 * np.arange(200))
    moved = in_step(prepared, one)
    assert all(np.all(np.isfinite(run.told_time)) for run in (*moved.fit, *moved.held))


def test_what_repeats_with_the_motion_is_no_clock() -> None:
    """All runs swing at 1.3 Hz, each from another phase: so does whatever the model lacks."""
    runs = []
    for i, phase in enumerate(APART):
        run = sines(8.0, seed=i)
        q = np.sin(2 * np.pi * 1.3 * run.t + phase)[:, None]
        runs.append(replace(run, name=f"run {i}", q=q, tau=20.0 * q))
    prepared = prepare(NOMINAL, runs)
    every = (*prepared.fit, *prepared.held)
    third = [np.sin(6 * np.pi * 1.3 * r.time[r.analysis_index] + 3 * p) for r, p in zip(every, APART, strict=True)]
    assert in_step(prepared, np.concatenate(third)[:, None]) is prepared


def test_noise_is_drawn_on_the_same_clock(apart: tuple[Prepared, Model]) -> None:
    run = replace(apart[0].fit[0], clock=0.7)
    again = noisier(NOMINAL, run, apart[0].cutoff, np.zeros_like(run.run.q))
    assert again.told_time == pytest.approx(run.told_time)
    assert run.told_time[0] == pytest.approx(0.7)


def test_noise_is_told_on_the_clock_of_its_run(apart: tuple[Prepared, Model]) -> None:
    """Noise and filters are told by runs made anew: on another clock, a known disturbance would count as noise."""
    plain = apart[0].fit[0]
    late, turn = 0.1, 2 * np.pi * HERTZ * 0.1

    def floor(run: Conditioned, sine: float, cosine: float) -> np.ndarray:
        known = {"sine": sine, "cosine": cosine, "frequency": HERTZ}
        path = SignalPath(NOMINAL, (Placed(effect_named("input_disturbance"), 0, known),))
        return noise_floor(NOMINAL, path, values_of(path.entries), [run], apart[0].cutoff, 0)

    by_clock = floor(replace(plain, clock=float(plain.time[0]) + late), 3.0, 0.0)
    by_phase = floor(plain, 3.0 * np.cos(turn), 3.0 * np.sin(turn))
    assert by_clock == pytest.approx(by_phase, rel=1e-3, abs=1e-6)


def stated(effect: str, values: dict[str, float], law: str | None = None) -> Arm:
    return replace(NOMINAL, effects=(EffectEntry(effect, ("A",), {"A": values}, law),))


@pytest.mark.parametrize("phases", [APART, (0.0,) * 4])
def test_a_disturbance_that_the_arm_file_states_keeps_the_clocks_that_it_asks_for(phases: Sequence[float]) -> None:
    """What is left beside it has waves as well, of no size: they set no clock."""
    arm = stated(
        "input_disturbance", {"sine": np.cos(APART[0]), "cosine": np.sin(APART[0]), "frequency": HERTZ}, "one_wave"
    )
    tuned = retuned(prepare(arm, shaken(phases)), Asked(jobs=1))
    left = np.sqrt(np.mean(tuned.base.held**2))
    assert left < 3.0 * float(tuned.noise.rms[0])
    plain = retuned(prepare(NOMINAL, recorded()), Asked(jobs=1)).given
    assert np.mean(tuned.given**2) < np.mean(plain**2) + 0.1  # as given, too, by these clocks; the wave has 0.5


@pytest.mark.parametrize(
    ("effect", "law"), [("presliding", "lugre"), ("joint_flexibility", None), ("actuator_lag", None)]
)
def test_an_effect_without_values_is_as_if_it_were_not_there(effect: str, law: str | None) -> None:
    runs, asked = recorded(), Asked(jobs=1)
    plain, empty = (retuned(prepare(arm, runs), asked) for arm in (NOMINAL, stated(effect, {}, law)))
    assert empty.base.placed == plain.base.placed
    assert empty.base.rms() == pytest.approx(plain.base.rms())
