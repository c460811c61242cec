"""Which programme of motions promises most: every kind tried once, the best put together part by part."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from stribeck.gap.experiment.changes import Change, changes
from stribeck.gap.experiment.choice import Choice, Options, SoFar
from stribeck.gap.experiment.motions import Motion, Reach, family, reaches, recorded
from stribeck.gap.experiment.programme import Programme, shortest, times
from stribeck.gap.experiment.separation import ANEW, AS_IT_IS, Candidate, Prospect, prospects
from stribeck.gap.fitted.model import Model, fit_model, weights_of
from stribeck.gap.records.floor import noise_of_rows
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.records.sequence import after
from stribeck.identify.conditioning import Conditioned, condition
from stribeck.model.path import SignalPath
from stribeck.run import Run

DURATION = 20.0  # s, of a programme, at most
PARTS = 3  # motions of a programme, at most
CAREFUL = 0.9  # of the torque limit
ASTRAY = 5.0  # noise rms: a motion of which a model leaves more, under its own commands, is not made by them
STRONGER = 1.2  # of the largest recorded command, where the arm states no limit
WIDER = 2.0  # range and speed, of the recorded ones, where the motions within these promise too little
SMALLER = (1.0, 0.6, 0.36)  # sizes that are tried where the torque does not do
SLOWER = (1.0, 1.4, 2.0, 2.8)  # times of the moves between motions, likewise
DRAWS = 20  # random programmes
SEED = 0  # of the encoder noise that a planned motion is told by


class Plan:
    """The models to be told apart, the model without their last effect, and what the arm can do.

    Parameters
    ----------
    prepared : Prepared
        The recordings so far.
    models : tuple of Model
        The likeliest first.
    floor : array (n,)
        Noise floor, N m rms.
    """

    def __init__(self, prepared: Prepared, models: tuple[Model, ...], floor: np.ndarray) -> None:
        self.prepared, self.models = prepared, models
        self.weights = weights_of(models[0], prepared, floor)
        before = weights_of(models[-1], prepared, floor)
        self.base = fit_model(prepared, models[0].placed[:-1], before, models[0].fit, evaluations=30)
        runs = (*prepared.fit, *prepared.held)
        self.seen = reaches(runs, prepared.cutoff)
        self.step = min(run.run.sample_time for run in runs)
        self.noise = np.median([run.noise for run in runs], axis=0)
        self.recorded = recorded(runs)
        largest = np.max([np.abs(run.run.tau).max(axis=0) for run in runs], axis=0)
        stated = [
            np.nan if joint.torque_limit is None else CAREFUL * joint.torque_limit for joint in prepared.arm.joints
        ]
        self.limit = np.where(np.isnan(stated), STRONGER * largest, stated)
        known = np.zeros_like(floor) if prepared.noise is None else np.mean(prepared.noise.fit**2, axis=0)
        self._even = np.maximum(np.mean(self.weights.sd**2, axis=0) - known, 0.0)
        self.candidates = self._candidates(AS_IT_IS)
        self._so_far = self._known(floor)
        self.joints = [model.placed[-1].joint for model in models]

    def _known(self, floor: np.ndarray) -> SoFar:
        whole = [model.whole for model in (*self.models, self.base)]
        power = np.array([np.sum(left**2, axis=0) for left in whole]) / (self._even + floor**2)
        gained = np.sum((power[-1] - power[:-1]) / self.weights.correlation, axis=1)
        return SoFar(float(len(whole[0]) / np.max(self.weights.correlation)), np.maximum(gained, 0.0))

    def _candidates(self, change: Change) -> list[Candidate]:
        models = (*self.models, self.base)
        return [Candidate(self.prepared.arm, model, self.weights, change) for model in models]

    def planned(self, name: str, q: np.ndarray, tau: np.ndarray | None = None) -> Conditioned:
        """Return positions (N, n), and commands where they are known, as if they had been recorded.

        A joint is held, or is not driven, where it was so in all recordings.
        """
        runs = (*self.prepared.fit, *self.prepared.held)
        t = self.step * np.arange(len(q), dtype=np.float64)
        run = Run(name, t, q, np.zeros_like(q) if tau is None else tau)
        recorded = condition(self.prepared.arm, run, self.prepared.cutoff, self.noise, thin=True)
        recorded = recorded.rolled_off(self.prepared.fit[0].corner)
        held, idle = np.all([run.braked for run in runs], axis=0), np.all([run.undriven for run in runs], axis=0)
        return replace(recorded, past=after(runs), braked=held, undriven=idle)

    def promised(self, motions: Sequence[Motion], reach: Sequence[Reach], change: Change = AS_IT_IS) -> list[Prospect]:
        """Return what each of some motions promises."""
        candidates = self.candidates if change is AS_IT_IS else self._candidates(change)
        runs = [self.planned(motion.kind, motion.course(times(self.step), reach)) for motion in motions]
        return prospects(candidates[:-1], runs, self._noise, candidates[-1:]) if runs else []

    def _noise(self, driven: Sequence[Conditioned]) -> list[np.ndarray]:
        """Return :meth:`noise_along` planned runs under a model's commands: at rest they say what friction is."""
        return [self.noise_along(self.planned(run.name, run.run.q, _at(run.run.t, run))) for run in driven]

    def noise_along(self, run: Conditioned) -> np.ndarray:
        """Return how widely the likeliest model's residual scatters (M, n) along a further run, N m.

        Its noise along that motion, and what it leaves of the recordings so far beyond theirs.
        """
        arm, model = self.prepared.arm, self.models[0]
        noise = noise_of_rows(arm, SignalPath(arm, model.placed), model.fit.p, [run], self.prepared.cutoff, SEED)
        return np.asarray(np.sqrt(noise**2 + self._even))

    def options(self, wider: float = 1.0) -> Options:
        """Return the motions of the family, made smaller where the arm's torque asks for it; some drop out."""
        reach = tuple(one.wider(wider) if wider > 1.0 else one for one in self.seen)
        motions: Sequence[Motion] = family(reach, self.joints)
        kept: list[tuple[Motion, Prospect]] = []
        for size in SMALLER:
            scaled = [replace(motion, size=size) for motion in motions]
            found = self.promised(scaled, reach)
            able = [self._makes(prospect) for prospect in found]
            kept += [pair for pair, fits in zip(zip(scaled, found, strict=True), able, strict=True) if fits]
            motions = [motion for motion, fits in zip(motions, able, strict=True) if not fits]
        return Options(tuple(motion for motion, _ in kept), tuple(prospect for _, prospect in kept), reach, wider)

    def _makes(self, prospect: Prospect) -> bool:
        """Return whether the arm makes a motion, whichever model is true: within its torque, without running away."""
        return bool(np.all(prospect.torque <= self.limit)) and prospect.left < ASTRAY

    def choices(self, *, as_it_is: bool = False) -> Iterator[Choice]:
        """Yield the best programme within what was recorded, that beyond it, and those to be diagnosed by themselves.

        These only if asked for: the same two without the runs so far, then those with a change, within what was
        recorded first.
        """
        known: list[Choice] = []
        for wider in (1.0, WIDER):
            options = self.options(wider)
            if options.motions:
                known.append(self.best(options))
                yield known[-1]
        if as_it_is:
            return
        for choice in known:
            yield replace(choice, options=replace(choice.options, change=ANEW))
        tilted = any(model.placed[-1].effect.name == "gravity_tilt" for model in self.models)
        for change in changes(self.prepared.arm, self.joints, tilted=tilted):
            for choice in known:
                changed = self._changed(choice.options, change)
                if changed.motions:
                    yield self.best(changed)

    def _changed(self, options: Options, change: Change) -> Options:
        """Return those of the options that the arm makes once it is changed."""
        again = self.promised(options.motions, options.reach, change)
        able = [k for k, prospect in enumerate(again) if self._makes(prospect)]
        motions = tuple(options.motions[k] for k in able)
        return replace(options, motions=motions, prospects=tuple(again[k] for k in able), change=change)

    def best(self, options: Options) -> Choice:
        """Return the programme that tells most about all pairs of models."""
        return self._grown(options, lambda prospect: prospect.worth)

    def classic(self, options: Options) -> Choice:
        """Return the D-optimal programme for the model without the effects in question."""
        return self._grown(options, lambda prospect: prospect.information)

    def at_random(self, options: Options, seed: int = 0) -> list[Choice]:
        """Return programmes of motions drawn from the options."""
        rng = np.random.default_rng(seed)
        draws = [rng.permutation(len(options.motions)) for _ in range(DRAWS)]
        return [self._filled(options, [int(k) for k in order]) for order in draws]

    def _grown(self, options: Options, score: Callable[[Prospect], float]) -> Choice:
        """Return a programme to which the part that raises a score most is added while time and torque allow it."""
        taken: list[int] = []
        programme = Programme(())
        for _ in range(PARTS):
            # none twice: where the models are wrong, another motion may still show it
            left = [k for k in range(len(options.motions)) if k not in taken]
            ranked = sorted(left, key=lambda k: -score(_together(options, [*taken, k])))
            able = ((k, made) for k in ranked if (made := self._able(options, [*taken, k])) is not None)
            more = next(able, None)
            if more is None:
                break
            taken.append(more[0])
            programme = more[1]
        return Choice(programme, _together(options, taken), options, self._so_far)

    def _able(self, options: Options, taken: Sequence[int]) -> Programme | None:
        """Return the quickest programme that the arm's torque allows, None where none is short enough."""
        quickest, _ = shortest([options.motions[k] for k in taken], self.step, options.reach)
        if len(taken) == 1:
            return quickest  # by itself a motion is known to be within the torque
        for slower in SLOWER:
            programme = replace(quickest, slower=slower)
            q = programme.course(self.step, options.reach)
            if self.step * (len(q) - 1) > DURATION:
                break
            if np.all(np.abs(self.followable(q, options.change).tau) <= self.limit):
                return programme
        return None

    def _filled(self, options: Options, order: Sequence[int]) -> Choice:
        taken: list[int] = []
        for k in order:
            if len(taken) < PARTS and self._time(options, [*taken, k]) <= DURATION:
                taken.append(k)
        programme, _ = shortest([options.motions[k] for k in taken], self.step, options.reach)
        return Choice(programme, _together(options, taken), options, self._so_far)

    def _time(self, options: Options, taken: Sequence[int]) -> float:
        return shortest([options.motions[k] for k in taken], self.step, options.reach)[1]

    def duration(self, choice: Choice) -> float:
        """Return how long a programme takes, s."""
        return self.step * (len(choice.programme.course(self.step, choice.options.reach)) - 1)

    def reference(self, choice: Choice) -> Run:
        """Return the reference of a programme, with the torque that the best model needs along it."""
        q = choice.programme.course(self.step, choice.options.reach)
        return self.followable(q, choice.change)

    def followable(self, q: np.ndarray, change: Change = AS_IT_IS) -> Run:
        """Return the reference of positions (N, n), with the torque that the best model needs along it."""
        run = self.planned("next_reference.csv", q)
        best = self.candidates[0] if change is AS_IT_IS else self._candidates(change)[0]
        (made,) = best.driven([run])
        t = run.run.t
        return Run("next_reference.csv", t, q, _at(t, made), q_ref=q, dq_ref=np.gradient(q, self.step, axis=0))


def _at(t: np.ndarray, run: Conditioned) -> np.ndarray:
    """Return the commands (N, n) of a thinned run at all of its samples."""
    return np.stack([np.interp(t, run.time, command) for command in run.command.T], axis=1)


def _together(options: Options, taken: Sequence[int]) -> Prospect:
    """Return what several of the options promise together."""
    first, *others = (options.prospects[k] for k in taken)
    for other in others:
        first = first + other
    return first


def swung(prepared: Prepared) -> tuple[str, ...]:
    """Return the joints that move though no recording drives them: others swing them, and no command does."""
    runs = (*prepared.fit, *prepared.held)
    held, idle = np.all([run.braked for run in runs], axis=0), np.all([run.undriven for run in runs], axis=0)
    moves = [not reach.still for reach in reaches(runs, prepared.cutoff)]
    return tuple(name for j, name in enumerate(prepared.arm.names) if idle[j] and moves[j] and not held[j])
