"""Clocks: a wave from outside has a phase of its own in every run, and one phase once the clocks are set."""

from collections.abc import Sequence

import numpy as np
import pytest

from stribeck.gap.clocks import in_step
from stribeck.gap.diagnose import diagnose
from stribeck.gap.model import Model, retune
from stribeck.gap.prepare import Prepared, prepare
from stribeck.run import Run

from .conftest import NOMINAL, recorded

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
    clock = [run.time[run.analysis_index] for run in runs]
    turn = -2j * np.pi * HERTZ
    return np.array([np.angle(np.sum(r * np.exp(turn * t))) for r, t in zip(parts, clock, strict=True)])


def spread(phases: np.ndarray) -> float:
    return float(np.max(np.abs(np.angle(np.exp(1j * (phases - phases[0]))))))


def test_runs_are_brought_in_step(apart: tuple[Prepared, Model]) -> None:
    prepared, base = apart
    assert spread(phases_of(prepared, base)) > 1.0
    moved = in_step(prepared, base)
    assert spread(phases_of(moved, base)) < 0.1
    assert moved.fit[0].time == pytest.approx(prepared.fit[0].time)  # the first run keeps its clock
    for run, before in zip((*moved.fit, *moved.held), (*prepared.fit, *prepared.held), strict=True):
        assert run.time - run.time[0] == pytest.approx(before.time - before.time[0])
        assert abs(run.time[0] - before.time[0]) <= 0.5 / HERTZ + 1e-3


@pytest.mark.parametrize("runs", [[0.4] * 4, None])
def test_clocks_that_are_right_stay(runs: list[float] | None) -> None:
    """One phase in all runs; and nothing that waves."""
    prepared = prepare(NOMINAL, shaken(runs) if runs else recorded())
    assert in_step(prepared, retune(prepared, FLOOR)) is prepared


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
    assert motion["input_disturbance"] < 0.5 * motion["retuned"]  # the clocks hold in simulation too
