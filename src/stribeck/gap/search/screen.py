"""Which candidates are worth a full fit: each trial's residual, projected off everything that is re-tuned."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.gap.fitted.differentiable import differentiable
from stribeck.gap.fitted.model import Bristled, Model, start_values
from stribeck.gap.fitted.sizes import effect_scales
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.search.candidates import Trial
from stribeck.gap.search.descent import Descent
from stribeck.gap.search.projector import Projector
from stribeck.identify.problem import Weights
from stribeck.identify.residual import Residual
from stribeck.model.effect import Effect
from stribeck.model.layout import Placed
from stribeck.model.path import SignalPath
from stribeck.model.resting import resting
from stribeck.model.waves import Reach, Trace

LOOK, STEPS = 2, 12  # evaluations of every start, and further ones of the most hopeful starts, at most
FOLLOWED = 2  # starts that are followed to the end
HOPELESS = 10.0  # of the base's cost: a start that adds more at first is not followed
WORTH = 0.01  # of the base's cost at a joint: a start that is about to save less is looked at, not followed


def screen(
    prepared: Prepared,
    base: Model,
    weights: Weights,
    effect: Effect,
    joint: int,
    known: dict[str, float] | None = None,
    states: Sequence[np.ndarray] | None = None,
    anew: bool = False,
) -> Trial:
    """Return the best trial of one candidate, improved by a few projected steps, with the cost that it saves.

    The nominal parameters follow linearly (variable projection, Golub & Pereyra 1973), so that an evaluation needs
    the derivatives by the candidate's own parameters only. Laws that take long see the half of the runs that says most.

    Parameters
    ----------
    prepared : Prepared
    base : Model
        To which the candidate is added.
    weights : Weights
        Of the rows of the fit runs.
    effect, joint : Effect, int
        The candidate: a law, and the index of its joint.
    known : dict or None
        Values from an earlier step of the search: the only start of a law that takes long.
    states : sequence of array (N, nx), or None
        States of the base model along the fitted runs, where it has any.
    anew : bool
        Whether what is left is known to differ by little: then only what looks at it (waves, walls) has other starts
        than the known values.
    """
    path = prepared.path((*base.placed, Placed(effect, joint)))
    own = [i for i, entry in enumerate(path.entries) if entry.owner == len(base.placed)]
    runs = _loudest(prepared, base, weights) if effect.nonlinear or path.rough else list(range(len(prepared.fit)))
    same = [states[i] for i in runs] if states and not effect.delays else None
    some = [prepared.fit[i] for i in runs]
    # a first compliance is tried without its observer, which takes noise from a residual besides
    residual = Residual(path, some, own, same, observe=False)
    watched = bool(resting(path) or SignalPath(prepared.arm, base.placed).flexible)
    if not residual.reuses and (path.rough or set(own) & set(path.shifts) or watched):
        residual = differentiable(path, prepared, some, own, observe=watched, far=True)
    unit = _units(path, prepared, own)
    bristled, rows = Bristled(prepared, path, weights), _rows_of(prepared, runs)
    plain = Projector(base.fit, weights, rows)
    cost = plain.cost

    def way_from(p: np.ndarray) -> Descent:
        counted = bristled.at(p)
        projector = plain if counted is weights else Projector(base.fit, counted, rows)
        return Descent(residual, projector, p, own, unit)

    names = [path.entries[i].name for i in own]
    scale = prepared.scales[joint]
    best, sound = Trial(effect, joint, dict(effect.starts(scale)[0]), -np.inf), False
    trace = _trace(prepared, base, joint)
    starts = [known] if known else []
    others = () if known and effect.nonlinear else effect.starts_from(scale, trace)
    if not (known and anew and others == effect.starts(scale)):
        starts += others
    tried = [way_from(start_values(path, base.fit, start)) for start in starts]
    for way in tried:
        way.go(LOOK)
    # by where they are about to go: what has run away to nothing loses nothing either, and leads nowhere
    hopeful = [way for way in tried if way.ahead > -HOPELESS * cost]
    # what a law that takes long comes to is the only start of later steps; a value e times as large is not seen ahead;
    # beside a play, where each look takes long, what does not show at once is not looked for
    far = (effect.nonlinear and not known) or any(path.entries[i].log for i in own)
    sought = far and not SignalPath(prepared.arm, base.placed).rough
    for way in sorted(hopeful, key=lambda way: -way.ahead)[:FOLLOWED]:
        if sought or way.ahead > WORTH * cost / prepared.arm.n:
            way.go(STEPS)
        values = dict(zip(names, map(float, way.p[own]), strict=True))
        plausible = effect.plausible(values, scale)  # else it stands for another law, which is tried itself
        if (plausible, way.saved) > (sound, best.promise):
            best, sound = Trial(effect, joint, values, way.saved), plausible
    return best


def _trace(prepared: Prepared, base: Model, joint: int) -> Trace:
    """Return what a joint did in the fitted runs and what the base model leaves there."""

    def column(name: str) -> np.ndarray:
        parts = [getattr(run, name)[run.analysis_index] for run in prepared.fit]
        return np.concatenate([part if part.ndim == 1 else part[:, joint] for part in parts])

    time, position, velocity, command = map(column, ("told_time", "position", "velocity", "command"))
    starts = tuple(_edges(prepared)[1:-1].tolist())
    return Trace(time, position, velocity, command, base.fit.residual[:, joint], starts, _reach(prepared, base))


def _reach(prepared: Prepared, base: Model) -> Reach | None:
    """Return what the whole chain did in the fitted runs; None for an arm of one joint."""
    if prepared.arm.n < 2:
        return None
    position, velocity = (
        np.concatenate([getattr(run, name)[run.analysis_index] for run in prepared.fit])
        for name in ("position", "velocity")
    )
    angle = np.cumsum(position, axis=1)
    links = np.array([joint.length for joint in prepared.arm.joints])[:, None] * np.stack(
        [np.cos(angle), np.sin(angle)], axis=2
    )
    levers = np.cumsum(links[:, ::-1], axis=1)[:, ::-1]
    return Reach(levers, velocity, base.fit.residual)


def _edges(prepared: Prepared) -> np.ndarray:
    """Return the first row of each run of the fit, and the number of rows."""
    return np.cumsum([0, *(len(run.analysis_index) for run in prepared.fit)])


def _loudest(prepared: Prepared, base: Model, weights: Weights) -> list[int]:
    """Return the half of the runs, at least two, with most unexplained: an effect may stir in one motion only."""
    squares = np.sum((base.fit.residual * weights.scale) ** 2, axis=1)
    power = np.add.reduceat(squares, _edges(prepared)[:-1])
    return sorted(np.argsort(-power)[: max(2, (len(power) + 1) // 2)].tolist())


def _rows_of(prepared: Prepared, runs: Sequence[int]) -> np.ndarray:
    """Return the rows of the fit that belong to some of its runs."""
    edges = _edges(prepared)
    return np.concatenate([np.arange(edges[i], edges[i + 1]) for i in runs])


def _units(path: SignalPath, prepared: Prepared, own: Sequence[int]) -> np.ndarray:
    scales = effect_scales(path, prepared)
    return np.array([1.0 if path.entries[i].log else scales.get(path.entries[i].key, 1.0) for i in own])
