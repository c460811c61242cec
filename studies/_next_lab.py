"""The laboratory that makes the next recording: the independent plant under a loop that follows a reference file."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
from _next_cases import Poor
from scipy.interpolate import make_interp_spline

from stribeck.arm import Arm
from stribeck.gap.experiment.changes import Change, Loaded, Raised, Reversed, Turned
from stribeck.gap.experiment.separation import AS_IT_IS
from stribeck.run import Run
from stribeck.withheld.injections import Injection
from stribeck.withheld.motions import Array, Motion
from stribeck.withheld.recorder import record

SIGNED = {"torque_offset": "offset"}  # of a drive that, turned around, pushes the other way; magnets pull as before
OWN_STREAM = 4096  # of random numbers: noise of the new recording


def followed(case: Poor, reference: Run, change: Change = AS_IT_IS) -> Run:
    """Return what the case's own laboratory records of a reference; the reference's torque is fed forward.

    Raises
    ------
    Diverged
        Where the controller cannot hold the arm.
    """
    assert reference.q_ref is not None
    spline = make_interp_spline(reference.t, reference.q_ref, k=5)

    def curve(t: Array, k: int) -> tuple[Array, Array, Array]:
        return spline(t)[:, k], spline(t, 1)[:, k], spline(t, 2)[:, k]

    joints = range(reference.n)
    torque = tuple(partial(np.interp, xp=reference.t, fp=reference.tau[:, k]) for k in joints)
    motion = Motion("next", float(reference.t[-1]), tuple(partial(curve, k=k) for k in joints), torque)
    true, nominal, hidden = _changed(case, change)
    gains = replace(case.bench.gains(nominal), forward="none")
    (run,) = record(
        true, hidden, [motion], rate=case.bench.rate, noise=case.bench.noise, gains=gains, model=nominal,
        seed=case.seed + OWN_STREAM,
    )  # fmt: skip
    return replace(run, name="run_next")


def _changed(case: Poor, change: Change) -> tuple[Arm, Arm, tuple[Injection, ...]]:
    """Return true arm, controller's arm and hidden effects after a change of the arm or its stand."""
    arms, hidden = (case.true, case.nominal), [case.hidden]
    for place in change.after:
        match place.effect:
            case Turned():
                arms = tuple(replace(arm, gravity=(-arm.gravity[0], -arm.gravity[1])) for arm in arms)
                hidden = [_turned(one) for one in hidden]
            case Raised():
                arms = tuple(replace(arm, gravity=(arm.gravity[0] + 9.81, arm.gravity[1])) for arm in arms)
            case Loaded(mass=mass):
                hidden.append(Injection("payload", arms[0].names[-1], {"mass": mass}))
            case Reversed():
                hidden = [_reversed(one, arms[0].names[place.joint]) for one in hidden]
    return arms[0], arms[1], tuple(hidden)


def _turned(one: Injection) -> Injection:
    """Return an effect as the turned base has it: a tilt turns along."""
    if one.effect != "gravity_tilt":
        return one
    return one._replace(params={name: -value for name, value in one.params.items()})


def _reversed(one: Injection, joint: str) -> Injection:
    if one.joint != joint or one.effect not in SIGNED:
        return one
    name = SIGNED[one.effect]
    return one._replace(params={**one.params, name: -one.params[name]})
