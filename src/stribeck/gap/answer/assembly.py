"""A finished search put together as a diagnosis: stages, causes, probabilities, traces and corrected arms."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from stribeck.effects.placing import stated_effects
from stribeck.gap.answer.as_sampled import told_as_sampled
from stribeck.gap.answer.closing import Closing
from stribeck.gap.answer.conventions import told_recorded
from stribeck.gap.answer.delivered import delivered, told_lacking
from stribeck.gap.answer.late_alone import told_late_alone
from stribeck.gap.answer.listing import candidates_of, traces_of
from stribeck.gap.answer.loads import told_carried, told_loads
from stribeck.gap.answer.motion import HORIZON, Motions, told_strayed
from stribeck.gap.answer.noise import heard, heard_through
from stribeck.gap.answer.off_the_line import told_off_the_line
from stribeck.gap.answer.places import places
from stribeck.gap.answer.recordings import recordings_of, told_alone
from stribeck.gap.answer.stages import missed, stages_of, told_missed, told_worse
from stribeck.gap.answer.standing import standing
from stribeck.gap.answer.values import laws_of, parameters_of, tuned_of
from stribeck.gap.answer.verdict import (
    AT_FLOOR,
    EXPLAINED,
    NAMED_OVER,
    NONE_OVER,
    late_as_one,
    named_of,
    no_gap_probability,
    shaken,
    suspected,
    with_observed,
)
from stribeck.gap.answer.where import regions
from stribeck.gap.experiment.plan import swung
from stribeck.gap.experiment.proposal import Experiment, next_experiment, open_question, without_twins
from stribeck.gap.experiment.wording import told_inseparable, told_late, told_swung
from stribeck.gap.fitted.band import band_of, told_band
from stribeck.gap.fitted.corrected import arm_of
from stribeck.gap.fitted.model import Model
from stribeck.gap.records.blocks import resampled
from stribeck.gap.records.observed import Observation
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.records.sequence import on_average
from stribeck.gap.records.unsaid import told_of
from stribeck.gap.result import Cause, Diagnosis, Estimate
from stribeck.gap.search.lengths import told_lengths
from stribeck.gap.search.look_alike import doubt, told_alike
from stribeck.gap.search.ordinary import told_ordinary, told_unnamed
from stribeck.gap.search.random_torque import loud
from stribeck.gap.search.step import Step, last_model
from stribeck.model.path import SignalPath


class Assembly:
    """The parts of a finished search, put together as a :class:`Diagnosis`.

    Parameters
    ----------
    prepared : Prepared
    seen : Observation
        Effects that the records show by themselves.
    given : array (K, n)
        Residual of the arm file's model on the held-out runs, N m.
    noise : array (K, n)
        Its noise floor row by row, N m.
    floor : array (n,)
        Noise floor by which the last step was judged, N m rms.
    steps : sequence of Step
        Of a finished search.
    seed : int
        Of all resampling.
    """

    def __init__(
        self,
        prepared: Prepared,
        seen: Observation,
        given: np.ndarray,
        noise: np.ndarray,
        floor: np.ndarray,
        steps: Sequence[Step],
        seed: int,
    ) -> None:
        self.prepared, self.given, self.seed = prepared, given, seed
        self.seen = seen
        self.steps = tuple(steps)
        self.base = steps[0].base
        self.heard = heard(prepared, last_model(steps), noise, floor, seed)
        self.floor = self.heard.floor  # by which the search's models compare
        taken = [step.best for step in steps if step.taken and step.best is not None]
        again = [step.base for step in self.steps[1:]]  # what was taken, fitted once more with weights of its own
        self.models: list[Model] = [self.base, *again, *taken[len(again) :]]
        self.closing = Closing(self.base, self.heard, *resampled(prepared.held, 400, seed))

    def diagnosis(self) -> Diagnosis:
        """Return the diagnosis."""
        arm, prepared = self.prepared.arm, self.prepared
        motions = Motions(prepared)
        stands = standing(prepared, self.steps, self.models, self.floor, self.closing, motions)
        causes, chain = stands.causes, stands.chain
        in_torque = named_of(causes)
        if in_torque:
            self.heard = heard_through(prepared, chain, self.steps[-1].floor, self.seed)
            self.closing = replace(self.closing, heard=self.heard)
        causes = [self._with_details(cause, chain if cause.effect in in_torque else self.models) for cause in causes]
        final = chain[-1]
        astray = missed(prepared, self.closing.left(final), self.heard.floor)
        verdict, causes = self._verdict(final, in_torque, causes, stands.left_over, followed=not astray)
        silent = verdict == "no_gap"
        alike = {(cause.effect, joint): names for cause in causes for joint, names in cause.alike.items()}
        closed = self.closing.by(final) if in_torque and self.closing.any_gap() else None
        unexplained = verdict == "unexplained"  # in torque, whatever is seen in the records themselves
        verdict, causes = with_observed(verdict, causes, self.seen.causes, len(in_torque))
        named = (*(cause.effect for cause in self.seen.causes), *in_torque)
        every = (*prepared.fit, *prepared.held)
        worn = on_average(SignalPath(arm, final.placed), final.fit.p, every)
        arms = {
            "as_given": prepared.file_arm,
            "retuned": arm_of(arm, self.base.fit, self.base.placed),
            "corrected": arm_of(arm, final.fit, (*worn, *self.seen.placed)),
        }
        experiment, inseparable = self._experiment(causes, unexplained=unexplained)
        tuned = tuned_of(self.base, prepared, self.floor)
        told = self.heard
        stages, missing = stages_of(motions, self.given, chain, [self.closing.left(m) for m in chain], told.floor)
        by_joint, before_measurement = delivered(prepared, self.base, self.steps[-1].floor, self.seed)
        recordings = recordings_of(told.prepared, self.base, final, told.floor)
        return Diagnosis(
            arm=arm.name,
            joints=arm.names,
            fit_runs=tuple(dict.fromkeys(run.name for run in prepared.fit)),
            held_out_runs=tuple(dict.fromkeys(run.name for run in prepared.held)),
            verdict=verdict,
            named=named,
            horizon=HORIZON,
            stages=stages,
            closed=closed,
            where=() if silent else places(prepared, chain, told.rows, alike, self.seed),
            regions=regions(prepared, self.base.held, final.held, told.rows, self.seed),
            recordings=recordings,
            causes=tuple(causes),
            candidates=candidates_of(self.steps, arm.names),
            tuned=tuned,
            corrected=() if final is self.base else tuned_of(final, prepared, self.floor),
            traces=traces_of(prepared, self.given, self.base, final),
            models={name: prepared.as_stated(one) for name, one in arms.items()},
            notes=(
                *prepared.notes,
                *told_band(prepared),
                *self.seen.notes,
                *told_ordinary(self.base, stated_effects(arm), arm),
                *told_unnamed(self.steps, prepared.scales, arm, beside=bool(in_torque)),
                *told_off_the_line(arm, causes, named),
                *told_carried(prepared, in_torque),
                *told_as_sampled(causes, named, max(run.run.sample_time for run in every)),
                *inseparable,
                *told_lacking(prepared),
            ),
            warnings=(
                *prepared.warnings,
                *told_recorded(prepared, self.given),
                *told_lengths(prepared),
                *missing,
                *told_strayed(stands.strayed),
                *(told_worse(stages, arm) if unexplained else ()),
                *(told_missed(astray, arm) if named else ()),
                *loud(told.random, arm.names, self.steps[-1].floor),
                *told_of(tuned),
                *told_alone(recordings),
                *told_late_alone(told.prepared, (self.base, final), told.floor),
                *told_loads(told.prepared, (self.base, final), told.floor, in_torque),
                *(told_alike(self.steps, arm.names) if verdict != "no_gap" else ()),
                *_limits(final),
            ),
            next_experiment=experiment.plain() if experiment else None,
            next_reference=experiment.reference if experiment else None,
            delivered=by_joint,
            before_measurement=before_measurement,
            random=told.random,
            settings={"seed": self.seed, **band_of(prepared), "horizon_s": HORIZON},
        )

    def _verdict(
        self, final: Model, named: tuple[str, ...], causes: list[Cause], left_over: float, *, followed: bool
    ) -> tuple[str, list[Cause]]:
        """Return the verdict, and the causes with what is left for ``none`` and ``unknown``.

        A model that has not ``followed`` the recorded torque explains no gap, however much it closes.
        """
        ratio = float(np.max(np.sqrt(np.mean(self.closing.left(final) ** 2, axis=0)) / self.heard.floor))
        if named:
            closed = ratio < AT_FLOOR or self.closing.by(final).value > EXPLAINED
            verdict = "explained" if closed and followed else "partly_explained"
            return verdict, [*causes, Cause("unknown", left_over)]
        silent = no_gap_probability(self.steps[0], self.prepared.noise, self.floor, self.prepared.scales)
        none = silent * max(left_over - doubt(self.steps), 0.0)
        nothing = Cause("none", none)
        rest = left_over - nothing.probability
        if none > NONE_OVER:
            listed = {cause.effect for cause in causes}
            outside = shaken(nothing, self.steps[0], [row.joint for row in self.heard.random], listed)
            return "no_gap", [*causes, *outside, Cause("unknown", rest)]
        if causes:
            return "unexplained", [*causes, nothing, Cause("unknown", rest)]
        return "unexplained", [nothing, *suspected(self.steps[-1], rest, self.prepared.arm.names)]

    def _experiment(self, causes: Sequence[Cause], *, unexplained: bool) -> tuple[Experiment | None, list[str]]:
        """Return what would tell apart what these data cannot, where there is such a question; a note if nothing is."""
        ambiguous = {c.effect for c in causes if (c.presence or 0.0) > NAMED_OVER and len(c.equivalent) > 1}
        late = [] if unexplained else _as_late(causes, late_as_one(self.steps, self.prepared.arm.n))
        asked = open_question(self.steps, None if unexplained else ambiguous)
        models = without_twins(asked, late)
        several = len(models) > 1
        found = next_experiment(self.prepared, models, self.floor, as_it_is=unexplained) if several else None
        none = [] if found or unexplained else told_inseparable(models, self.prepared.arm.names)
        undriven = told_swung(swung(self.prepared)) if several else []
        return found, [*none, *undriven, *told_late(late)]

    def _with_details(self, cause: Cause, chain: Sequence[Model]) -> Cause:
        """Return a cause with its parameters from the last of a chain of models, and what its own steps close."""
        parameters = parameters_of(cause, chain[-1], self.prepared, self.floor)
        closes = self.closing.by_effect(cause.effect, chain) if self.closing.any_gap() else Estimate(0.0, 0.0, 0.0)
        added = self.models[-1].placed[len(self.base.placed) :]
        return replace(cause, parameters=parameters, closes=closes, law=laws_of(cause, added, self.prepared.arm))


def _as_late(causes: Sequence[Cause], late: Collection[str]) -> list[str]:
    """Return those effects of a class of named ones of which all joints may be ``late`` by the same."""
    named = [cause for cause in causes if (cause.presence or 0.0) > NAMED_OVER and cause.effect in late]
    return list(dict.fromkeys(effect for cause in named for effect in cause.equivalent if effect in late))


def _limits(model: Model) -> list[str]:
    """Return what to mind of the values of the model that is delivered."""
    return [
        f"{key}: the data push it to three standard deviations from its nominal value or beyond"
        for key in model.fit.at_limit
    ]
