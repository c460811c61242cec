"""The fit to whole recordings: its intervals hold, whatever noise and filters do to every stretch alike."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from stribeck.arm import Arm, Friction, Joint
from stribeck.identify.conditioning import condition
from stribeck.identify.map_fit import Fit, fit
from stribeck.identify.run_fit import RunFit, fit_runs
from stribeck.run import Run
from stribeck.simulate import JointLoop, Loop, Reference, close_loop

from ..effects.bench import scaled
from .bench import BACKWARD, FORWARD, engine, joint
from .conftest import PENDULUM, hoisted, law

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


def test_intervals_know_no_unit() -> None:
    """Of an arm whose torques are all by 2^-18 they are as much smaller."""
    factor, plain = 2.0**-18, joint(WRONG, WRONG)
    widths = []
    for arm, part in ((plain, 1.0), (scaled(plain, factor), factor)):
        runs = [replace(run, tau=part * run.tau) for run in swung(0.002)]
        found = fit_runs(
            arm, [condition(arm, run, CUTOFF, np.full(1, 1e-7), thin=True) for run in runs], [(True, True)], CUTOFF
        )
        i = [entry.key for entry in found.fit.entries].index("A.friction.C0")
        widths.append((found.intervals.high[i] - found.intervals.low[i]) / part)
    assert widths[1] == pytest.approx(widths[0], rel=1e-3)


def holds(found: RunFit) -> list[bool]:
    keys = [entry.key for entry in found.fit.entries]
    ends = found.intervals
    return [
        bool(ends.low[i] <= getattr(true, name) <= ends.high[i])
        for side, true in (("friction", FORWARD), ("backward", BACKWARD))
        for name in ("C0", "C1", "C2", "alpha")
        for i in [keys.index(f"A.{side}.{name}")]
    ]


@pytest.mark.long
@pytest.mark.parametrize(("step", "noise"), [(0.002, 2e-5), pytest.param(0.005, 1e-5, marks=pytest.mark.slow)])
def test_intervals_hold_around_reversals_in_noise(step: float, noise: float) -> None:
    """Noise and filters shift every block alike, so that scatter from block to block does not tell."""
    assert np.mean([holds(fitted(swung(step), noise, seed)) for seed in range(3)]) > 0.9


@pytest.mark.long
def test_reversals_in_noise_leave_constants_near_the_truth() -> None:
    found = [fitted(swung(0.002), 2e-5, seed) for seed in range(12)]
    assert np.mean([holds(one) for one in found]) > 0.85
    sides = [one.arm.joints[0].friction for one in found]
    assert max(abs(side.C0 / FORWARD.C0 - 1.0) for side in sides) < 2e-3
    assert max(abs(side.C2 / FORWARD.C2 - 1.0) for side in sides) < 6e-3


def test_a_round_that_fails_leaves_what_the_one_before_found(monkeypatch: pytest.MonkeyPatch) -> None:
    rounds: list[Fit] = []

    def fails_later(*given: Any, **named: Any) -> Fit:
        found = fit(*given, **named)
        rounds.append(replace(found, status="Restoration_Failed", p=0.0 * found.p) if rounds else found)
        return rounds[-1]

    monkeypatch.setattr("stribeck.identify.run_fit.fit", fails_later)
    assert fitted(swung(0.005), 1e-5, 0).fit is rounds[0]
    assert len(rounds) == 3


def set_off(own: Joint, speed: float, noise: float, seed: int) -> Run:
    """Up to a steady speed within a few hundredths of a second: inertia shows for a moment, in noise that lasts."""

    def motion(t: np.ndarray) -> list[np.ndarray]:
        decay = np.exp(-t / 0.05)
        return [speed * (t - 0.05 * (1.0 - decay)), speed * (1.0 - decay), speed * decay / 0.05]

    t = 0.004 * np.arange(750)
    tau = law(own, 0.0, *motion(t + 0.002))
    q = motion(t)[0] + noise * np.random.default_rng(seed).standard_normal(len(t))
    return Run("set off", t, q[:, None], tau[:, None])


@pytest.mark.parametrize("seed", [0, 10, 20])
def test_noise_in_the_acceleration_is_no_reason_for_less_inertia(seed: int) -> None:
    """Least squares go to the end of the tolerances for it."""
    level, noise = replace(PENDULUM, com=(0.0, 0.0)), 1e-4
    arm = Arm("level", (0.0, 0.0), (level,))
    runs = [set_off(level, speed, noise, seed + k) for k, speed in enumerate((0.1, 0.2, 0.4, 0.7, 1.0))]
    conditioned = [condition(arm, run, 15.0, np.full(1, noise), thin=True) for run in runs]
    found = fit_runs(arm, conditioned, [(True, False)], 15.0)
    fitted = found.arm.joints[0]
    assert found.fit.ok
    assert found.fit.at_limit == ()
    assert fitted.inertia + fitted.rotor_inertia == pytest.approx(level.inertia + level.rotor_inertia, rel=0.1)


def test_weight_that_friction_bears_as_well_is_left_to_the_tolerances() -> None:
    """Of a vertical axis, what mass is taken for the rotor's: a run moves it no further than the arm file allows."""
    arm, run = hoisted(replace(PENDULUM, mass=6.0, rotor_inertia=1.0), noise=1e-5, seed=2)
    guess = replace(arm, joints=(replace(arm.joints[0], mass=5.82),))
    found = fit_runs(guess, [condition(guess, run, CUTOFF, np.full(1, 1e-5), thin=True)], [(True, True)], CUTOFF)
    levels = [[entry.key for entry in found.fit.entries].index(f"A.{side}.C0") for side in ("friction", "backward")]
    assert found.fit.p[levels] == pytest.approx(PENDULUM.friction.C0, rel=0.1)
    assert (found.intervals.high - found.intervals.low)[levels].min() > PENDULUM.friction.C0
    assert not found.intervals.identified[levels].any()
