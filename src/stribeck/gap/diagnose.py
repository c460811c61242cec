"""The diagnosis: re-tune, search, and say where, which and how far."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stribeck.arm import Arm
from stribeck.effects.placing import stated_effects
from stribeck.errors import WARNING, InputError
from stribeck.gap.answer.assembly import Assembly
from stribeck.gap.answer.conventions import told_recorded
from stribeck.gap.answer.recordings import alike_now, held_alone, recordings_of
from stribeck.gap.fitted.carrying import LOAD, carrying, told_apart
from stribeck.gap.records.observed import observe
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.gap.records.standing import check_motion
from stribeck.gap.result import Diagnosis, Recording
from stribeck.gap.search.lengths import of_asked_lengths
from stribeck.gap.search.search import search
from stribeck.gap.search.setting import Asked, Progress
from stribeck.gap.search.step import Step, last_model
from stribeck.gap.search.tuned import Retuned, retuned
from stribeck.run import Run, check_apart


def diagnose(
    arm: Arm,
    runs: Sequence[Run],
    held_out: Sequence[Run] = (),
    *,
    seed: int = 0,
    jobs: int = 2,
    leave_out: Sequence[str] = (),
    progress: Progress = lambda text: None,
) -> Diagnosis:
    """Diagnose the gap between an arm's model and its recordings.

    Parameters
    ----------
    arm : Arm
        The nominal arm; effects in its file are part of the nominal model.
    runs, held_out : sequence of Run
        Recordings to fit and to judge by; without the latter some of ``runs`` are kept back, but not one that leaves a
        re-tuned model, or the one that a search has come to, far more than all fitted ones do: what these do not show
        cannot be learnt from them.
    seed : int
        Of all resampling.
    jobs : int
        Processes.
    leave_out : sequence of str
        Effects that are no candidates.
    progress : callable
        Told in words what is being done; what begins with "warning: " is to stay in sight.

    Raises
    ------
    InputError
        When a run has not the arm's joints, or is there twice, or has the name of another, or no joint moves in any.
    """
    check_apart((*runs, *held_out))
    for run in (*runs, *held_out):
        if run.n != arm.n:
            raise InputError(f"{run.name}: not a recording of this arm", f"{run.n} joints", f"the arm has {arm.n}")
    asked = Asked(seed, jobs, tuple(leave_out), progress)
    progress("conditioning the recordings")
    prepared = prepare(arm, runs, held_out)
    check_motion(arm, (*prepared.fit, *prepared.held))
    tuned = _told_apart(retuned(prepared, asked), arm, () if held_out else runs, asked)
    for text in told_recorded(tuned.prepared, tuned.given):  # before the search, which takes long and for nothing
        progress(f"{WARNING}{text}")
    tuned = _measured(tuned, asked)
    first = recordings_of(tuned.prepared, tuned.base, tuned.base, tuned.noise.rms)
    found = None
    if not held_out:
        found = _with_alone(arm, runs, first, asked)
    if found is None:
        found = searched_from(tuned, asked)
        left = _left_by(found)  # what stood out may have been hidden by what all runs have
        if not held_out and held_alone(left) != held_alone(first):
            again = _with_alone(arm, runs, left, asked)
            found = again or found
    seen = observe(arm, (*runs, *held_out), found.prepared.scales, leave_out=leave_out)
    progress("simulating the held-out runs")
    return Assembly(
        found.prepared, seen, found.given, found.noise, found.steps[-1].floor, found.steps, seed
    ).diagnosis()


@dataclass(frozen=True)
class Searched:
    """A finished search: its steps, and on the held-out runs (M, n) the residual as given and its noise floor, N m.

    ``prepared`` are the recordings that it saw, with the noise of their rows.
    """

    prepared: Prepared
    given: np.ndarray
    noise: np.ndarray
    steps: tuple[Step, ...]


def searched(prepared: Prepared, asked: Asked) -> Searched:
    """Re-tune the nominal model and search for what it lacks.

    Parameters
    ----------
    prepared : Prepared
        The recordings, conditioned.
    asked : Asked
    """
    tuned = retuned(prepared, asked)
    return searched_from(tuned, asked)


def searched_from(tuned: Retuned, asked: Asked) -> Searched:
    """Search for what the re-tuned model lacks.

    Parameters
    ----------
    tuned : Retuned
    asked : Asked
    """
    tuned, steps = search(tuned, asked)
    floor = tuned.noise.rms
    more = np.maximum(steps[-1].floor ** 2 - floor**2, 0.0)
    return Searched(tuned.prepared, tuned.given, np.sqrt(tuned.noise.held**2 + more), steps)


def _with_alone(arm: Arm, runs: Sequence[Run], before: Sequence[Recording], asked: Asked) -> Searched | None:
    """Return a search that is told what held-out runs alone have shown, or None.

    None where none shows more than all fitted ones, by what a model left of them ``before``, or must judge, or where no
    effect of one arm makes it like these.
    """
    alone = held_alone(before)
    if not alone:
        return None
    prepared = prepare(arm, runs, fitted=alone)
    if {run.name for run in prepared.held} & set(alone):
        return None
    asked.progress(f"once more, with {', '.join(alone)} among what is fitted")
    found = searched_from(_measured(_told_apart(retuned(prepared, asked), arm, (), asked), asked), asked)
    return found if alike_now(before, _left_by(found)) else None


def _told_apart(tuned: Retuned, arm: Arm, runs: Sequence[Run], asked: Asked) -> Retuned:
    """Return re-tuned recordings of which some are told to be without a load that the others carry, if they are.

    Some of each kind are fitted, if need be by keeping back others of the ``runs`` that may be.
    """
    if LOAD in (*asked.leave_out, *(place.effect.name for place in stated_effects(arm))):
        return tuned
    found = carrying(tuned.prepared, tuned.base, tuned.noise.rms)
    if found is None:
        return tuned
    fitted = {run.name for run in tuned.prepared.fit}
    missing = [kind[0] for kind in (found.loaded, found.unloaded) if not fitted & set(kind)]
    if missing and runs:
        return _told_apart(retuned(prepare(arm, runs, fitted=missing), asked), arm, (), asked)
    return replace(tuned, prepared=told_apart(tuned.prepared, found))


def _measured(tuned: Retuned, asked: Asked) -> Retuned:
    """Return re-tuned recordings of an arm whose links are as long as they ask for."""
    return of_asked_lengths(tuned, [tuned.base], tuned.noise.rms, asked) or tuned


def _left_by(found: Searched) -> tuple[Recording, ...]:
    """Return what each recording leaves with everything that a search took."""
    steps = found.steps
    return recordings_of(found.prepared, steps[0].base, last_model(steps), steps[-1].floor)
