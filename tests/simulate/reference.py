"""An independent simulation of the two-link arm: Lagrange's equations by hand, scipy's DOP853 with events.

Nothing is shared with the package but the numbers of the arm file.
"""

import itertools
import math
from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

from stribeck.arm import Arm, Friction

Command = Callable[[float, np.ndarray], np.ndarray]


class Reference:
    """Two revolute joints; state (q1, q2, w1, w2)."""

    def __init__(self, arm: Arm) -> None:
        self.arm = arm
        self.one, self.two = arm.joints

    def mass(self, q: np.ndarray) -> np.ndarray:
        one, two = self.one, self.two
        (x1, y1), (x2, y2), length = one.com, two.com, one.length
        c, s = math.cos(q[1]), math.sin(q[1])
        about_two = two.inertia + two.mass * (x2**2 + y2**2)
        cross = two.mass * length * (x2 * c - y2 * s)
        about_one = one.inertia + one.mass * (x1**2 + y1**2) + two.mass * length**2
        rotor = np.diag([one.rotor_inertia, two.rotor_inertia])
        return (
            np.array([[about_one + about_two + 2 * cross, about_two + cross], [about_two + cross, about_two]]) + rotor
        )

    def potential(self, q: np.ndarray) -> float:
        gx, gy = self.arm.gravity
        one, two, a, b = self.one, self.two, q[0], q[0] + q[1]
        p1 = (one.com[0] * math.cos(a) - one.com[1] * math.sin(a), one.com[0] * math.sin(a) + one.com[1] * math.cos(a))
        elbow = (one.length * math.cos(a), one.length * math.sin(a))
        p2 = (
            elbow[0] + two.com[0] * math.cos(b) - two.com[1] * math.sin(b),
            elbow[1] + two.com[0] * math.sin(b) + two.com[1] * math.cos(b),
        )
        return -one.mass * (gx * p1[0] + gy * p1[1]) - two.mass * (gx * p2[0] + gy * p2[1])

    def energy(self, y: np.ndarray) -> float:
        return 0.5 * float(y[2:] @ self.mass(y[:2]) @ y[2:]) + self.potential(y[:2])

    def bias(self, y: np.ndarray) -> np.ndarray:
        """Coriolis, centrifugal and gravity torques."""
        one, two = self.one, self.two
        q, w = y[:2], y[2:]
        (x2, y2), length = two.com, one.length
        slope = -two.mass * length * (x2 * math.sin(q[1]) + y2 * math.cos(q[1]))
        gx, gy = self.arm.gravity
        a, b = q[0], q[0] + q[1]

        def turned(x: float, z: float, angle: float) -> float:  # -d/dangle of g . position
            dx, dz = -x * math.sin(angle) - z * math.cos(angle), x * math.cos(angle) - z * math.sin(angle)
            return -(gx * dx + gy * dz)

        g2 = two.mass * turned(x2, y2, b)
        g1 = one.mass * turned(*one.com, a) + two.mass * turned(length, 0.0, a) + g2
        return np.array([slope * (2 * w[0] * w[1] + w[1] ** 2) + g1, -slope * w[0] ** 2 + g2])

    def level(self, joint: int, speed: float) -> float:
        f: Friction = self.arm.joints[joint].friction
        return f.C0 + f.C1 * math.exp(-speed / f.alpha) + f.C2 * speed

    def accelerations(self, y: np.ndarray, u: np.ndarray, modes: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
        """Accelerations, and the torque that each stuck joint holds."""
        torque = u - self.bias(y)
        for j in (0, 1):
            if modes[j]:
                torque[j] -= modes[j] * self.level(j, modes[j] * y[2 + j])
        free = [j for j in (0, 1) if modes[j]]
        a = np.zeros(2)
        mass = self.mass(y[:2])
        if free:
            a[free] = np.linalg.solve(mass[np.ix_(free, free)], torque[free])
        return a, torque - mass @ a

    def choose(self, y: np.ndarray, u: np.ndarray) -> tuple[int, int]:
        options = [[int(np.sign(w))] if w else [0, 1, -1] for w in y[2:]]
        for modes in sorted(itertools.product(*options), key=lambda m: sum(map(abs, m))):
            a, held = self.accelerations(y, u, modes)
            if all(
                modes[j] * a[j] > 0 if modes[j] else abs(held[j]) <= self.level(j, 0.0)
                for j in (0, 1)
                if y[2 + j] == 0.0
            ):
                return modes
        raise AssertionError("no mode holds")

    def advance(
        self,
        y: np.ndarray,
        t: float,
        end: float,
        command: Command,
        modes: tuple[int, int],
        log: list[tuple[float, int]],
    ) -> tuple[np.ndarray, tuple[int, int]]:
        """Integrate to ``end``; every change of mode is appended to the log as (time, joint)."""
        while t < end:
            mode = modes

            def rate(s: float, z: np.ndarray, mode: tuple[int, int] = mode) -> np.ndarray:
                w = np.array([z[2 + j] if mode[j] else 0.0 for j in (0, 1)])
                return np.concatenate([w, self.accelerations(z, command(s, z), mode)[0]])

            def watch(j: int, mode: tuple[int, int] = mode) -> Callable[[float, np.ndarray], float]:
                def sliding(s: float, z: np.ndarray) -> float:
                    return mode[j] * z[2 + j] + (1e-300 if z[2 + j] == 0.0 else 0.0)

                def stuck(s: float, z: np.ndarray) -> float:
                    held = self.accelerations(z, command(s, z), mode)[1][j]
                    return self.level(j, 0.0) - abs(held)

                event = sliding if mode[j] else stuck
                event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]
                return event

            found = solve_ivp(
                rate, (t, end), y, "DOP853", events=[watch(0), watch(1)], rtol=2.3e-14, atol=1e-15, max_step=0.01
            )
            t, y = float(found.t[-1]), found.y[:, -1].copy()
            hit = [j for j in (0, 1) if len(found.t_events[j])]
            for j in hit:
                if mode[j]:
                    y[2 + j] = 0.0
            if not hit:
                break
            # a joint at its break-away level is let go: the level is passed by rounding only
            nudged = y if any(mode[j] for j in hit) else y + 0.0
            modes = self._after(nudged, command(t, y), mode, hit)
            log += [(t, j) for j in (0, 1) if modes[j] != mode[j]]
        return y, modes

    def _after(self, y: np.ndarray, u: np.ndarray, mode: tuple[int, int], hit: list[int]) -> tuple[int, int]:
        for j in hit:
            if mode[j] == 0:
                held = self.accelerations(y, u, mode)[1][j]
                return tuple(int(np.sign(held)) if i == j else mode[i] for i in (0, 1))  # type: ignore[return-value]
        return self.choose(y, u)
