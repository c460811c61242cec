"""A run as a frozen value."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from stribeck.errors import StribeckError

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Run:
    """One recording of N samples of an arm with n joints, in SI units.

    Attributes
    ----------
    name : str
        The file's name, with folders where that alone does not tell runs apart.
    t : (N,) array
        Time, strictly increasing, s.
    q : (N, n) array
        Measured position, rad; ``q[i]`` is measured at ``t[i]``.
    tau : (N, n) array
        Commanded torque, N m; ``tau[i]`` is held from ``t[i]`` to ``t[i + 1]``.
    dq : (N, n) array or None
        Measured velocity, rad/s.
    q_ref, dq_ref : (N, n) array or None
        Reference, rad and rad/s.
    tau_meas : (N, n) array or None
        Measured torque or torque from current, N m.
    temperature : (N, n) array or None
        deg C.
    extra : pyarrow.Table or None
        Columns of the file that are not used, as read.
    gaps : (N,) array of bool or None
        Samples interpolated across missing ones (see `stribeck.grid.uniform`).
    warnings : tuple of str
        What reading the file gave reason to doubt.
    droop : (N, n) array or None
        What ``tau`` lacks of a held command that does the same, where it is the mean of one that changed in between,
        N m (see `stribeck.run.held`).
    """

    name: str
    t: Floats
    q: Floats
    tau: Floats
    dq: Floats | None = None
    q_ref: Floats | None = None
    dq_ref: Floats | None = None
    tau_meas: Floats | None = None
    temperature: Floats | None = None
    extra: pa.Table | None = None
    gaps: NDArray[np.bool_] | None = None
    warnings: tuple[str, ...] = ()
    droop: Floats | None = None

    def __post_init__(self) -> None:
        if self.t.ndim != 1 or self.q.ndim != 2:
            raise StribeckError("run: t must be (N,) and q (N, n)", f"{self.t.shape} and {self.q.shape}")
        for key in ("q", "tau", "dq", "q_ref", "dq_ref", "tau_meas", "temperature", "droop"):
            value = getattr(self, key)
            if value is not None and value.shape != (len(self.t), self.n):
                raise StribeckError(f"run: {key} must have shape {(len(self.t), self.n)}", str(value.shape))

    @property
    def n(self) -> int:
        """Number of joints."""
        return int(self.q.shape[1])

    @property
    def duration(self) -> float:
        """Time from the first sample to the last, s."""
        return float(self.t[-1] - self.t[0])

    @property
    def sample_time(self) -> float:
        """Median step of the clock, s."""
        return float(np.median(np.diff(self.t)))
