"""The fit to whole recordings: its intervals hold, whatever noise and filters do to every stretch alike."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from stribeck.arm import Friction
from stribeck.identify.conditioning import condition
from stribeck.identify.run_fit import RunFit, fit_runs
from stribeck.run import Run
from stribeck.simulate import JointLoop, Loop, Reference, close_loop

from .bench import BACKWARD, FORWARD, engine, joint

WRONG = Friction(4.0, 1.0, 1.2, 0.04)
SWINGS = ((0.5, 0.3), (0.05, 0.2), (0.3, 1.0))  # rad, Hz
CUTOFF = 20.0


@cache
def swung(step: float) -> list[Run]:
    loops = [JointLoop("A", 100.0, Reference("sine", amplitude=a, frequency=f)) for a, f in SWINGS]
    return [close_loop(engine(), Loop(step, 15.0, (loop,))).run("swing") for loop in loops]


def fitted(runs: list[Run], noise: float, seed: int) -> RunFit:
    rng = np.random.default_rng(seed)
    noisy = [replace(run, q=run.q + noise * rng.standard_normal(run.q.shape)) for run in runs]
    arm = joint(WRONG, WRONG)
    conditioned = [condition(arm, run, CUTOFF, np.full(1, noise), thin=True) for run in noisy]
    return fit_runs(arm, conditioned, [(True, True)], CUTOFF)


def holds(found: RunFit) -> list[bool]:
    keys = [entry.key for entry in found.fit.entries]
    ends = found.intervals
    return [
        bool(ends.low[i] <= getattr(true, name) <= ends.high[i])
        for side, true in (("friction", FORWARD), ("backward", BACKWARD))
        for name in ("C0", "C1", "C2", "alpha")
        for i in [keys.index(f"A.{side}.{name}")]
    ]


@pytest.mark.parametrize(("step", "noise"), [(0.002, 2e-5), (0.005, 1e-5)])
def test_intervals_hold_around_reversals_in_noise(step: float, noise: float) -> None:
    """Noise and filters shift every block alike, so that scatter from block to block does not tell."""
    assert np.mean([holds(fitted(swung(step), noise, seed)) for seed in range(3)]) > 0.9
