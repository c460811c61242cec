"""What is said of the next experiment, and of questions that none answers."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from itertools import combinations

import numpy as np

from stribeck.arm import unit_at
from stribeck.gap.experiment.choice import LITTLE, Choice
from stribeck.gap.experiment.plan import Plan
from stribeck.gap.experiment.separation import AS_IT_IS
from stribeck.gap.fitted.model import Model
from stribeck.run import Run

SLACK = 0.01  # of the recorded range and speed: what noise and filters make of these


def what_to_do(plan: Plan, choice: Choice, reference: Run) -> str:
    """Return what to do as a sentence, and what to mind."""
    arm = plan.prepared.arm
    path = f"{choice.programme.words(arm)} ({plan.duration(choice):.3g} s in all)"
    mind = "".join(f" {text}" for text in (*_beyond(plan, reference), *_left(choice, names_of(plan.models, arm.names))))
    if choice.change is AS_IT_IS:
        return f"Record {path}, and diagnose it together with the runs so far.{mind}"
    if not choice.change.words:
        return (
            f"Record {path}, and diagnose that by itself with {choice.change.known_by}: together with the runs so far, "
            f"what these candidates have in common would outweigh what tells them apart.{mind}"
        )
    return (
        f"No motion is enough: {choice.change.words}, record {path}, and diagnose that by itself with "
        f"{choice.change.known_by}.{mind}"
    )


def _beyond(plan: Plan, reference: Run) -> list[str]:
    """Return in what a reference goes beyond the recordings."""
    arm, seen = plan.prepared.arm, plan.recorded
    low, high = reference.q.min(axis=0), reference.q.max(axis=0)
    speed = np.abs(np.gradient(reference.q, plan.step, axis=0)).max(axis=0)
    room = SLACK * (seen.high - seen.low)
    further, faster = (low < seen.low - room) | (high > seen.high + room), speed > (1.0 + SLACK) * seen.speed
    ranges = [
        f"{arm.names[j]} {_number(low[j])} to {_number(high[j])} {unit_at('rad', arm.kinds[j])} "
        f"(recorded {_number(seen.low[j])} to {_number(seen.high[j])})"
        for j in np.flatnonzero(further)
    ]
    speeds = [
        f"{arm.names[j]} {_number(speed[j])} {unit_at('rad/s', arm.kinds[j])} (recorded {_number(seen.speed[j])})"
        for j in np.flatnonzero(faster)
    ]
    told = [f"This goes further than recorded, make sure that the arm has room: {', '.join(ranges)}."] if ranges else []
    return [*told, f"This is faster than recorded: {', '.join(speeds)}."] if speeds else told


def _number(value: float) -> str:
    return f"{round(float(value), 6) + 0.0:.3g}"


def _left(choice: Choice, names: Sequence[str]) -> list[str]:
    """Return what is not told apart: groups of which no two are, each as large as can be."""
    little, groups = choice.chances < LITTLE, list[tuple[int, ...]]()
    for size in range(len(names), 1, -1):
        for group in combinations(range(len(names)), size):
            alike = all(little[i, j] for i, j in combinations(group, 2))
            if alike and not any(set(group) <= set(other) for other in groups):
                groups.append(group)
    said = "; ".join(_listed([_said(names[i]) for i in group]) for group in groups)
    return [f"It does not tell apart: {said}."] if said else []


def _said(name: str) -> str:
    effect, at, joint = name.partition(" at ")
    return f"{effect.replace('_', ' ')}{at}{joint}"


def _listed(names: Sequence[str]) -> str:
    return f"{', '.join(names[:-1])} and {names[-1]}"


def names_of(models: Sequence[Model], joints: Sequence[str]) -> tuple[str, ...]:
    """Return the models' last effects, with their joints where one effect is at several."""
    last = [model.placed[-1] for model in models]
    names = [place.effect.name for place in last]
    if len(set(names)) == len(names):
        return tuple(names)
    return tuple(f"{place.effect.name} at {joints[place.joint]}" for place in last)


def told_late(late: Collection[str]) -> list[str]:
    """Return a note on effects that no motion tells apart, where there are several."""
    if len(late) < 2:
        return []
    said = " and ".join(name.replace("_", " ") for name in late)
    return [
        f"no motion tells apart: {said}, as every joint is late by as much; the drive's own measured torque "
        "(tau_meas), recorded alongside, does"
    ]


def told_inseparable(models: Sequence[Model], joints: Sequence[str]) -> list[str]:
    """Return a note that no experiment was found that tells some models apart; none of less than two models."""
    if len(models) < 2:
        return []
    said = ", ".join(_said(name) for name in names_of(models, joints))
    return [f"no experiment was found that tells apart: {said}"]


def told_swung(swung: Collection[str]) -> list[str]:
    """Return a note on joints that move without a drive, where there are any."""
    if not swung:
        return []
    one = len(swung) == 1
    joints = f"joint{'' if one else 's'} {', '.join(swung)} {'moves, but is' if one else 'move, but are'}"
    return [f"no motion is planned: {joints} driven in no recording"]
