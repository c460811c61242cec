"""How far: the gap in torque and in motion at each stage, from the arm file to the noise floor."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.arm import Arm, unit_at
from stribeck.gap.answer.motion import Motions
from stribeck.gap.answer.verdict import AT_FLOOR
from stribeck.gap.fitted.model import Model
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.result import Stage

FOLLOWED = 0.5  # of the recorded torque, rms: a model that leaves more has not followed it
WORSE = 1.5  # times what the nominal values leave on held-out runs, that re-tuned ones leave: more than an effect bends


def stages_of(
    motions: Motions, given: np.ndarray, chain: Sequence[Model], held: Sequence[np.ndarray], floor: np.ndarray
) -> tuple[tuple[Stage, ...], list[str]]:
    """Return the stages, and warnings of what could not be simulated.

    Parameters
    ----------
    motions : Motions
    given : array (M, n)
        Residual of the arm file's own model on the held-out runs, N m.
    chain : sequence of Model
        The re-tuned model, then one effect more each.
    held : sequence of array (M, n)
        What each of them leaves on the held-out runs, with the noise that it takes in put back, N m.
    floor : array (n,)
        Noise floor, N m rms.
    """
    arm = motions.prepared.file_arm
    names = ("as_given", "retuned", *(model.placed[-1].effect.name for model in chain[1:]))
    moved = [motions.of_arm(arm), *map(motions.of, chain)]
    stages = [
        Stage(name, _named(arm, _rms(left)), motion)
        for name, left, (motion, _) in zip(names, (given, *held), moved, strict=True)
    ]
    warnings = [f"{name}: {said}" for name, (_, said) in zip(names, moved, strict=True) if said]
    noise = Stage("noise_floor", _named(arm, floor), _named(arm, motions.prepared.held[0].noise))
    return (*stages, noise), warnings


def told_worse(stages: Sequence[Stage], arm: Arm) -> list[str]:
    """Return a warning for each joint of an arm that re-tuning has made worse on what was held out."""
    given, tuned = (next(stage.torque for stage in stages if stage.stage == name) for name in ("as_given", "retuned"))
    return [
        f"{joint.name}: re-tuned values leave {tuned[joint.name]:.3g} {unit_at('N m', joint.kind)} rms on what was "
        f"held out, the nominal ones {given[joint.name]:.3g}: what was fitted is too short or unlike it; record more"
        for joint in arm.joints
        if tuned[joint.name] > WORSE * given[joint.name]
    ]


def missed(prepared: Prepared, held: np.ndarray, floor: np.ndarray) -> list[tuple[str, float, float]]:
    """Return (joint, what is left, recorded torque), rms, of the joints whose torque a model has not followed.

    However much of a gap it closes: an arm file that is far off makes one beside which all that is left is little.

    Parameters
    ----------
    prepared : Prepared
    held : array (M, n)
        What the model leaves on the held-out runs, N m.
    floor : array (n,)
        Noise floor, N m rms.
    """
    asked = _rms(np.concatenate([run.command for run in prepared.held]))
    rows = zip(prepared.arm.names, _rms(held), asked, floor, strict=True)
    return [
        (name, float(left), float(torque))
        for name, left, torque, low in rows
        if left > max(AT_FLOOR * low, FOLLOWED * torque) and torque > low  # a joint without a drive follows nothing
    ]


def told_missed(rows: Sequence[tuple[str, float, float]], arm: Arm) -> list[str]:
    """Return a warning for each joint of an arm whose torque the corrected model has not followed."""
    units = {joint.name: unit_at("N m", joint.kind) for joint in arm.joints}
    return [
        f"{name}: even corrected, the model leaves {left:.3g} of {torque:.3g} {units[name]} rms: check the arm file's "
        "values and units"
        for name, left, torque in rows
    ]


def _rms(held: np.ndarray) -> np.ndarray:
    return np.asarray(np.sqrt(np.mean(held**2, axis=0)))


def _named(arm: Arm, values: np.ndarray) -> dict[str, float]:
    return {name: float(value) for name, value in zip(arm.names, values, strict=True)}
