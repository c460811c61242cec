"""One arm on which every effect is recorded by the independent plant, and what its data sheet says of it."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from stribeck.arm import Arm, Friction, Joint
from stribeck.effects.registry import laws
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.identify.conditioning import Conditioned, condition
from stribeck.identify.residual import Residual
from stribeck.model.effect import Effect
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath
from stribeck.model.waves import Trace
from stribeck.run import Run
from stribeck.withheld.arms import misinformed
from stribeck.withheld.excitation import programme
from stribeck.withheld.injections import Injection
from stribeck.withheld.recorder import default_gains, record

RATE, NOISE, RESOLUTION = 250.0, 1e-5, 2e-5
A, B = Friction(4.6, 1.65, 1.4, 0.06), Friction(2.2, 0.6, 0.8, 0.04)


def every_effect(check: Callable[..., None]) -> Callable[..., None]:
    """One test that checks every law, quick as each is: what fails says of which law it is."""
    asked = inspect.signature(check)

    def test(**fixtures: object) -> None:
        failed: list[Exception] = []
        for effect in laws().values():
            try:
                check(effect=effect, **fixtures)
            except Exception as problem:
                problem.add_note(f"of {effect.label}")
                failed.append(problem)
        if failed:
            raise ExceptionGroup(f"{check.__name__}: {len(failed)} of {len(laws())} laws", failed)

    test.__name__, test.__doc__ = check.__name__, check.__doc__
    others = [parameter for name, parameter in asked.parameters.items() if name != "effect"]
    test.__signature__ = asked.replace(parameters=others)  # type: ignore[attr-defined]
    return test


def true_arm(bend: bool = True) -> Arm:
    """A vertical arm of two joints; without `bend` joint B has no falling friction."""
    b = B if bend else replace(B, C1=0.0)
    joints = (
        Joint("A", "revolute", 0.35, 4.0, (0.17, 0.01), 0.06, 0.15, A, A, 200.0, RESOLUTION),
        Joint("B", "revolute", 0.30, 2.0, (0.13, -0.01), 0.03, 0.06, b, b, 60.0, RESOLUTION),
    )
    return Arm("bench", (9.81, 0.0), joints, sample_time=1.0 / RATE)


def nominal_arm(bend: bool = True) -> Arm:
    """Its data sheet: inertial values off by 2 %, friction by 10 %."""
    return misinformed(true_arm(bend), np.random.default_rng(3), inertial=0.02, friction=0.1)


def scaled(arm: Arm, factor: float) -> Arm:
    """The same arm with all masses, inertias and friction by a factor: it moves alike under as much torque."""

    def rubs(own: Friction) -> Friction:
        return replace(own, C0=factor * own.C0, C1=factor * own.C1, C2=factor * own.C2)

    joints = []
    for joint in arm.joints:
        heavy = {name: factor * getattr(joint, name) for name in ("mass", "inertia", "rotor_inertia")}
        joints.append(replace(joint, **heavy, friction=rubs(joint.friction), backward=rubs(joint.backward)))
    return replace(arm, joints=tuple(joints))


def recorded(
    effect: str | None = None,
    joints: Sequence[str] = (),
    parameters: Mapping[str, float] | None = None,
    *,
    duration: float = 6.0,
    bend: bool = True,
) -> tuple[Run, ...]:
    """Two runs, with an effect hidden in some joints."""
    nominal = nominal_arm(bend)
    motions = programme(nominal, np.random.default_rng(1), ("slow reversals", "multisine"), duration)
    hidden = [Injection(effect, joint, parameters or {}) for joint in joints] if effect else []
    gains = default_gains(nominal, 3.0)
    return record(true_arm(bend), hidden, motions, rate=RATE, noise=NOISE, gains=gains, model=nominal, seed=5)


@cache
def clean() -> Prepared:
    """Short runs of the arm as it is, conditioned; nothing is hidden in them."""
    runs = recorded(duration=2.0)
    return prepare(nominal_arm(), runs, runs[1:])


@cache
def smooth() -> Conditioned:
    """Both joints on sines, without noise: what stiff and slow things do along it is known."""
    t = np.arange(1000) / 500.0
    q = np.stack([np.sin(2 * np.pi * 0.6 * t + 0.3), 0.8 * np.sin(2 * np.pi * 1.1 * t + 1.0)], axis=1)
    return condition(nominal_arm(), Run("sines", t, q, [30.0, 10.0] * np.cos(9.0 * t)[:, None]), 30.0, np.full(2, 1e-7))


def arm_for(effect: Effect) -> Arm:
    """The nominal arm, with no falling friction where that is what the effect adds."""
    return nominal_arm(effect.applies(nominal_arm(), 1))


@cache
def trace(joint: int) -> Trace:
    """What a joint did in the clean runs, and what a data sheet that is wrong leaves there."""
    path = SignalPath(nominal_arm())
    residual, _ = Residual(path, clean().fit, ())(values_of(path.entries))
    columns = {
        name: np.concatenate([getattr(run, name)[run.analysis_index] for run in clean().fit])
        for name in ("time", "position", "velocity", "command")
    }
    return Trace(**{k: v if v.ndim == 1 else v[:, joint] for k, v in columns.items()}, residual=residual[:, joint])


def starts(effect: Effect, joint: int) -> tuple[dict[str, float], ...]:
    """The effect's own trial values for the clean runs."""
    return effect.starts_from(clean().scales[joint], trace(joint))


def everywhere(effect: Effect) -> list[Placed]:
    """The effect at all its sites, with its first trial values."""
    return [Placed(effect, j, starts(effect, j)[0]) for j in effect.sites(2)]
