"""One model of the search: placed effects, fitted to the fit runs and judged on the held-out ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stribeck.gap.fitted.differentiable import differentiable
from stribeck.gap.fitted.noisy import quieter
from stribeck.gap.fitted.sizes import effect_scales
from stribeck.gap.records.blocks import correlation_rows
from stribeck.gap.records.passed import Passed, spectrum
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.records.spread import noise_power, spread
from stribeck.identify.blocks import over_neighbours
from stribeck.identify.conditioning import Conditioned
from stribeck.identify.map_fit import Fit, fit
from stribeck.identify.problem import Weights
from stribeck.identify.residual import Residual
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath

NEIGHBOURS = 15  # rows, over which the noise of a row is averaged; it is drawn once
ROUNDS = 12  # of re-tuning, at most: weights that are far off halve from one to the next
SAME_SIZE, SAME_MEMORY = 0.02, 0.1  # by which the weights of two rounds may differ and hold: a fit by them is the same
HUGE = 1e100  # N m: a law that has run away, whose squares are no numbers any more


@dataclass(frozen=True)
class Model:
    """A fitted model: its effects with fitted values, the fit, and the residual (K, n) on held-out runs, N m.

    ``noise`` is what noise adds to that residual where the model has a compliance. ``absorbed`` counts the constants of
    a law outside the library that has taken what it can. ``rows`` (M + K, n) is what the encoder's noise adds to each
    row of the residual on all runs, N^2 m^2, of a model that has states; beside a compliance, nan at joints without a
    bristle. Noise pulls at a stiff bristle while a joint is at rest, where friction alone takes up any torque.
    """

    placed: tuple[Placed, ...]
    fit: Fit
    held: np.ndarray
    noise: Passed | None = None
    absorbed: int = 0
    rows: np.ndarray | None = None

    @property
    def whole(self) -> np.ndarray:
        """The residual on all runs, fitted ones first, N m."""
        return np.concatenate([self.fit.residual, self.held])

    def rms(self) -> np.ndarray:
        """Return the held-out residual's root mean square (n,), N m."""
        return np.asarray(np.sqrt(np.mean(self.held**2, axis=0)))


def finite(model: Model) -> bool:
    """Return whether a model's residual is a number everywhere, and one that can be squared."""
    return bool(np.all(np.abs(model.whole) < HUGE))


def start_values(path: SignalPath, known: Fit | None, trial: dict[str, float] | None) -> np.ndarray:
    """Return starting values (p,): fitted ones where a known fit has them, the trial for the last effect."""
    values = values_of(path.entries)
    if known is not None:
        fitted = {entry.key: known.p[i] for i, entry in enumerate(known.entries)}
        values = np.array([fitted.get(entry.key, value) for entry, value in zip(path.entries, values, strict=True)])
    last = len(path.placed) - 1
    for i, entry in enumerate(path.entries):
        if trial is not None and entry.owner == last:
            values[i] = trial[entry.name]
    return values


def fit_model(
    prepared: Prepared,
    placed: Sequence[Placed],
    weights: Weights,
    known: Fit | None = None,
    trial: dict[str, float] | None = None,
    *,
    careful: bool = False,
    evaluations: int = 80,
) -> Model:
    """Fit a model to the fit runs and evaluate it on the held-out runs.

    Parameters
    ----------
    prepared : Prepared
    placed : sequence of Placed
        Effects of the model; where they have values, these are the start.
    weights : Weights
        Of the rows of the fit runs.
    known : Fit or None
        An earlier fit, whose values are the start of the parameters that it has.
    trial : dict or None
        Starting values of the last effect.
    careful, evaluations : bool, int
        As of :func:`stribeck.identify.map_fit.fit`.
    """
    path = prepared.path(placed)
    residual = differentiable(path, prepared, prepared.fit)
    start = start_values(path, known, trial)
    scales = effect_scales(path, prepared)
    result = fit(residual, weights, start, scales, careful=careful, evaluations=evaluations)
    judged = Residual(path, prepared.held, ())
    held, _ = judged(result.p)
    model = Model(_with_values(placed, result), result, held)
    return with_noise(model, judged, model.whole, prepared)


def referred(prepared: Prepared, base: Model) -> Prepared:
    """Return recordings that know what noise adds to a re-tuned model's residual."""
    through = Residual(SignalPath(prepared.arm, base.placed), prepared.held, ())
    return replace(prepared, reference=noise_in(through, base.fit.p, base.held, prepared))


def with_noise(model: Model, residual: Residual, whole: np.ndarray, prepared: Prepared) -> Model:
    """Return a model that knows what noise adds to its residual, ``whole`` (M + K, n) on all runs, N m.

    That of a model with neither a state nor an effect that rescales is the re-tuned one's. With a mass at the tip, the
    same noise in an acceleration is more torque.
    """
    path, p = residual.path, model.fit.p
    if not path.x.numel() and not any(place.effect.rescales for place in path.placed):
        return model
    bristles = [path.bristle(j) is not None for j in range(path.n)]
    rows = noise_in_rows(residual, p, whole, prepared.moved) if not path.flexible or any(bristles) else None
    if rows is not None and prepared.noise is not None and prepared.noise.drawn is not None:
        # a law that bends the level near rest has less noise there too, but would gain it of noise alone
        rows = np.where(bristles, rows, np.maximum(rows, prepared.noise.drawn))
    if not path.flexible:
        return replace(model, rows=rows)
    noise = noise_in(residual, p, whole[-len(model.held) :], prepared)
    return replace(model, noise=noise, rows=None if rows is None else np.where(bristles, rows, np.nan))


def noise_in(judged: Residual, p: np.ndarray, held: np.ndarray, prepared: Prepared) -> Passed:
    """Return what encoder noise, and noise in the commands, add to a held-out residual (K, n), N m."""
    loud = prepared.moved[len(prepared.fit) :], prepared.pushed
    moved, pushed = (judged.along(runs)(p)[0] - held for runs in loud)
    pushed = pushed / prepared.push
    bristles = [judged.path.bristle(j) is not None for j in range(judged.path.n)]
    return Passed(np.std(moved, axis=0), np.std(pushed, axis=0), spectrum(pushed), np.array(bristles))


def noise_in_rows(
    residual: Residual, p: np.ndarray, whole: np.ndarray, moved: Sequence[Conditioned]
) -> np.ndarray | None:
    """Return what encoder noise, as ``moved`` runs have it, adds to each row of a residual, ``whole`` (M, n), N^2 m^2.

    None where a state runs away: nothing is known of its noise then. What a coarse encoder misses of a stop is no noise
    that goes to and fro: all the rest long a bristle is bent by so much more or less.
    """
    added = residual.along(moved)(p)[0] - whole
    if not np.all(np.abs(added) < HUGE):
        return None
    missed = np.concatenate([_missed(residual.path, p, run) for run in moved])
    return np.asarray(over_neighbours(added**2, moved, NEIGHBOURS) + missed)


def _missed(path: SignalPath, p: np.ndarray, run: Conditioned) -> np.ndarray:
    """Return by how much (M, n) the bristles of joints at rest may be bent wrongly, N^2 m^2."""
    out = np.zeros((len(run.analysis_index), path.n))
    for j in range(path.n):
        bristle = path.bristle(j)
        if bristle is not None:
            k, effect = bristle
            values = {entry.name: float(p[i]) for i, entry in enumerate(path.entries) if entry.owner == k}
            out[:, j] = run.stuck[run.analysis_index, j] * (effect.bristle_stiffness(values) * run.noise[j]) ** 2
    return out


class Bristled:
    """Weights for a model whose last effect, a bristle, is not fitted yet.

    Encoder noise pulls at it where friction alone holds still.

    Parameters
    ----------
    prepared : Prepared
    path : SignalPath
    weights : Weights
        Of the fitted runs, by a model without that effect: they serve as they are if it is no bristle.
    """

    def __init__(self, prepared: Prepared, path: SignalPath, weights: Weights) -> None:
        self._prepared, self._weights = prepared, weights
        last = len(path.placed) - 1
        self._joints = [(found := path.bristle(j)) is not None and found[0] == last for j in range(path.n)]
        self._residual = Residual(path, prepared.fit, ()) if any(self._joints) else None

    def at(self, p: np.ndarray) -> Weights:
        """Return the weights at the path's values (p,)."""
        noise = self._prepared.noise
        if self._residual is None or noise is None or noise.drawn is None:
            return self._weights
        moved = self._prepared.moved[: len(self._prepared.fit)]
        own = noise_in_rows(self._residual, p, self._residual.value(p), moved)
        if own is None:
            return self._weights
        more = np.where(self._joints, np.maximum(own - noise.drawn[: len(own)], 0.0), 0.0)
        return replace(self._weights, sd=np.sqrt(self._weights.sd**2 + more))


def _with_values(placed: Sequence[Placed], fit: Fit) -> tuple[Placed, ...]:
    values = [
        {entry.name: float(fit.p[i]) for i, entry in enumerate(fit.entries) if entry.owner == k}
        for k in range(len(placed))
    ]
    return tuple(replace(place, values=own) for place, own in zip(placed, values, strict=True))


def weights_of(model: Model, prepared: Prepared, floor: np.ndarray) -> Weights:
    """Return weights from a model's residual on the fit runs: its spread, at least its noise, and correlation."""
    return weights_from(model.fit.residual, prepared, floor, quieter(prepared, model.noise, floor), model.rows)


def cost_by(model: Model, weights: Weights) -> float:
    """Return what a model costs on the fit runs by any weights, those of another fit too, its prior included."""
    return 0.5 * float(np.sum((model.fit.residual * weights.scale) ** 2)) + model.fit.prior


def weights_from(
    residual: np.ndarray,
    prepared: Prepared,
    floor: np.ndarray,
    part: np.ndarray | float = 1.0,
    rows: np.ndarray | None = None,
) -> Weights:
    """Return weights from a residual (M, n) on the fit runs.

    It holds a part (n,) of the re-tuned model's noise; or, where :func:`noise_in_rows` finds more in its model's own
    ``rows`` (M + K, n) on all runs, so much more.

    Parameters
    ----------
    residual : array (M, n)
        On the fit runs, N m.
    prepared : Prepared
    floor : array (n,)
        Noise floor of the re-tuned model, N m rms.
    part : array (n,) or float
        Noise in the residual over the re-tuned model's.
    rows : array (M + K, n) or None
        What the encoder's noise adds to each row on all runs, N^2 m^2 (:func:`noise_in_rows`).
    """
    sd = spread(residual, noise_power(prepared.noise, floor, len(residual), rows) * part**2)
    return Weights(sd, correlation_rows(residual / sd, prepared.fit))


def retune(
    prepared: Prepared, floor: np.ndarray, placed: Sequence[Placed] = (), rounds: int = ROUNDS, known: Fit | None = None
) -> Model:
    """Return the re-tuned model: weights and fit in turn until the weights hold, from nominal values or ``known`` ones.

    Of a torque that does not change all rows count as few: values that are far off come to theirs by and by. Effects
    start where they are stated; a wave that starts beside values that are far off may leap to another pitch.

    Parameters
    ----------
    prepared : Prepared
    floor : array (n,)
        Noise floor, N m rms.
    placed : sequence of Placed
        Effects of the nominal model.
    rounds : int
        Fits at most.
    known : Fit or None
        Where to start; at the nominal values where None.
    """
    path = SignalPath(prepared.arm, placed)
    residual, _ = Residual(path, prepared.fit, ())(start_values(path, known, None))
    weights = weights_from(residual, prepared, floor)
    model = fit_model(prepared, placed, weights, known, careful=bool(path.placed))
    for _ in range(rounds - 1):
        before, weights = weights, weights_of(model, prepared, floor)
        if _alike(before, weights):
            break
        model = fit_model(prepared, placed, weights, model.fit)
    return model


def _alike(first: Weights, second: Weights) -> bool:
    """Return whether a fit by two weights comes to the same."""
    size, other = (np.sqrt(np.mean(weights.sd**2, axis=0)) for weights in (first, second))
    return np.allclose(size, other, rtol=SAME_SIZE, atol=0.0) and np.allclose(
        first.correlation, second.correlation, rtol=SAME_MEMORY
    )
