"""The bare arm against mechanics that is written down here anew."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from stribeck.withheld.plant import rigid_torque

G = 9.81


def lagrange(arm, q, dq):
    """Mass matrix, torque from speed and weight, energy: from the Lagrangian in absolute angles."""
    a, b = arm.joints
    # polar form of each centre of mass
    ra, fa = math.hypot(*a.com), math.atan2(a.com[1], a.com[0])
    rb, fb = math.hypot(*b.com), math.atan2(b.com[1], b.com[0])
    p1, p2 = q[0], q[0] + q[1]
    w1, w2 = dq[0], dq[0] + dq[1]
    j1 = a.inertia + a.mass * ra**2 + b.mass * a.length**2
    j2 = b.inertia + b.mass * rb**2
    h = b.mass * a.length * rb
    c, s = math.cos(p1 - p2 - fb), math.sin(p1 - p2 - fb)
    absolute = np.array([[j1, h * c], [h * c, j2]])
    force = np.array([-h * s * w2**2, h * s * w1**2])
    gx, gy = arm.gravity

    def pull(angle):  # what gravity does as the angle grows
        return -gx * math.sin(angle) + gy * math.cos(angle)

    weight = np.array([a.mass * ra * pull(p1 + fa) + b.mass * a.length * pull(p1), b.mass * rb * pull(p2 + fb)])
    t = np.array([[1.0, 0.0], [1.0, 1.0]])  # absolute from relative
    mass = t.T @ absolute @ t + np.diag([a.rotor_inertia, b.rotor_inertia])
    w = np.array([w1, w2])
    rotors = a.rotor_inertia * dq[0] ** 2 + b.rotor_inertia * dq[1] ** 2
    reach = a.mass * ra * (gx * math.cos(p1 + fa) + gy * math.sin(p1 + fa))
    reach += b.mass * (
        a.length * (gx * math.cos(p1) + gy * math.sin(p1)) + rb * (gx * math.cos(p2 + fb) + gy * math.sin(p2 + fb))
    )
    energy = 0.5 * (w @ absolute @ w + rotors) - reach
    return mass, t.T @ (force + weight), energy


@pytest.mark.parametrize("gravity", [(0.0, 0.0), (G, 0.0), (3.0, -4.0)])
def test_two_links_against_lagrange(bench, gravity):
    arm = bench.two_link(gravity, rough=False)

    def slope(t, y):
        mass, bias, _ = lagrange(arm, y[:2], y[2:])
        return np.concatenate([y[2:], np.linalg.solve(mass, bias)])

    start = ((1.2, 0.5), (-0.9, 2.0))
    t, trace = bench.open_loop(arm, lambda t: np.zeros((len(t), 2)), 3.0, start=start)
    y0 = [start[0][0], start[1][0], start[0][1], start[1][1]]
    truth = solve_ivp(slope, (0, 3), y0, t_eval=t, rtol=1e-10, atol=1e-12).y
    assert np.abs(trace.link - truth[:2].T).max() < 2e-6
    assert np.abs(trace.link_rate - truth[2:].T).max() < 2e-5


def test_command_is_held_from_its_sample_to_the_next(bench):
    arm = bench.two_link((9.81, 0.0), rough=False)
    torque = np.random.default_rng(2).normal(0.0, [8.0, 3.0], (41, 2))
    _, trace = bench.open_loop(arm, lambda t: torque, 0.4, rate=100.0)
    state, expected = np.zeros(4), [np.zeros(2)]
    for tau in torque[:-1]:

        def slope(t, y, tau=tau):
            mass, bias, _ = lagrange(arm, y[:2], y[2:])
            return np.concatenate([y[2:], np.linalg.solve(mass, tau + bias)])

        state = solve_ivp(slope, (0, 0.01), state, rtol=1e-9, atol=1e-11).y[:, -1]
        expected.append(state[:2])
    assert np.abs(trace.q - expected).max() < 1e-6
    assert np.abs(trace.q).max() > 0.1


def test_energy_stays(bench):
    arm = bench.two_link((G, 0.0), rough=False)
    _, trace = bench.open_loop(arm, lambda t: np.zeros((len(t), 2)), 10.0, start=((2.0, 0.0), (0.5, 0.0)))
    energy = np.array([lagrange(arm, q, w)[2] for q, w in zip(trace.link[::50], trace.link_rate[::50], strict=True)])
    swing = max(
        0.5 * w @ lagrange(arm, q, w)[0] @ w for q, w in zip(trace.link[::50], trace.link_rate[::50], strict=True)
    )
    assert np.ptp(energy) < 2e-6 * swing


def test_error_falls_with_the_step_squared(bench):
    arm = bench.two_link((G, 0.0), rough=False)

    def end(substeps):
        _, trace = bench.open_loop(
            arm, lambda t: np.zeros((len(t), 2)), 1.0, start=((2.0, 0.0), (0.5, 0.0)), rate=100.0, substeps=substeps
        )
        return trace.link[-1]

    fine = end(6400)
    coarse, half = np.abs(end(100) - fine).max(), np.abs(end(200) - fine).max()
    assert coarse / half == pytest.approx(4.0, rel=0.1)


def test_pendulum_period(bench):
    arm = bench.one_link((G, 0.0))
    joint = arm.joints[0]
    inertia = joint.inertia + joint.rotor_inertia + joint.mass * joint.com[0] ** 2
    omega = math.sqrt(joint.mass * G * joint.com[0] / inertia)
    swing = 1.5
    t, trace = bench.open_loop(arm, lambda t: np.zeros((len(t), 1)), 10.0, start=((swing, 0.0),))
    q = trace.link[:, 0]
    down = np.flatnonzero((q[:-1] > 0) & (q[1:] <= 0))
    cross = t[down] + q[down] / (q[down] - q[down + 1]) * 1e-3
    assert np.diff(cross) == pytest.approx(4.0 * ellipk(math.sin(swing / 2) ** 2) / omega, rel=1e-6)


def test_inverse_torque_against_lagrange(bench):
    arm = bench.two_link((2.0, -5.0))
    rng = np.random.default_rng(3)
    q, dq, ddq = rng.normal(size=(3, 20, 2))
    for torque, a, b, c in zip(rigid_torque(arm, q, dq, ddq), q, dq, ddq, strict=True):
        mass, bias, _ = lagrange(arm, a, b)
        assert torque == pytest.approx(mass @ c - bias, abs=1e-12)


def test_four_links_keep_energy(bench):
    from dataclasses import replace

    arm = bench.two_link((G, 0.0), rough=False)
    joints = tuple(replace(j, name=n) for n, j in zip("ABCD", arm.joints * 2, strict=True))
    arm = replace(arm, joints=joints)
    start = ((1.0, 0.0), (0.3, 0.0), (-0.5, 0.0), (0.8, 0.0))
    _, trace = bench.open_loop(arm, lambda t: np.zeros((len(t), 4)), 2.0, start=start)
    # power of the weight equals the change of the kinetic energy, both from torques along the motion
    zero = np.zeros_like(trace.link)
    weight = rigid_torque(arm, trace.link, zero, zero)
    work = np.concatenate(
        [
            [0.0],
            np.cumsum(0.5 * ((weight * trace.link_rate).sum(1)[1:] + (weight * trace.link_rate).sum(1)[:-1])) * 1e-3,
        ]
    )
    still = replace(arm, gravity=(0.0, 0.0))
    kinetic = 0.5 * ((rigid_torque(still, trace.link, zero, trace.link_rate)) * trace.link_rate).sum(1)
    assert kinetic.max() > 5.0
    assert np.abs(kinetic + work).max() < 1e-4 * kinetic.max()


def test_sliding_axis(bench):
    arm = bench.one_link((2.0, 0.0), kind="prismatic")
    t, trace = bench.open_loop(arm, lambda t: np.full((len(t), 1), 3.0), 1.0)
    assert trace.link[:, 0] == pytest.approx(0.5 * (3.0 + 2.0) / 1.02 * t**2, abs=1e-9)
