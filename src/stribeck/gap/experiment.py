"""The next experiment: the motion, or the change of arm or stand, that separates what these data cannot tell apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import stats

from stribeck.gap.changes import Change, changes
from stribeck.gap.model import Model, weights_of
from stribeck.gap.motions import Motion, family, reaches
from stribeck.gap.prepare import Prepared
from stribeck.gap.search import Step
from stribeck.gap.separation import AS_IT_IS, Candidate, Prospect, prospects
from stribeck.identify.conditioning import Conditioned, condition
from stribeck.run import Run

DURATION, TRIAL = 20.0, 6.0  # s: of what is proposed, and of what is tried
MOST = 3  # candidates
TOLD_APART = 2.0  # t value from which two models count as told apart
WORTH = 0.75  # probability of that from which a motion alone is proposed
CAREFUL = 0.9  # of the torque limit
STRONGER = 1.2  # of the largest recorded command, where the arm states no limit
SMALLER = (1.0, 0.6, 0.36)  # sizes that are tried where the torque does not do


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
        Effects.
    apart : float
        Expected t value between the two candidates that lie nearest, once everything is re-tuned.
    resolved : float
        Probability that it comes out over TOLD_APART.
    rivals : mapping
        ``apart`` of the motions that other criteria choose: ``d_optimal``, ``random`` (the mean over the family).
    reference : Run
        What a controller is to follow: ``q_ref``, ``dq_ref``, and as ``tau`` the torque that the best model needs.
    motion : Motion
        The reference's.
    """

    kind: str
    what: str
    separates: tuple[str, ...]
    apart: float
    resolved: float
    rivals: dict[str, float]
    reference: Run
    motion: Motion

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


def open_question(steps: Sequence[Step], *, unexplained: bool) -> tuple[Model, ...]:
    """Return the models that are to be told apart, the best first; none where there is no question.

    Parameters
    ----------
    steps : sequence of Step
        Of the search.
    unexplained : bool
        Whether nothing is named: the question is then which of the last step's rivals is on the right way.
    """
    if unexplained:
        step = steps[-1]
        gain = step.ranking.overall[1:]
        order = [int(k) + 1 for k in np.argsort(-gain) if np.isfinite(gain[k]) and gain[k] > 0.0]
        return tuple(step.rivals[k - 1] for k in order[:MOST]) if len(order) > 1 else ()
    for step in reversed([step for step in steps if step.taken and step.best is not None]):
        ranking = step.ranking
        others = sorted((k for k in ranking.twins() if k != ranking.best), key=lambda k: -ranking.overall[k])
        if others:
            return tuple(step.rivals[k - 1] for k in [ranking.best, *others][:MOST])
    return ()


def next_experiment(prepared: Prepared, models: Sequence[Model], floor: np.ndarray) -> Experiment | None:
    """Return the experiment that tells models apart best; None where no motion is within the arm's torque.

    Parameters
    ----------
    prepared : Prepared
        The recordings so far.
    models : sequence of Model
        At least two, the likeliest first, fitted to them.
    floor : array (n,)
        Noise floor, N m rms.
    """
    plan = _Plan(prepared, tuple(models), floor)
    tried = plan.tried(family(prepared.arm, [model.placed[-1].joint for model in models]))
    return plan.chosen(tried) if tried else None


class _Plan:
    """The candidates, and what the arm can do."""

    def __init__(self, prepared: Prepared, models: tuple[Model, ...], floor: np.ndarray) -> None:
        self.prepared, self.models = prepared, models
        self.weights = weights_of(models[0].fit.residual, prepared, floor)
        self.runs = (*prepared.fit, *prepared.held)
        self.reach = reaches(self.runs, prepared.cutoff)
        self.step = min(run.run.sample_time for run in self.runs)
        largest = np.max([np.abs(run.run.tau).max(axis=0) for run in self.runs], axis=0)
        stated = [
            np.nan if joint.torque_limit is None else CAREFUL * joint.torque_limit for joint in prepared.arm.joints
        ]
        self.limit = np.where(np.isnan(stated), STRONGER * largest, stated)
        self.candidates = [Candidate(prepared.arm, model, self.weights) for model in models]

    def planned(self, motion: Motion, duration: float) -> Conditioned:
        """Return a motion as if it had been recorded."""
        t = self.step * np.arange(round(duration / self.step) + 1, dtype=np.float64)
        q = motion.course(t, self.reach)
        noise = np.median([run.noise for run in self.runs], axis=0)
        run = Run(motion.kind, t, q, np.zeros_like(q))
        return condition(self.prepared.arm, run, self.prepared.cutoff, noise, thin=True)

    def tried(self, motions: Sequence[Motion]) -> list[tuple[Motion, Prospect]]:
        """Return motions, made smaller where the arm's torque asks for it, with what they promise; some drop out."""
        out: list[tuple[Motion, Prospect]] = []
        for size in SMALLER:
            scaled = [replace(motion, size=size) for motion in motions]
            found = prospects(self.candidates, [self.planned(motion, TRIAL) for motion in scaled]) if scaled else []
            able = [bool(np.all(prospect.torque <= self.limit)) for prospect in found]
            out += [pair for pair, fits in zip(zip(scaled, found, strict=True), able, strict=True) if fits]
            motions = [motion for motion, fits in zip(motions, able, strict=True) if not fits]
        return out

    def chosen(self, tried: Sequence[tuple[Motion, Prospect]]) -> Experiment:
        """Return the best of the tried motions at its full length, with a change where no motion is enough."""
        best = max(tried, key=lambda pair: pair[1].least)
        classic = max(tried, key=lambda pair: pair[1].information)
        run = self.planned(best[0], DURATION)
        (prospect,) = prospects(self.candidates, [run])
        change, apart = AS_IT_IS, prospect.least
        if resolved(apart) < WORTH:
            change, apart = self.changed(run, apart)
        grown = prospect.least / max(best[1].least, 1e-12)
        rivals = {
            "d_optimal": classic[1].least * grown,
            "random": float(np.mean([pair[1].least for pair in tried])) * grown,
        }
        kind = "motion" if change is AS_IT_IS else "change"
        names = _names(self.models, self.prepared.arm.names)
        what = self.words(best[0], change)
        return Experiment(kind, what, names, apart, resolved(apart), rivals, self.reference(run), best[0])

    def changed(self, run: Conditioned, apart: float) -> tuple[Change, float]:
        """Return the change that tells apart best along a motion, where it does better than none."""
        best = (AS_IT_IS, apart)
        for change in changes(self.prepared.arm, [model.placed[-1].joint for model in self.models]):
            arm = self.prepared.arm
            (prospect,) = prospects([Candidate(arm, model, self.weights, change) for model in self.models], [run])
            if prospect.least > best[1] and np.all(prospect.torque <= self.limit):
                best = (change, prospect.least)
        return best

    def words(self, motion: Motion, change: Change) -> str:
        """Return what to do as a sentence."""
        path = f"{motion.words(self.prepared.arm)}, {DURATION:g} s"
        if change is AS_IT_IS:
            return f"Record {path}, and diagnose it together with the runs so far."
        return (
            f"No motion is enough: {change.words}, record {path}, and diagnose that by itself with an arm file that "
            "says so; the right cause keeps its parameters."
        )

    def reference(self, run: Conditioned) -> Run:
        """Return the reference of a planned run, with the torque that the best model needs along it."""
        (made,) = self.candidates[0].driven([run])
        t, q = run.run.t, run.run.q
        tau = np.stack([np.interp(t, made.time, made.command[:, j]) for j in range(q.shape[1])], axis=1)
        rate = np.gradient(q, self.step, axis=0)
        return Run("next_reference.csv", t, q, tau, q_ref=q, dq_ref=rate)


def _names(models: Sequence[Model], joints: Sequence[str]) -> tuple[str, ...]:
    """Return the models' last effects, with their joints where one effect is at several."""
    last = [model.placed[-1] for model in models]
    names = [place.effect.name for place in last]
    if len(set(names)) == len(names):
        return tuple(names)
    return tuple(f"{place.effect.name} at {joints[place.joint]}" for place in last)


def resolved(apart: float) -> float:
    """Return the probability that models expected to be ``apart`` (a t value) come out over TOLD_APART."""
    return float(stats.norm.cdf(apart - TOLD_APART))
