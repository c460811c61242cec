"""How far a loop is from instability: gain, phase and delay margin, sensitivity peak, bandwidth, damping."""

from __future__ import annotations

import math
from dataclasses import dataclass

import control as ct
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from stribeck.loop.linear.assemble import Assembly, Broken

Floats = NDArray[np.float64]

POINTS = 600  # of the frequency grid; peaks are refined from there
DECADES = 5.0


@dataclass(frozen=True)
class Margins:
    """Margins of one joint's loop, every other loop closed; infinite where there is no limit, nan where unstable.

    Attributes
    ----------
    stable : bool
        Of the whole closed loop.
    gain_margin : float
        Factor by which the loop gain may grow.
    phase_margin : float
        rad.
    delay_margin : float
        Further delay that the loop bears, s.
    sensitivity_peak : float
        Ms, the largest |1/(1 + L)|.
    bandwidth : float
        Frequency from which |L/(1 + L)| stays under 1/sqrt(2), rad/s.
    damping : float
        Smallest damping ratio of the oscillating poles below the Nyquist frequency; 1 where none oscillates.
    """

    stable: bool
    gain_margin: float
    phase_margin: float
    delay_margin: float
    sensitivity_peak: float
    bandwidth: float
    damping: float


def margins(assembly: Assembly, joint: str, kp: float | None = None) -> Margins:
    """Return the margins of a joint's loop; ``kp`` replaces its own gain."""
    damping = damping_ratio(assembly.poles(joint, kp), assembly.sample_time)
    if not assembly.is_stable(joint, kp):
        return Margins(False, math.nan, math.nan, math.nan, math.nan, math.nan, damping)
    loop = assembly.broken(joint, kp)
    omega = frequencies(assembly, joint, kp)
    value = response(loop, omega)
    gain, phase, _, _, crossing, _ = ct.stability_margins(ct.frd(value, omega), returnall=True)
    upward = np.append(gain[gain > 1.0], _upward_at_nyquist(loop, assembly.sample_time))
    delays = [math.radians(p % 360.0) / w for p, w in zip(phase, crossing, strict=True)]
    return Margins(
        True,
        float(upward.min()) if len(upward) else math.inf,
        math.radians(float(np.min(np.abs(phase)))) if len(phase) else math.inf,
        min(delays, default=math.inf),
        sensitivity_peak(loop, omega),
        _bandwidth(value, omega),
        damping,
    )


def _upward_at_nyquist(loop: Broken, sample_time: float) -> Floats:
    """Return the gain margin that a sampled loop has where a pole leaves through z = -1, the end of all frequencies."""
    if not sample_time:
        return np.empty(0)
    end = float(np.real(response(loop, np.array([math.pi / sample_time]))[0]))
    return np.array([-1.0 / end] if -1.0 < end < 0.0 else [])


def sensitivity_peak(loop: Broken, omega: Floats) -> float:
    """Return the largest |1/(1 + L)| over frequencies omega (F,), rad/s, refined between them."""
    size = np.abs(1.0 / (1.0 + response(loop, omega)))
    k = int(np.argmax(size))
    low, high = omega[max(k - 1, 0)], omega[min(k + 1, len(omega) - 1)]
    fine = minimize_scalar(
        lambda w: -abs(1.0 / (1.0 + response(loop, np.array([w]))[0])), bounds=(low, high), method="bounded",
        options={"xatol": 1e-7 * high},
    )  # fmt: skip
    return float(max(size[k], -fine.fun))


def response(loop: Broken, omega: Floats) -> NDArray[np.complex128]:
    """Return the frequency response (F,) of a loop, all frequencies at once."""
    system = loop.system
    point = np.exp(1j * omega * system.dt) if system.dt else 1j * omega
    a, b, c = (np.asarray(part) for part in (system.A, system.B, system.C))
    resolvent = point[:, None, None] * np.eye(len(a)) - a
    solved = np.linalg.solve(resolvent, np.broadcast_to(b.astype(complex), (len(point), *b.shape)))
    prompt = (c @ solved)[:, 0, 0] + np.asarray(system.D)[0, 0]
    return np.asarray(prompt / point**loop.late, dtype=complex)


def frequencies(assembly: Assembly, joint: str, kp: float | None = None) -> Floats:
    """Return a grid (F,) around the loop's own frequencies, rad/s, up to the Nyquist frequency."""
    i = assembly.index(joint)
    own = math.sqrt((assembly.entries[i].kp if kp is None else kp) / float(assembly.inertia[i]))
    high = math.pi / assembly.sample_time if assembly.sample_time > 0.0 else 1e3 * max(own, 1.0)
    return np.geomspace(min(high, own) * 10.0 ** (-0.6 * DECADES), high, POINTS)


def damping_ratio(poles: NDArray[np.complex128], sample_time: float) -> float:
    """Return the smallest damping ratio of the oscillating poles, 1 without any.

    Poles at and beyond the Nyquist frequency, whose continuous twin is not known, do not count.
    """
    poles = poles[np.abs(poles) > 1e-12]
    rates = np.log(poles) / sample_time if sample_time > 0.0 else poles
    limit = 0.999 * math.pi / sample_time if sample_time > 0.0 else math.inf
    turning = rates[(rates.imag > 1e-9 * np.abs(rates)) & (rates.imag < limit)]
    return float(np.min(-turning.real / np.abs(turning))) if len(turning) else 1.0


def _bandwidth(loop: NDArray[np.complex128], omega: Floats) -> float:
    size = np.abs(loop / (1.0 + loop))
    over = np.flatnonzero(size >= math.sqrt(0.5))
    if not len(over):
        return 0.0
    k = int(over[-1])
    if k + 1 == len(omega):
        return math.inf
    part = (math.log(size[k]) - 0.5 * math.log(0.5)) / (math.log(size[k]) - math.log(size[k + 1]))
    return float(omega[k] * (omega[k + 1] / omega[k]) ** part)
