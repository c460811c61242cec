"""The inertia that each joint of an arm moves in a pose, and how it changes with the parameters."""

from __future__ import annotations

from functools import cached_property

import casadi as ca
import numpy as np

from stribeck.model.layout import values_of
from stribeck.model.path import SignalPath


class MovedInertia:
    """Diagonal of the mass matrix with the rotors, kg m^2, of a signal path.

    Parameters
    ----------
    path : SignalPath
    """

    def __init__(self, path: SignalPath) -> None:
        self.path = path

    @cached_property
    def _function(self) -> ca.Function:
        pose, p = ca.SX.sym("pose", self.path.n), self.path.p
        inertia = self.path.moved_inertia(pose)
        return ca.Function("inertia", [pose, p], [inertia, ca.jacobian(inertia, p)])

    @cached_property
    def _nominal(self) -> MovedInertia:
        return MovedInertia(SignalPath(self.path.arm))

    def __call__(self, poses: np.ndarray, p: np.ndarray) -> np.ndarray:
        """Return the inertia (K, n) in poses (K, n) at parameter values (p,)."""
        return np.asarray(self._function.map(len(poses))(poses.T, np.tile(p[:, None], len(poses)))[0].full().T)

    def nominal_over(self, pose: np.ndarray, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the arm file's inertia over that at parameter values, and the derivatives of the ratio.

        Parameters
        ----------
        pose : array (n,)
        p : array (p,)

        Returns
        -------
        ratio : array (n,)
        slopes : array (n, p)
        """
        here, slopes = (value.full() for value in self._function(pose, p))
        given = self._nominal(pose[None], values_of(self._nominal.path.entries))[0]
        ratio = given / here[:, 0]
        return ratio, -ratio[:, None] * slopes / here
