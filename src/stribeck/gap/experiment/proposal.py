"""The next experiment: the motion, or the change of arm or stand, that separates what these data cannot tell apart."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field

import numpy as np

from stribeck.gap.experiment.changes import Change
from stribeck.gap.experiment.choice import LITTLE, Choice, resolved
from stribeck.gap.experiment.plan import Plan, swung
from stribeck.gap.experiment.programme import Programme
from stribeck.gap.experiment.separation import AS_IT_IS
from stribeck.gap.experiment.wording import names_of, what_to_do
from stribeck.gap.fitted.model import Model
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.search.step import Step, alike
from stribeck.run import Run

MOST = 4  # candidates
WORTH = 0.75  # probability of that from which no more is asked of the arm
FAINT = 1.0  # t value up to which two models are as good as not set apart
# of it, what motions beyond the recorded ones must add, and what is laborious, a change: that must promise it, too
MORE, CHANGED = 0.05, 0.2


@dataclass(frozen=True)
class Experiment:
    """What to record next.

    Attributes
    ----------
    kind : str
        ``motion`` or ``change``.
    what : str
        What to do, a sentence.
    separates : tuple of str
        Effects, those that it has a chance to tell from another one.
    apart : float
        Expected t value between the likeliest candidate and the one that lies nearest to it, everything re-tuned.
    resolved : float
        Probability that the search tells which is true, whichever it is.
    rivals : mapping
        ``apart`` of programmes that other criteria choose: ``d_optimal``, ``random`` (the mean over many).
    reference : Run
        What a controller is to follow: ``q_ref``, ``dq_ref``, and as ``tau`` the torque that the best model needs.
    programme : Programme
        The reference's.
    change : Change
        What is to be changed before.
    wider : float
        Factor on the recorded range and speed.
    """

    kind: str
    what: str
    separates: tuple[str, ...]
    apart: float
    resolved: float
    rivals: dict[str, float]
    reference: Run
    programme: Programme
    change: Change = field(default=AS_IT_IS)
    wider: float = 1.0

    def plain(self) -> dict[str, object]:
        """Return it as ``diagnosis.json`` has it."""
        return {
            "kind": self.kind,
            "what": self.what,
            "separates": list(self.separates),
            "expected_gain": {
                "t": self.apart,
                "probability_resolved": self.resolved,
                **{f"t_{name}": value for name, value in self.rivals.items()},
            },
            "reference": self.reference.name,
        }


def open_question(steps: Sequence[Step], named: Collection[str] | None = None) -> tuple[Model, ...]:
    """Return the models that are to be told apart, the best first; none where there is no question.

    Parameters
    ----------
    steps : sequence of Step
        Of the search.
    named : collection of str, or None
        The effects in question, those that are named. None: nothing is; where no step has left a class, the question is
        then which rival is on the right way.
    """
    for step in reversed([step for step in steps if step.taken]):
        if step.best is None or (named is not None and step.best.placed[-1].effect.name not in named):
            continue
        same = alike(step, steps)
        if len(same) > 1:
            return tuple(step.rivals[k - 1] for k in same[:MOST])
        if step.as_good:
            return step.as_good[:MOST]
    if named is not None:
        return ()
    step = steps[0]
    gain = step.ranking.overall[1:]
    order = [int(k) + 1 for k in np.argsort(-gain) if np.isfinite(gain[k]) and gain[k] > 0.0]
    return tuple(step.rivals[k - 1] for k in order[:MOST]) if len(order) > 1 else ()


def next_experiment(
    prepared: Prepared, models: Sequence[Model], floor: np.ndarray, *, as_it_is: bool = False
) -> Experiment | None:
    """Return the experiment that tells models apart best; None where none tells any, or is within the arm's torque.

    None, too, where others swing a joint without a drive: how it would move is not planned.

    First motions that stay within what the recordings show of the arm; then, if these promise too little, wider and
    faster ones within its torque; then a change of the arm or its stand, with the motion that is best for that.

    Parameters
    ----------
    prepared : Prepared
        The recordings so far.
    models : sequence of Model
        At least two, the likeliest first, fitted to them.
    floor : array (n,)
        Noise floor, N m rms.
    as_it_is : bool
        Without a change: where the cause may be none of the models, it is motions, diagnosed together with the runs so
        far, that may bring it out, also where they tell none of the models.
    """
    if swung(prepared):
        return None
    plan = Plan(prepared, tuple(models), floor)
    best: Choice | None = None
    for choice in plan.choices(as_it_is=as_it_is):
        if best is None or _better(choice, best):
            best = choice
        if _promise(best) > WORTH:
            break
    if best is None or (best.furthest <= FAINT and not as_it_is):
        return None
    return _experiment(plan, best)


def _better(choice: Choice, best: Choice) -> bool:
    """Return whether a choice promises enough beyond the best one so far for what it asks.

    Any more is enough for one that sets the likeliest model apart where the other one does not, if it is not laborious
    for next to nothing.
    """
    if choice.change.words and _promise(choice) < CHANGED:
        return False
    laborious = bool(choice.change.words) and not best.change.words
    enough = 0.0 if best.apart <= FAINT < choice.apart else CHANGED if laborious else MORE
    return _promise(choice) > _promise(best) + enough


def _experiment(plan: Plan, choice: Choice) -> Experiment:
    reference = plan.reference(choice)
    names, told = names_of(plan.models, plan.prepared.arm.names), np.any(choice.chances >= LITTLE, axis=1)
    return Experiment(
        kind="change" if choice.change.words else "motion",
        what=what_to_do(plan, choice, reference),
        separates=tuple(name for name, apart in zip(names, told, strict=True) if apart),
        apart=choice.apart,
        resolved=_promise(choice),
        rivals={
            "d_optimal": plan.classic(choice.options).apart,
            "random": float(np.mean([other.apart for other in plan.at_random(choice.options)])),
        },
        reference=reference,
        programme=choice.programme,
        change=choice.change,
        wider=choice.options.wider,
    )


def without_twins(models: Sequence[Model], late: Collection[str]) -> tuple[Model, ...]:
    """Return models of which no two are late by the same of one record or the other: no motion tells these apart.

    Parameters
    ----------
    models : sequence of Model
    late : collection of str
        Effects of which that is so.
    """
    twins = [model for model in models if model.placed[-1].effect.name in late]
    return tuple(model for model in models if model not in twins[1:])


def _promise(choice: Choice) -> float:
    return resolved(choice.nearest, choice.needed)
