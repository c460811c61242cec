"""How far apart candidate models would lie after a further recording, everything that is re-tuned projected out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import convolve1d

from stribeck.arm import Arm
from stribeck.gap.experiment.changes import Change
from stribeck.gap.fitted.model import HUGE, Model
from stribeck.identify.conditioning import Conditioned
from stribeck.identify.problem import Weights
from stribeck.identify.residual import Residual
from stribeck.model.path import SignalPath

Floats = NDArray[np.float64]

ROUNDS = 20  # of turning a law of the drive around: in the band, each leaves a part of the last
MADE, SETTLED = 1e-8, 0.99  # squared, of the first round: no more is asked; of the last round: no more will come
AS_IT_IS = Change("")
ANEW = Change("", known_by="the same arm file")  # nothing is changed, but the runs so far are left out


@dataclass(frozen=True)
class Prospect:
    """What further recordings promise; those of several recordings add up.

    Rows are the K models of which one is true, columns these and further ones (L) that are fitted to old and new
    recordings. To second order a fit then has the misfit |r + J d|^2 + d' known d, d being what re-tuning changes.

    Attributes
    ----------
    square : array (K, L)
        r'r, in units of the noise.
    pull, grown : tuples [K][L] of arrays (f,) and (f, f)
        J'r and J'J.
    known : tuple [L] of arrays (f, f)
        What the recordings so far and the priors say.
    torque : array (n,)
        Largest command that the first model needs, N m.
    rows : float
        Independent ones, at each joint.
    left : float
        What a model, were it true, leaves of the motion at most under the commands that were found for it, in noise
        rms: much where it cannot make that motion, or runs away on it.
    """

    square: Floats
    pull: tuple[tuple[Floats, ...], ...]
    grown: tuple[tuple[Floats, ...], ...]
    known: tuple[Floats, ...]
    torque: Floats
    rows: float = 0.0
    left: float = 0.0

    def __add__(self, other: Prospect) -> Prospect:
        return Prospect(
            self.square + other.square,
            tuple(tuple(p + q for p, q in zip(*rows, strict=True)) for rows in zip(self.pull, other.pull, strict=True)),
            tuple(
                tuple(g + h for g, h in zip(*rows, strict=True)) for rows in zip(self.grown, other.grown, strict=True)
            ),
            self.known,
            np.maximum(self.torque, other.torque),
            self.rows + other.rows,
            max(self.left, other.left),
        )

    @cached_property
    def apart(self) -> Floats:
        """Expected excess (K, L) of the column's misfit, as the root of a likelihood ratio (a t value); 0 for itself.

        To second order the cost of a fitted model rises by d'H d / 2 around its fit, H being its Gauss-Newton Hessian
        with the priors; a further recording that another model made adds |r + J d|^2 / 2. The least sum over d is the
        expected log likelihood ratio: Atkinson & Fedorov (1975), T-optimal designs, here with everything re-tuned.
        """
        rows, columns = self.square.shape
        apart = np.zeros((rows, columns))
        for a in range(rows):
            for b in range(columns):
                if a != b:
                    apart[a, b] = _excess(float(self.square[a, b]), self.pull[a][b], self.known[b] + self.grown[a][b])
        return apart

    @property
    def pairs(self) -> Floats:
        """How far apart the models are (K, K) whichever of two is true."""
        own = self.apart[:, : len(self.apart)]
        return np.minimum(own, own.T)

    @property
    def worth(self) -> float:
        """What is learnt about all pairs, one that is known already counting for little more: sum of log(1 + t^2)."""
        return float(np.sum(np.log1p(self.apart**2)))

    @property
    def information(self) -> float:
        """Log determinant of what is then known of the last column's parameters: the D-criterion."""
        return float(np.linalg.slogdet(self.known[-1] + self.grown[0][-1])[1])


class Candidate:
    """One candidate model as a predictor, with what the recordings so far say of its parameters.

    Parameters
    ----------
    arm : Arm
        Nominal.
    model : Model
        Fitted.
    weights : Weights
        Of the residual's rows so far.
    change : Change
        Known, of the new recordings.
    """

    def __init__(self, arm: Arm, model: Model, weights: Weights, change: Change = AS_IT_IS) -> None:
        fit = model.fit
        self.p, self.correlation = fit.p, weights.correlation
        entries = [fit.entries[i] for i in fit.free]
        known = np.array([np.isfinite(entry.sd) for entry in entries])
        slope = np.array([value if entry.log else 1.0 for entry, value in zip(entries, fit.p[fit.free], strict=True)])
        size = np.maximum(np.abs(fit.p[fit.free]), 1e-9)
        self.unit = np.where(known, [entry.sd if known[k] else 1.0 for k, entry in enumerate(entries)], slope * size)
        path = SignalPath(arm, change.around(model.placed))
        self.residual = Residual(path, (), tuple(int(i) for i in fit.free))
        self.balance = Residual(path, (), (), observe=False)
        columns = self._columns(fit.jacobian, weights.scale)
        self.known = columns.T @ columns + np.diag(np.where(known, 1.0, 1e-6))

    def _columns(self, jacobian: Floats, scale: Floats) -> Floats:
        weighted = jacobian * scale[..., None] * self.unit
        return np.asarray(weighted.reshape(jacobian.shape[0] * jacobian.shape[1], -1))

    def driven(self, runs: Sequence[Conditioned]) -> list[Conditioned]:
        """Return runs with the commands under which this model makes their motions; at rest, one of the many."""
        bare = [replace(run, command=np.zeros_like(run.command), taps=np.ones(1), decimation=1) for run in runs]
        edges = np.cumsum([len(run.time) for run in runs])[:-1]
        best, least = [run.command for run in bare], np.full(len(runs), np.inf)
        turned, first = False, np.zeros(len(runs))
        for _ in range(ROUNDS):
            before = least.copy()
            missing, _ = self.balance.along(bare)(self.p)
            parts = np.split(_countable(missing), edges)
            if turned:  # beyond a third of a turn a delay makes it grow: only what is looked at is mended further
                parts = [_in_band(part, run.taps) for part, run in zip(parts, runs, strict=True)]
            turned = True
            for i, part in enumerate(parts):
                if (size := float(np.sum(part**2))) < least[i]:
                    best[i], least[i] = bare[i].command, size
            first = np.maximum(first, np.where(np.isfinite(before), 0.0, least))
            if np.all((least < MADE * first) | (least > SETTLED * before)):
                break
            bare = [replace(run, command=run.command - part) for run, part in zip(bare, parts, strict=True)]
        return [replace(run, command=command) for run, command in zip(runs, best, strict=True)]

    def misfit(self, runs: Sequence[Conditioned], noise: Sequence[Floats]) -> tuple[list[Floats], list[Floats]]:
        """Return residuals (M n,) and their derivatives (M n, f) per run, in units of the noise and of the priors.

        ``noise`` is that of each row of each run, (M, n), N m.
        """
        residual, jacobian = map(_countable, self.residual.along(runs)(self.p))
        edges = np.cumsum([len(run.analysis_index) for run in runs])[:-1]
        scales = [Weights(sd, self.correlation).scale for sd in noise]
        parts = zip(np.split(residual, edges), np.split(jacobian, edges), scales, strict=True)
        rows = [((left * scale).ravel(), self._columns(columns, scale)) for left, columns, scale in parts]
        return [left for left, _ in rows], [columns for _, columns in rows]

    def excess(self, run: Conditioned, noise: Floats) -> float:
        """Return the root of what this model, re-tuned by old recordings and a new one, leaves unexplained of that."""
        (left,), (columns,) = self.misfit([run], [noise])
        return _excess(float(left @ left), columns.T @ left, self.known + columns.T @ columns)


def _countable(values: Floats) -> Floats:
    """Return values whose squares are numbers: a law that runs away on a planned motion is far off, and no more."""
    return np.clip(np.nan_to_num(values, nan=HUGE), -HUGE, HUGE)


def _in_band(values: Floats, taps: Floats) -> Floats:
    """Return values (N, n) low-passed, as many as before."""
    return np.asarray(convolve1d(values, taps, axis=0, mode="nearest"))


def prospects(
    candidates: Sequence[Candidate],
    runs: Sequence[Conditioned],
    noise_of: Callable[[Sequence[Conditioned]], Sequence[Floats]],
    rivals: Sequence[Candidate] = (),
) -> list[Prospect]:
    """Return what each of some planned runs promises.

    Parameters
    ----------
    candidates : sequence of Candidate
        Of which one is taken to be true; the first is the one whose torque is looked at.
    runs : sequence of Conditioned
        Planned motions, conditioned as recorded ones are; their commands are not looked at.
    noise_of : callable
        Returns that of the rows (M, n) of each run under the first one's commands, N m: a quick motion has more than a
        slow one, around reversals most.
    rivals : sequence of Candidate
        Further columns: models that are fitted as well, but that nobody takes to be true.
    """
    columns = (*candidates, *rivals)
    made = [true.driven(runs) for true in candidates]
    noise = noise_of(made[0])
    own = [true.misfit(driven, noise)[0] for true, driven in zip(candidates, made, strict=True)]
    seen = [[other.misfit(driven, noise) for other in columns] for driven in made]
    known = tuple(other.known for other in columns)
    out = []
    for i in range(len(runs)):
        # what turning its own drive around has left is no misfit of others
        parts = [[(left[i] - own[a][i], slopes[i]) for left, slopes in row] for a, row in enumerate(seen)]
        out.append(
            Prospect(
                np.array([[float(left @ left) for left, _ in row] for row in parts]),
                tuple(tuple(slopes.T @ left for left, slopes in row) for row in parts),
                tuple(tuple(slopes.T @ slopes for _, slopes in row) for row in parts),
                known,
                np.max(np.abs(made[0][i].command), axis=0),
                float(len(runs[i].analysis_index) / np.max(candidates[0].correlation)),
                max(float(np.sqrt(np.mean(left[i] ** 2))) for left in own),
            )
        )
    return out


def _excess(square: float, pull: Floats, hessian: Floats) -> float:
    """Return the root of min over d of square + 2 pull'd + d' hessian d; 0 where it is not a number."""
    if not (np.isfinite(square) and np.all(np.isfinite(pull)) and np.all(np.isfinite(hessian))):
        return 0.0
    size = np.sqrt(np.diag(hessian))
    normal = hessian / np.outer(size, size) + 1e-10 * np.eye(len(size))
    saved = float((pull / size) @ np.linalg.solve(normal, pull / size))  # of nothing at all, too
    return float(np.sqrt(max(square - saved, 0.0)))
