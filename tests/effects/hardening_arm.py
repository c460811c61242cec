"""Two joints, of which one drives harder the harder it is driven: simulated by SciPy, with no line of the library's.

The effect of `studies/own_effect` is the truth here: tau = u (1 + (u/U)^2). Equations of motion by hand, for links
whose angles are counted from the downward vertical and from each other.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import solve_ivp

RATE, SECONDS, COUNT, SLIP = 250.0, 6.0, 2.0 * math.pi / 2**17, 0.004
LENGTH, MASS, CENTRE, INERTIA, ROTOR = (0.35, 0.30), (4.0, 2.0), (0.17, 0.13), (0.06, 0.03), (0.15, 0.06)
C0, C1, C2, ALPHA = np.array([2.3, 1.1]), np.array([0.7, 0.3]), np.array([0.9, 0.5]), 0.08
DOUBLING = np.array([22.0, math.inf])  # N m, of each joint's drive
KP, KD = np.array([220.0, 70.0]), np.array([22.0, 6.0])
OFF = {"mass": (1.03, 0.96), "inertia": (0.95, 1.04), "C0": (1.2, 0.85), "C2": (0.8, 1.15)}  # of the data sheet


def acceleration(q: np.ndarray, dq: np.ndarray, command: np.ndarray) -> np.ndarray:
    """Return the joints' accelerations under commanded torques, rad/s^2."""
    (l1, _), (m1, m2), (c1, c2), (i1, i2) = LENGTH, MASS, CENTRE, INERTIA
    far, both = m2 * c2**2 + i2, m2 * l1 * c2 * math.cos(q[1])
    near = m1 * c1**2 + i1 + m2 * l1**2 + far + 2.0 * both
    mass = np.array([[near + ROTOR[0], far + both], [far + both, far + ROTOR[1]]])
    swing = m2 * l1 * c2 * math.sin(q[1])
    spin = np.array([-swing * dq[1] * (2.0 * dq[0] + dq[1]), swing * dq[0] ** 2])
    outer = 9.81 * m2 * c2 * math.sin(q[0] + q[1])
    weight = np.array([9.81 * (m1 * c1 + m2 * l1) * math.sin(q[0]) + outer, outer])
    speed = np.abs(dq)
    friction = (C0 + C1 * np.exp(-speed / ALPHA)) * np.tanh(dq / SLIP) + C2 * dq
    drive = command * (1.0 + (command / DOUBLING) ** 2)
    return np.asarray(np.linalg.solve(mass, drive - spin - weight - friction))


def recorded(seed: int) -> np.ndarray:
    """Return rows of t, q1, q2, tau1, tau2: a sampled PD controller follows sines of random phases."""
    rng = np.random.default_rng(seed)
    rate = np.array([[0.23, 0.61, 1.3], [0.31, 0.83, 1.7]])
    size, phase = np.array([[0.7, 0.3, 0.12], [0.8, 0.35, 0.1]]) * rng.uniform(0.6, 1.2), rng.uniform(0, 7, (2, 3))

    def wanted(t: float) -> np.ndarray:
        return np.asarray((size * np.sin(2.0 * math.pi * rate * t + phase)).sum(axis=1))

    def pace(t: float) -> np.ndarray:
        return 0.5 * RATE * (wanted(t + 1.0 / RATE) - wanted(t - 1.0 / RATE))

    state, before, velocity, rows = np.concatenate([wanted(0.0), pace(0.0)]), wanted(-1.0 / RATE), pace(0.0), []
    for t in np.arange(round(RATE * SECONDS)) / RATE:
        seen = COUNT * np.round((state[:2] + 0.3 * COUNT * rng.standard_normal(2)) / COUNT)
        velocity, before = 0.6 * velocity + 0.4 * RATE * (seen - before), seen
        command = KP * (wanted(t) - seen) + KD * (pace(t) - velocity)
        rows.append([t, *seen, *command])

        def motion(_: float, x: np.ndarray, u: np.ndarray = command) -> np.ndarray:
            return np.concatenate([x[2:], acceleration(x[:2], x[2:], u)])

        state = solve_ivp(motion, (0.0, 1.0 / RATE), state, rtol=1e-6, atol=1e-9, first_step=4e-4).y[:, -1]
    return np.array(rows)


def arm_file() -> str:
    """Return the arm file of its data sheet, which is a little off and knows nothing of the drive."""
    joints = [
        f'[[joints]]\nname = "{name}"\nkind = "revolute"\nlength = {LENGTH[j]}\nmass = {MASS[j] * OFF["mass"][j]}\n'
        f"com = [{CENTRE[j]}, 0.0]\ninertia = {INERTIA[j] * OFF['inertia'][j]}\nrotor_inertia = {ROTOR[j]}\n"
        f"encoder_resolution = {COUNT}\n[joints.friction]\nC0 = {C0[j] * OFF['C0'][j]}\nC1 = {C1[j]}\n"
        f"C2 = {C2[j] * OFF['C2'][j]}\nalpha = {ALPHA}\n"
        for j, name in enumerate("AB")
    ]
    head = f'schema = "stribeck.arm/1"\nname = "two joints"\ngravity = [9.81, 0.0]\nsample_time = {1 / RATE}\n'
    return head + "[tolerance]\ninertial = 0.05\nfriction = 0.3\n" + "".join(joints)
