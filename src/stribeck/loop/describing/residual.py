"""Describing function of what friction compensation leaves: dead-band, rule at zero and estimator included."""

from __future__ import annotations

import math
from dataclasses import dataclass

import control as ct
import numpy as np
from numpy.typing import NDArray

from stribeck.arm.values import Friction
from stribeck.loop.describing.tustin import describing_function, nodes
from stribeck.simulate.loop import Compensation

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

NODES = 120


@dataclass(frozen=True)
class Compensator:
    """The compensation of a joint, as it answers a sinusoidal velocity estimate.

    Attributes
    ----------
    friction : Friction
        True constants; the compensation is ``ratio`` times them.
    ratio : float
        k.
    dead_band : float
        Estimated speed that counts as zero, rad/s.
    at_zero : str
        Sign taken there: ``zero``, ``hold``, ``error_sign`` or ``set_valued``.
    """

    friction: Friction
    ratio: float
    dead_band: float = 0.0
    at_zero: str = "zero"

    @classmethod
    def of(cls, c: Compensation, friction: Friction) -> Compensator:
        """Return that of a loop file; one without a torque along a fixed reference is none."""
        return cls(friction, c.ratio if c.kind == "feedback" else 0.0, c.dead_band, c.at_zero)

    def wave(self, angle: Floats, amplitude: float, lead: float = 0.0) -> Floats:
        """Return the torque (N m) along one period of the estimate, amplitude sin(angle), in the long run.

        Parameters
        ----------
        angle : array
            rad.
        amplitude : float
            Of the estimated velocity, rad/s.
        lead : float
            Within the dead-band, the sign is that of cos(angle + lead): 0 for the error's own with an ideal estimator.
        """
        f, v = self.friction, amplitude * np.sin(angle)
        outside = np.sign(v) * (f.C0 + f.C1 * np.exp(-np.abs(v) / f.alpha)) + f.C2 * v
        held = {
            "zero": np.zeros_like(v),
            "hold": -np.sign(np.cos(angle)) * (amplitude > self.dead_band),
        }.get(self.at_zero, np.sign(np.cos(angle + lead)))
        return np.asarray(self.ratio * np.where(np.abs(v) > self.dead_band, outside, held * (f.C0 + f.C1)))

    def describing_function(self, amplitude: Floats, lead: Floats | float = 0.0) -> Complex:
        """Return the complex ratio of the torque's fundamental to the estimate, N m s/rad; arguments as in `wave`."""
        a = np.asarray(amplitude, dtype=float)
        if self.ratio == 0.0:
            return np.zeros(np.broadcast(a, lead).shape, dtype=complex)
        if self.dead_band == 0.0:
            return np.asarray(self.ratio * describing_function(a, self.friction) + 0j * np.asarray(lead))
        edge = np.arcsin(np.minimum(self.dead_band / a, 1.0))
        inside = self._inside(a, edge, np.broadcast_to(lead, np.broadcast(a, lead).shape))
        return np.asarray(self.ratio * (self._outside(a, edge) + inside), dtype=complex)

    def _outside(self, a: Floats, edge: Floats) -> Floats:
        """Return the part from the angles at which the estimate is outside the dead-band."""
        f = self.friction
        x, w = nodes(NODES)
        span = 0.5 * math.pi - edge
        sine = np.sin(edge[..., None] + span[..., None] * x)
        fading = span * ((np.exp(-a[..., None] * sine / f.alpha) * sine) @ w)
        dry = 4.0 * (f.C0 * np.cos(edge) + f.C1 * fading) / (math.pi * a)
        return np.asarray(dry + f.C2 * (1.0 - (2.0 * edge - np.sin(2.0 * edge)) / math.pi))

    def _inside(self, a: Floats, edge: Floats, lead: Floats) -> Complex:
        """Return the part from within it: torque of constant size, whose sign the rule gives.

        Twice the angles from -edge to edge, since the other half period mirrors them.
        """
        level = 2.0 * (self.friction.C0 + self.friction.C1) / (math.pi * a)
        if self.at_zero == "zero":
            return np.zeros_like(lead, dtype=complex)
        if self.at_zero == "hold":
            return np.asarray(np.where(edge < 0.5 * math.pi, -2j * level * np.sin(edge), 0.0))
        first = (0.5 * math.pi - lead) % math.pi  # the sign turns there; one turn lies within -pi/2..pi/2
        turn = np.clip(np.where(first > 0.5 * math.pi, first - math.pi, first), -edge, edge)
        before = np.sign(np.cos(0.5 * (turn - edge) + lead))
        after = np.sign(np.cos(0.5 * (turn + edge) + lead))
        real = before * (np.cos(edge) - np.cos(turn)) + after * (np.cos(turn) - np.cos(edge))
        imag = before * (np.sin(turn) + np.sin(edge)) + after * (np.sin(edge) - np.sin(turn))
        return np.asarray(level * (real + 1j * imag))


class CompensatedResidual(ct.DescribingFunctionNonlinearity):  # type: ignore[misc]
    """Friction less its compensation on an ideal velocity, as a nonlinearity for python-control.

    Parameters
    ----------
    compensator : Compensator
        With a ratio over 1 the residual drives the motion; -1/N then lies on the positive real axis.
    """

    def __init__(self, compensator: Compensator) -> None:
        super().__init__()
        self.compensator = compensator

    def __call__(self, velocity: float) -> float:
        """Return the net friction torque (N m) at a velocity (rad/s); within a dead-band only for the rule "zero"."""
        c, v = self.compensator, float(np.squeeze(velocity))
        if abs(v) <= c.dead_band and v != 0.0 and c.at_zero != "zero":
            raise NotImplementedError("within a dead-band this rule depends on more than the velocity")
        f = c.friction
        torque = math.copysign(f.C0 + f.C1 * math.exp(-abs(v) / f.alpha) + f.C2 * abs(v), v) if v != 0.0 else 0.0
        return torque * (1.0 - c.ratio * (abs(v) > c.dead_band))

    def describing_function(self, A: float) -> complex:
        """Return N (N m s/rad) at a velocity amplitude (rad/s)."""
        a = np.array(float(A))
        whole = describing_function(a, self.compensator.friction)
        return complex(whole - self.compensator.describing_function(a))

    def _isstatic(self) -> bool:
        return True
