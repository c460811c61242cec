"""How far apart candidate models would lie after a further recording, everything that is re-tuned projected out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.ndimage import convolve1d

from stribeck.arm import Arm
from stribeck.gap.changes import Change
from stribeck.gap.model import Model
from stribeck.identify.conditioning import Conditioned
from stribeck.identify.map_fit import Weights
from stribeck.identify.residual import Residual
from stribeck.model.path import SignalPath

Floats = NDArray[np.float64]

ROUNDS = 20  # of turning a law of the drive around: in the band, each leaves a part of the last
AS_IT_IS = Change("")


@dataclass(frozen=True)
class Prospect:
    """What one further recording promises.

    Attributes
    ----------
    apart : array (K, K)
        Row: the model that is true. Column: another one fitted to old and new recordings. The expected excess of its
        misfit, as the root of a likelihood ratio (a t value); zero on the diagonal.
    information : float
        Log determinant of what is then known of the first model's parameters: the D-criterion.
    torque : array (n,)
        Largest command that the first model needs, N m.
    """

    apart: Floats
    information: float
    torque: Floats

    @property
    def least(self) -> float:
        """How far apart the two models are that lie nearest."""
        off = ~np.eye(len(self.apart), dtype=bool)
        return float(np.min(self.apart[off]))


class Candidate:
    """One candidate model as a predictor, with what the recordings so far say of its parameters.

    Parameters
    ----------
    arm : Arm
        Nominal.
    model : Model
        Fitted.
    weights : Weights
        Of the residual's rows, old and new.
    change : Change
        Known, of the new recordings.
    """

    def __init__(self, arm: Arm, model: Model, weights: Weights, change: Change = AS_IT_IS) -> None:
        fit = model.fit
        self.p, self.scale = fit.p, weights.scale
        entries = [fit.entries[i] for i in fit.free]
        known = np.array([np.isfinite(entry.sd) for entry in entries])
        slope = np.array([value if entry.log else 1.0 for entry, value in zip(entries, fit.p[fit.free], strict=True)])
        size = np.maximum(np.abs(fit.p[fit.free]), 1e-9)
        self.unit = np.where(known, [entry.sd if known[k] else 1.0 for k, entry in enumerate(entries)], slope * size)
        path = SignalPath(arm, change.around(model.placed))
        self.residual = Residual(path, (), tuple(int(i) for i in fit.free))
        self.balance = Residual(path, (), ())
        columns = self._columns(fit.jacobian)
        self.known = columns.T @ columns + np.diag(np.where(known, 1.0, 1e-6))

    def _columns(self, jacobian: Floats) -> Floats:
        weighted = jacobian * self.scale[None, :, None] * self.unit
        return np.asarray(weighted.reshape(-1, len(self.unit)))

    def driven(self, runs: Sequence[Conditioned]) -> list[Conditioned]:
        """Return runs with the commands under which this model makes their motions; at rest, one of the many."""
        bare = [replace(run, command=np.zeros_like(run.command), taps=np.ones(1), decimation=1) for run in runs]
        edges = np.cumsum([len(run.time) for run in runs])[:-1]
        best, least = [run.command for run in bare], np.full(len(runs), np.inf)
        turned = False
        for _ in range(ROUNDS):
            missing, _ = self.balance.along(bare)(self.p)
            parts = np.split(missing, edges)
            if turned:  # beyond a third of a turn a delay makes it grow: only what is looked at is mended further
                parts = [_in_band(part, run.taps) for part, run in zip(parts, runs, strict=True)]
            turned = True
            for i, part in enumerate(parts):
                if (size := float(np.sum(part**2))) < least[i]:
                    best[i], least[i] = bare[i].command, size
            bare = [replace(run, command=run.command - part) for run, part in zip(bare, parts, strict=True)]
        return [replace(run, command=command) for run, command in zip(runs, best, strict=True)]

    def misfit(self, runs: Sequence[Conditioned]) -> tuple[list[Floats], list[Floats]]:
        """Return residuals (M n,) and their derivatives (M n, f) per run, in units of the noise and of the priors."""
        residual, jacobian = self.residual.along(runs)(self.p)
        edges = np.cumsum([len(run.analysis_index) for run in runs])[:-1]
        left = [(part * self.scale).ravel() for part in np.split(residual, edges)]
        return left, [self._columns(part) for part in np.split(jacobian, edges)]


def _in_band(values: Floats, taps: Floats) -> Floats:
    """Return values (N, n) low-passed, as many as before."""
    return np.asarray(convolve1d(values, taps, axis=0, mode="nearest"))


def prospects(candidates: Sequence[Candidate], runs: Sequence[Conditioned]) -> list[Prospect]:
    """Return what each of some planned runs promises.

    Parameters
    ----------
    candidates : sequence of Candidate
        At least two; the first is the one whose torque limits and information are looked at.
    runs : sequence of Conditioned
        Planned motions, conditioned as recorded ones are; their commands are not looked at.

    Notes
    -----
    To second order the cost of a fitted model rises by d'H d / 2 around its fit, H being its Gauss-Newton Hessian with
    the priors; a further recording that another model made adds |r + J d|^2 / 2. The least sum over d is the expected
    log likelihood ratio: Atkinson & Fedorov (1975), T-optimal designs, here with everything re-tuned.
    """
    count = len(candidates)
    apart = np.zeros((len(runs), count, count))
    information, torque = np.zeros(len(runs)), np.zeros((len(runs), len(candidates[0].scale)))
    for a, true in enumerate(candidates):
        made = true.driven(runs)
        own, _ = true.misfit(made)  # what turning its drive around has left
        for b, other in enumerate(candidates):
            left, columns = other.misfit(made)
            for i in range(len(runs)):
                if a != b:
                    apart[i, a, b] = _excess(left[i] - own[i], columns[i], other.known)
                elif a == 0:
                    information[i] = np.linalg.slogdet(other.known + columns[i].T @ columns[i])[1]
                    torque[i] = np.max(np.abs(made[i].command), axis=0)
    return [Prospect(apart[i], float(information[i]), torque[i]) for i in range(len(runs))]


def _excess(left: Floats, columns: Floats, known: Floats) -> float:
    """Return the root of min over d of |left + columns d|^2 + d' known d; 0 where it is not a number."""
    pull = columns.T @ left
    hessian = known + columns.T @ columns
    if not (np.all(np.isfinite(pull)) and np.all(np.isfinite(hessian))):
        return 0.0
    size = np.sqrt(np.diag(hessian))
    factor = cho_factor(hessian / np.outer(size, size) + 1e-10 * np.eye(len(size)))
    saved = float((pull / size) @ cho_solve(factor, pull / size))
    return float(np.sqrt(max(float(left @ left) - saved, 0.0)))
