"""The two-link arm of ``fmu/two_link_nominal`` as one writes it for PythonFMU3, which packs this file as it is.

``tolerance`` 0: Runge-Kutta steps of 1 ms; a joint whose velocity would change its sign in one stops. Above: scipy's
`solve_ivp` with that tolerance and an event where a joint stops or breaks away. Needs Python, numpy and scipy wherever
the FMU runs.
"""

import itertools
from math import copysign, cos, exp, sin

import numpy as np
from pythonfmu3 import Float64, Fmi3Causality, Fmi3Slave, Fmi3Variability
from scipy.integrate import solve_ivp

STEP = 1e-3  # s
FRICTION = ((5.0, 1.25, 1.5, 0.05), (2.2, 0.6, 0.8, 0.04))  # C0, C1 (N m), C2 (N m s/rad), alpha (rad/s)
LENGTH, MASS2, X2, Y2 = 0.35, 2.0, 0.13, -0.01  # m, kg; the second link's centre of mass, m
BOTH = 0.02 + MASS2 * (X2**2 + Y2**2)  # kg m^2: the second link about its own joint
SECOND = BOTH + 0.08
FIRST = 0.06 + 4.0 * (0.17**2 + 0.02**2) + 0.15 + BOTH + MASS2 * LENGTH**2


def balance(y, modes, u):
    """Return the accelerations, rad/s^2, and what each joint's friction must hold to keep its acceleration 0, N m."""
    c, s = cos(y[1]), sin(y[1])
    k, slope = MASS2 * LENGTH * (X2 * c - Y2 * s), -MASS2 * LENGTH * (X2 * s + Y2 * c)
    m11, m12 = FIRST + 2.0 * k, BOTH + k
    free = (u[0] - slope * y[3] * (2.0 * y[2] + y[3]), u[1] + slope * y[2] ** 2)
    r0, r1 = (
        free[j] - mode * (c0 + c1 * exp(-max(mode * v, 0.0) / alpha)) - c2 * v
        for j, (mode, v, (c0, c1, c2, alpha)) in enumerate(zip(modes, y[2:], FRICTION, strict=True))
    )
    if modes[0] and modes[1]:
        determinant = m11 * SECOND - m12 * m12
        a = ((SECOND * r0 - m12 * r1) / determinant, (m11 * r1 - m12 * r0) / determinant)
    else:
        a = (r0 / m11 if modes[0] else 0.0, r1 / SECOND if modes[1] else 0.0)
    return a, (free[0] - m12 * a[1], free[1] - m12 * a[0])


def rates(y, modes, u):
    """Return the time derivatives of q and v; a joint that sticks stands still."""
    return np.array([y[2], y[3], *balance(y, modes, u)[0]])


def margin(y, modes, u, j):
    """Return what is left before joint j stops or breaks away: it falls through 0 there."""
    if modes[j]:
        return modes[j] * y[2 + j]
    return FRICTION[j][0] + FRICTION[j][1] - abs(balance(y, modes, u)[1][j])


def settled(y, u):
    """Return the modes that go with a state: at rest where friction holds it."""
    options = [[copysign(1.0, v)] if v else [0.0, 1.0, -1.0] for v in y[2:]]
    for modes in sorted(itertools.product(*options), key=lambda m: sum(map(abs, m))):
        a, _ = balance(y, modes, u)
        if all(y[2 + j] or (modes[j] * a[j] > 0.0 if modes[j] else margin(y, modes, u, j) >= 0.0) for j in (0, 1)):
            return modes
    raise RuntimeError("no modes go with this state")


class TwoLinkArm(Fmi3Slave):
    """Torques in, positions out."""

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.y, self.u, self.time, self.tolerance = np.zeros(4), [0.0, 0.0], 0.0, 0.0
        self.register_variable(
            Float64("time", causality=Fmi3Causality.independent, variability=Fmi3Variability.continuous)
        )
        for j in (0, 1):
            torque = {"getter": lambda j=j: self.u[j], "setter": lambda value, j=j: self.u.__setitem__(j, value)}
            self.register_variable(Float64(f"tau[{j + 1}]", causality=Fmi3Causality.input, **torque))
        for j in (0, 1):
            self.register_variable(
                Float64(f"q[{j + 1}]", causality=Fmi3Causality.output, getter=lambda j=j: float(self.y[j]))
            )
        self.register_variable(
            Float64("tolerance", causality=Fmi3Causality.parameter, variability=Fmi3Variability.tunable)
        )

    def do_step(self, current_time, step_size):
        """Move on by the step."""
        (self.with_events if self.tolerance else self.in_fixed_steps)(step_size)
        self.time = current_time + step_size
        return True

    def in_fixed_steps(self, duration):
        """Take Runge-Kutta's classical steps."""
        count = max(round(duration / STEP), 1)
        h = duration / count
        for _ in range(count):
            y, modes, u = self.y, settled(self.y, self.u), self.u
            k1 = rates(y, modes, u)
            k2 = rates(y + 0.5 * h * k1, modes, u)
            k3 = rates(y + 0.5 * h * k2, modes, u)
            self.y = y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + rates(y + h * k3, modes, u))
            for j in (0, 1):
                if modes[j] * self.y[2 + j] <= 0.0:
                    self.y[2 + j] = 0.0

    def with_events(self, duration):
        """Integrate from event to event."""
        t, u = 0.0, self.u
        while t < duration:
            modes = settled(self.y, u)
            events = [lambda t, y, j=j, modes=modes: margin(y, modes, u, j) for j in (0, 1)]
            for event in events:
                vars(event).update(terminal=True, direction=-1.0)
            found = solve_ivp(
                lambda t, y, modes=modes: rates(y, modes, u), (t, duration), self.y,
                rtol=self.tolerance, atol=0.1 * self.tolerance, events=events,
            )  # fmt: skip
            t, self.y = float(found.t[-1]), found.y[:, -1].copy()
            for j in (0, 1):
                if modes[j] and len(found.t_events[j]):
                    self.y[2 + j] = 0.0
