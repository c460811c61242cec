"""Links of another length than the arm file has: no effect, and yet a gap that no re-tuning of masses closes.

A length stands in the arm file without a tolerance. Beside masses that are re-tuned, one that is wrong shows where
gravity and acceleration ask for different ones: it would pass for a tilted stand, or for a soft one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stribeck.arm import Arm
from stribeck.gap.fitted.model import Model, finite, retune, weights_of
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.search.projector import Projector
from stribeck.gap.search.setting import Asked
from stribeck.gap.search.tuned import Retuned, retuned
from stribeck.identify.residual import Residual
from stribeck.model.path import SignalPath

STANDS_OUT = 3.0  # noise floors, squared: joints with less have no gap to close
LEFT = 0.2  # of what stands out of the floor, squared, that other lengths may leave at one such joint
WORSE = 1.05  # times what is left, squared, that they may leave at any other
LEAST, MOST = 0.01, 0.3  # of a length: no drawing is further off, and a tape measure no nearer
USUAL = 0.1  # of a length, that wrong ones are off
MUCH = 0.2  # of the cost, that the first step must promise
ROUNDS, SETTLED = 5, 2e-3  # steps at most, and one so small, of a length, that it is the last
TWITCH = 1e-4  # of a length, by which it is changed to see what that does


def of_asked_lengths(tuned: Retuned, models: Sequence[Model], floor: np.ndarray, asked: Asked) -> Retuned | None:
    """Return recordings re-tuned to an arm of the lengths that they ask for; None where the file's will do.

    Parameters
    ----------
    tuned : Retuned
    models : sequence of Model
        Each lacks something: the re-tuned one, or, of a search, the last one without each effect that was taken.
    floor : array (n,)
        Noise floor, N m rms.
    asked : Asked
    """
    if told_lengths(tuned.prepared):  # once is enough
        return None
    found = (asked_lengths(tuned.prepared, model, floor) for model in models if finite(model))
    lengths = next((lengths for lengths in found if lengths is not None), None)
    if lengths is None:
        return None
    asked.progress("again, with links of other lengths")
    return retuned(replace(tuned.prepared, arm=_with(tuned.prepared.arm, lengths)), asked)


def asked_lengths(prepared: Prepared, base: Model, floor: np.ndarray) -> np.ndarray | None:
    """Return the lengths (n,) that recordings ask for, m; None where other ones do not close all of a joint's gap.

    What an effect makes at one joint is not in the way at another.

    Parameters
    ----------
    prepared : Prepared
    base : Model
        Fitted with the lengths of the arm file.
    floor : array (n,)
        Noise floor, N m rms.
    """
    arm = prepared.arm
    before = _over(base, floor)
    out = before > STANDS_OUT
    given = np.array([joint.length for joint in arm.joints])
    inner = [j for j in range(arm.n - 1) if given[j] > 0.0]
    if not inner or not out.any():
        return None
    lengths, model = given.copy(), base
    for number in range(ROUNDS):
        promise, step = _step(replace(prepared, arm=_with(arm, lengths)), model, floor, inner)
        if number == 0 and promise < MUCH * model.fit.cost:
            return None
        lengths[inner] *= 1.0 + step
        if np.any(np.abs(lengths - given) > MOST * given):
            return None
        model = retune(replace(prepared, arm=_with(arm, lengths)), floor, base.placed, known=model.fit)
        if not finite(model):
            return None
        if np.max(np.abs(step)) < SETTLED:
            break
    after = _over(model, floor)
    closed = np.maximum(after - 1.0, 0.0) < LEFT * (before - 1.0)
    kept = after < np.maximum(WORSE * before, 1.0)
    other = np.abs(lengths - given) > LEAST * given
    return lengths if np.any(out & closed) and np.all(kept) and np.any(other) else None


def told_lengths(prepared: Prepared) -> list[str]:
    """Return a warning for each link that has not the length of the arm file."""
    return [
        f"{own.name}: the recordings ask for a length of {own.length:.3g} m, and the arm file has {said.length:.3g} m; "
        "the gap is judged with what they ask for: measure the link, for gravity of another size looks the same"
        for own, said in zip(prepared.arm.joints, prepared.file_arm.joints, strict=True)
        if abs(own.length - said.length) > LEAST * said.length
    ]


def _over(model: Model, floor: np.ndarray) -> np.ndarray:
    return np.asarray(np.mean(model.whole**2, axis=0) / floor**2)


def _with(arm: Arm, lengths: Sequence[float] | np.ndarray) -> Arm:
    pairs = zip(arm.joints, lengths, strict=True)
    return replace(arm, joints=tuple(replace(joint, length=float(length)) for joint, length in pairs))


def _step(prepared: Prepared, model: Model, floor: np.ndarray, joints: Sequence[int]) -> tuple[float, np.ndarray]:
    """Return what a step of some joints' lengths promises, all else following, and the step, in parts of each."""
    projector = Projector(model.fit, weights_of(model, prepared, floor), np.arange(len(model.fit.residual)))
    own = np.array([joint.length for joint in prepared.arm.joints])
    slopes = []
    for j in joints:
        changed = own.copy()
        changed[j] *= 1.0 + TWITCH
        path = SignalPath(_with(prepared.arm, changed), model.placed)
        slopes.append((Residual(path, prepared.fit, ()).value(model.fit.p) - model.fit.residual) / TWITCH)
    _, curvature, slope = projector.step(model.fit.residual, np.stack(slopes, axis=2))
    step = -np.linalg.solve(curvature + np.eye(len(joints)) / USUAL**2, slope)
    return float(-slope @ step - 0.5 * step @ curvature @ step), step
