"""Harmonic balance with many harmonics: a periodic motion that slides all the time, its zero crossings exact."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import root

from stribeck.arm.values import Friction
from stribeck.errors import InputError
from stribeck.loop.describing.frequency import LinearPart
from stribeck.loop.describing.residual import Compensator
from stribeck.loop.describing.roots import Root
from stribeck.loop.describing.tustin import nodes

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

NODES, FINE = 160, 2000
GROWTH = (1, 2, 4, 8, 16, 32)
ENOUGH = 16  # harmonics without which a balance says little
CLOSE = 1e-9
RIPPLE = 2e-3  # of the largest velocity: what harmonics that are left out may still miss
FAR = 1e5  # times the loop's own frequency: only inertia is left there


@dataclass(frozen=True)
class Harmonics:
    """A periodic motion as odd harmonics of its velocity, v(t) = sum of Im(V_m exp(j m omega t)).

    Attributes
    ----------
    order : array (H,)
        1, 3, 5, ...; below the Nyquist frequency, and as many as Newton's method found a balance of.
    velocity : array (H,) of complex
        V_m, rad/s.
    omega : float
        rad/s.
    status : str
        ``ok``; ``sticks`` where the velocity changes sign within half a period, so that no such motion exists;
        ``not_converged``.
    """

    order: NDArray[np.intp]
    velocity: Complex
    omega: float
    status: str

    @property
    def period(self) -> float:
        """In s."""
        return 2.0 * math.pi / self.omega

    @property
    def amplitude(self) -> float:
        """Half the peak-to-peak position, rad."""
        angle = np.linspace(0.0, math.pi, FINE)
        return float(np.abs(_wave(angle, self.order, self.velocity / (1j * self.order * self.omega))).max())

    @property
    def peak_velocity(self) -> float:
        """In rad/s."""
        return float(np.abs(_wave(np.linspace(0.0, math.pi, FINE), self.order, self.velocity)).max())


def harmonic_balance(
    part: LinearPart, friction: Friction, compensator: Compensator, start: Root, harmonics: int = 20
) -> Harmonics:
    """Refine a describing function's root by further harmonics.

    Friction and compensation switch where true and estimated velocity pass zero; both instants are unknowns, so that
    no smoothing is needed, and nothing that sticks can be represented. What the harmonics that are left out add to the
    velocity at its zero crossing, where their series converges most slowly, is summed in closed form for a continuous
    loop (Tsypkin's method for a relay; Boiko 2009).

    Parameters
    ----------
    part : LinearPart
    friction : Friction
        Symmetric constants.
    compensator : Compensator
        Without a dead-band.
    start : Root
    harmonics : int
        H, the number of odd harmonics; those above the Nyquist frequency are left out.
    """
    if compensator.dead_band > 0.0:
        raise InputError("harmonic balance takes no dead-band", f"{compensator.dead_band:g} rad/s", "give 0")
    allowed = int((part.highest / start.omega - 1.0) // 2.0) + 1 if math.isfinite(part.highest) else harmonics
    most = max(1, min(harmonics, allowed))
    delta = -float(np.angle(part.estimator(np.array(start.omega)))) if compensator.ratio else 0.0
    first = x = _pack(np.array([start.velocity + 0j]), start.omega, delta, start)
    found: Harmonics | None = None
    for count in [*(n for n in GROWTH if n < most), most]:  # each begins where fewer harmonics ended, or anew
        order = 2 * np.arange(count) + 1
        for guess in (x, first):
            solved = root(
                lambda v, m=order: _misfit(v, part, friction, compensator, start, m), _padded(guess, count), tol=1e-12
            )
            velocity, omega, _ = _unpack(solved.x, start)
            misfit = np.abs(_misfit(solved.x, part, friction, compensator, start, order)).max()
            if np.isfinite(misfit) and misfit <= CLOSE and 0.0 < omega < part.highest:
                x = solved.x
                found = Harmonics(order, velocity, omega, _status(part, friction, compensator, order, velocity, omega))
                break
            if guess is first or len(x) == len(first):
                break
    if found is None or len(found.order) < min(most, ENOUGH):
        return Harmonics(order, velocity, omega, "not_converged")
    return found


def _status(
    part: LinearPart, friction: Friction, compensator: Compensator, order: NDArray[np.intp], velocity: Complex,
    omega: float,
) -> str:  # fmt: skip
    angle = np.linspace(0.0, math.pi, FINE)[1:-1]
    size, _ = _jump(part, friction, compensator, omega)
    inner = _wave(angle, order, velocity) + size * _rest(angle, order)
    return "ok" if inner.min() > -RIPPLE * np.abs(inner).max() else "sticks"


def _padded(x: Floats, count: int) -> Floats:
    """Return the unknowns with harmonics of zero added."""
    had = (len(x) - 2) // 2
    more = np.zeros(count - had)
    return np.concatenate([x[:had], more, x[had : 2 * had], more, x[-2:]])


def _pack(velocity: Complex, omega: float, delta: float, start: Root) -> Floats:
    scaled = velocity / start.velocity
    return np.concatenate([scaled.real, scaled.imag, [math.log(omega / start.omega), delta]])


def _unpack(x: Floats, start: Root) -> tuple[Complex, float, float]:
    half = (len(x) - 2) // 2
    velocity = start.velocity * (x[:half] + 1j * x[half : 2 * half])
    return np.asarray(velocity, dtype=complex), start.omega * float(np.exp(np.clip(x[-2], -20.0, 20.0))), float(x[-1])


def _misfit(
    x: Floats, part: LinearPart, friction: Friction, compensator: Compensator, start: Root, order: NDArray[np.intp]
) -> Floats:
    """Return balance of each harmonic and both zero crossings, relative to the first harmonic."""
    velocity, omega, delta = _unpack(x, start)
    each = np.asarray(order * omega, dtype=float)
    torque = _torque(order, velocity, friction)
    size, passed = _jump(part, friction, compensator, omega)
    rest = size * float(_rest(np.zeros(1), order)[0])
    late = delta
    if compensator.ratio:
        seen = part.estimator(each) * velocity * np.exp(1j * order * delta)  # its zero crossing moved to angle 0
        answer = compensator.ratio * _torque(order, seen, friction) * np.exp(-1j * order * delta)
        torque = torque - part.passage(each) * answer
        late = (float(seen.imag.sum()) + passed * rest) / start.velocity
    balance = (velocity + part.response(each) * torque) / start.velocity
    crossing = (float(velocity.imag.sum()) + rest) / start.velocity
    return np.concatenate([balance.real, balance.imag, [crossing, late]])


def _jump(part: LinearPart, friction: Friction, compensator: Compensator, omega: float) -> tuple[float, float]:
    """Return how far Coulomb's jump bends the velocity (rad/s), and how much of that the estimator passes on.

    Far up, where inertia is all that is left, the m-th harmonic of the velocity is that size times j/m^2.
    """
    if math.isfinite(part.highest):
        return 0.0, 0.0
    w = np.array([FAR * max(part.own_frequency, omega)])
    mobility = complex((part.response(w) * 1j * w)[0]).real  # 1/J of what the torque accelerates at once
    estimator, passage = (complex(value[0]).real for value in (part.estimator(w), part.passage(w)))
    jump = friction.C0 * (1.0 - compensator.ratio * estimator * passage)
    return 4.0 * jump * mobility / (math.pi * omega), estimator


def _rest(angle: Floats, order: NDArray[np.intp]) -> Floats:
    """Return the sum of cos(m angle)/m^2 over the odd m that are left out, for angles from 0 to pi."""
    kept = np.cos(np.outer(angle, order)) @ (1.0 / order.astype(float) ** 2)
    return np.asarray(0.25 * math.pi * (0.5 * math.pi - angle) - kept)


def _torque(order: NDArray[np.intp], velocity: Complex, friction: Friction) -> Complex:
    """Return the harmonics of friction along a velocity that is positive in the first half period, N m."""
    torque: Complex = np.asarray(4.0 * friction.C0 / (math.pi * order) + friction.C2 * velocity, dtype=complex)
    if friction.C1 == 0.0:
        return torque
    x, w = nodes(NODES)
    angle = 0.5 * math.pi * (1.0 - np.cos(math.pi * x))  # dense at both ends, where the speed is low
    weight = 0.5 * math.pi**2 * np.sin(math.pi * x) * w
    fading = np.exp(-np.abs(_wave(angle, order, velocity)) / friction.alpha)
    return np.asarray(torque + 2j / math.pi * friction.C1 * (np.exp(-1j * np.outer(order, angle)) @ (weight * fading)))


def _wave(angle: Floats, order: NDArray[np.intp], parts: Complex) -> Floats:
    return np.asarray((np.exp(1j * np.outer(angle, order)) @ parts).imag)
