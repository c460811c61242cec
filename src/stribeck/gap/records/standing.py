"""Joints that stand still in every recording: of an arm that never moves nothing can be told, and little of a joint."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.arm import Arm, unit_at
from stribeck.errors import InputError
from stribeck.identify.braked import unmoved
from stribeck.identify.conditioning import Conditioned


def check_motion(arm: Arm, runs: Sequence[Conditioned]) -> None:
    """Raise `InputError` where no joint moves in any run: a residual of nothing is no sign of a good model."""
    if not standing(runs).all():
        return
    way, noise = np.max([np.ptp(run.run.q, axis=0) for run in runs], axis=0), runs[0].noise
    j = int(np.argmax(way / noise))
    unit = unit_at("rad", arm.joints[j].kind)
    found = f"{way[j]:.2g} {unit} from end to end at {arm.names[j]}, with noise of {noise[j]:.2g} {unit}"
    what = "no joint moves in these recordings beyond its encoder's noise, so nothing can be said of the arm"
    raise InputError(what, found, "record a motion")


def driven_in_vain(arm: Arm, runs: Sequence[Conditioned]) -> list[str]:
    """Return a warning for each joint that is driven and stands still in every run."""
    held = np.all([run.braked for run in runs], axis=0)
    return [
        f"{arm.names[j]}: it is driven, but moves in no recording beyond its encoder's noise: little can be said of "
        "it; record it with more torque than its friction holds"
        for j in np.flatnonzero(standing(runs) & ~held)
    ]


def seen_on_one_side(arm: Arm, fit: Sequence[Conditioned], held: Sequence[Conditioned]) -> list[str]:
    """Return a warning for each joint that moves in fitted runs alone, or in held-out ones alone."""
    learnt, judged = ~standing(fit), ~standing(held)
    do = "record it moving in several runs, or choose with --held-out which are kept back"
    return [
        f"{arm.names[j]}: it moves in no run that is held out: nothing judges what is learnt of it; {do}"
        if learnt[j]
        else f"{arm.names[j]}: it moves in held-out runs alone: nothing of it can be learnt; {do}"
        for j in np.flatnonzero(learnt != judged)
    ]


def standing(runs: Sequence[Conditioned]) -> np.ndarray:
    """Return which joints (n,) stand still in every run, at any torque."""
    return np.asarray(np.all([unmoved(run.run, run.noise) for run in runs], axis=0))
