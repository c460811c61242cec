"""What a candidate saves once everything that is re-tuned has followed, to first order around a fitted model."""

from __future__ import annotations

import numpy as np

from stribeck.identify.map_fit import Fit
from stribeck.identify.problem import Weights


class Projector:
    """Linear least squares in a fitted model's parameters around its fit, priors included.

    Parameters
    ----------
    fit : Fit
    weights : Weights
    rows : array of int
        The part of the fit's rows that stands for all of them.

    Attributes
    ----------
    cost : float
        Of the model at its best on these rows.
    """

    def __init__(self, fit: Fit, weights: Weights, rows: np.ndarray) -> None:
        share = len(fit.residual) / len(rows)  # a part of the runs stands for all of them
        self.scale = weights.scale[rows] * np.sqrt(share)
        sd = np.array([fit.entries[i].sd if np.isfinite(fit.entries[i].sd) else 1.0 for i in fit.free])
        finite = np.array([np.isfinite(fit.entries[i].sd) for i in fit.free])
        slope = np.array([fit.p[i] if fit.entries[i].log else 1.0 for i in fit.free])
        self.columns = self._rows(fit.jacobian[rows] * np.where(finite, sd, slope))
        nominal = np.array([fit.entries[i].value for i in fit.free])
        self.prior = np.where(finite, 1.0, 1e-6)
        self.offset = np.where(finite, (fit.p[fit.free] - nominal) / np.where(finite, sd, 1.0), 0.0)
        self.inverse = np.linalg.inv(self.columns.T @ self.columns + np.diag(self.prior))
        misfit = self._rows(fit.residual[rows]).ravel()
        self.cost = 0.5 * float(misfit @ misfit) + 0.5 * float(np.sum(self.prior * self.offset**2))
        pull = self.columns.T @ misfit + self.prior * self.offset
        self.cost -= 0.5 * float(pull @ self.inverse @ pull)  # the base at its best on these rows

    def _rows(self, values: np.ndarray) -> np.ndarray:
        weighted = values * (self.scale[..., None] if values.ndim == 3 else self.scale)
        return np.asarray(weighted.reshape(values.shape[0] * values.shape[1], -1))

    def step(self, residual: np.ndarray, jacobian: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """Return the cost saved with the own parameters where they are, and their projected curvature and slope.

        Parameters
        ----------
        residual : array (K, n)
            Of a candidate on the projector's rows, all other parameters as fitted, N m.
        jacobian : array (K, n, own)
            By the candidate's own parameters.
        """
        r, own = self._rows(residual).ravel(), self._rows(jacobian)
        gradient = self.columns.T @ r + self.prior * self.offset
        cost = 0.5 * float(r @ r) + 0.5 * float(np.sum(self.prior * self.offset**2))
        cost -= 0.5 * float(gradient @ self.inverse @ gradient)
        cross = self.columns.T @ own
        curvature = own.T @ own - cross.T @ self.inverse @ cross
        slope = own.T @ r - cross.T @ (self.inverse @ gradient)
        return self.cost - cost, curvature, slope
