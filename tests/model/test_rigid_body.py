"""The rigid body against closed forms and conservation laws, for chains of random size."""

import math
from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stribeck.model.rigid_body import inverse_dynamics, mass_matrix
from stribeck.model.values import Body

ANGLE = st.floats(-7.0, 7.0)
SPEED = st.floats(-8.0, 8.0)


def number(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, allow_subnormal=False)


@st.composite
def bodies(draw: st.DrawFn, n: int | None = None) -> Body:
    count = draw(st.integers(1, 4)) if n is None else n

    def column(low: float, high: float) -> tuple[float, ...]:
        return tuple(draw(number(low, high)) for _ in range(count))

    gravity = (draw(number(-10.0, 10.0)), draw(number(-10.0, 10.0)))
    return Body(column(0.05, 20.0), column(-0.4, 0.4), column(-0.2, 0.2), column(1e-3, 2.0), column(0.1, 0.6), gravity)


def vectors(n: int, element: st.SearchStrategy[float]) -> st.SearchStrategy[np.ndarray]:
    return st.lists(element, min_size=n, max_size=n).map(np.array)


def torques(body: Body, *motion: np.ndarray, prismatic: bool = False) -> np.ndarray:
    rows = inverse_dynamics(body, *[[float(x) for x in row] for row in motion], prismatic=prismatic)
    return np.array([float(value) for value in rows])


def mass(body: Body, q: np.ndarray) -> np.ndarray:
    return np.asarray(ca.DM(mass_matrix(body, [float(x) for x in q])))


def places(body: Body, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centres of mass (n, 2) and angles (n,) of the links, by plain trigonometry."""
    angle = np.cumsum(q)
    along = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    across = np.stack([-np.sin(angle), np.cos(angle)], axis=1)
    joints = np.concatenate([np.zeros((1, 2)), np.cumsum(np.array(body.length)[:, None] * along, axis=0)[:-1]])
    return joints + np.array(body.com_x)[:, None] * along + np.array(body.com_y)[:, None] * across, angle


def energy(body: Body, q: np.ndarray, dq: np.ndarray) -> float:
    """Kinetic and potential energy from the motion of each centre of mass, velocities by differences."""
    h = 1e-5
    ahead, behind = places(body, q + h * dq)[0], places(body, q - h * dq)[0]
    velocity = (ahead - behind) / (2 * h)
    m, turning = np.array(body.mass), np.array(body.inertia)
    kinetic = 0.5 * float(m @ np.sum(velocity**2, axis=1)) + 0.5 * float(turning @ np.cumsum(dq) ** 2)
    return kinetic - float(m @ (places(body, q)[0] @ np.array(body.gravity)))


@settings(max_examples=60)
@given(data=st.data(), body=bodies())
def test_mass_matrix_is_symmetric_and_positive_definite(data: st.DataObject, body: Body) -> None:
    n = len(body.mass)
    matrix = mass(body, data.draw(vectors(n, ANGLE)))
    size = np.abs(matrix).max()
    assert matrix == pytest.approx(matrix.T, abs=1e-12 * size)
    assert np.linalg.eigvalsh(matrix).min() > 0.0
    np.linalg.cholesky(matrix)


@settings(max_examples=60)
@given(data=st.data(), body=bodies())
def test_mass_matrix_gives_the_kinetic_energy(data: st.DataObject, body: Body) -> None:
    n = len(body.mass)
    q, dq = data.draw(vectors(n, ANGLE)), data.draw(vectors(n, SPEED))
    still = Body(body.mass, body.com_x, body.com_y, body.inertia, body.length, (0.0, 0.0))
    assert 0.5 * float(dq @ mass(body, q) @ dq) == pytest.approx(energy(still, q, dq), rel=1e-6, abs=1e-9)


@settings(max_examples=60)
@given(data=st.data(), body=bodies())
def test_power_balance(data: st.DataObject, body: Body) -> None:
    """What the joints put in along a motion is what kinetic and potential energy gain."""
    n = len(body.mass)
    q, dq, ddq = (data.draw(vectors(n, strategy)) for strategy in (ANGLE, SPEED, st.floats(-20.0, 20.0)))
    power = float(torques(body, q, dq, ddq) @ dq)
    h = 1e-4

    def later(t: float) -> float:
        return energy(body, q + t * dq + 0.5 * t**2 * ddq, dq + t * ddq)

    gained = (8 * (later(h) - later(-h)) - (later(2 * h) - later(-2 * h))) / (12 * h)
    scale = 1.0 + abs(later(0.0)) + float(np.abs(torques(body, q, dq, ddq)) @ np.abs(dq))
    assert power == pytest.approx(gained, abs=3e-6 * scale)


@settings(max_examples=40)
@given(body=bodies(1), q=ANGLE, dq=SPEED, ddq=SPEED)
def test_pendulum(body: Body, q: float, dq: float, ddq: float) -> None:
    """(I + m r^2) ddq = tau + m r x g."""
    m, x, y, (gx, gy) = body.mass[0], body.com_x[0], body.com_y[0], body.gravity
    rx, ry = x * math.cos(q) - y * math.sin(q), x * math.sin(q) + y * math.cos(q)
    expected = (body.inertia[0] + m * (x**2 + y**2)) * ddq - m * (rx * gy - ry * gx)
    assert torques(body, *[np.array([v]) for v in (q, dq, ddq)])[0] == pytest.approx(expected, rel=1e-9, abs=1e-9)


@settings(max_examples=40)
@given(data=st.data(), body=bodies(2))
def test_two_links(data: st.DataObject, body: Body) -> None:
    """The textbook arm with centres of mass on the links (Craig, Introduction to Robotics, ch. 6), g along -y."""
    q, dq, ddq = (data.draw(vectors(2, strategy)) for strategy in (ANGLE, SPEED, SPEED))
    g = 9.81
    body = Body(body.mass, body.com_x, (0.0, 0.0), body.inertia, body.length, (0.0, -g))
    (m1, m2), (r1, r2), (i1, i2), l1 = body.mass, body.com_x, body.inertia, body.length[0]
    c1, c12, c2, s2 = math.cos(q[0]), math.cos(q[0] + q[1]), math.cos(q[1]), math.sin(q[1])
    h = m2 * l1 * r2 * s2
    cross = m2 * (r2**2 + l1 * r2 * c2) + i2
    first = (m1 * r1**2 + i1 + m2 * (l1**2 + r2**2 + 2 * l1 * r2 * c2) + i2) * ddq[0] + cross * ddq[1]
    first += -h * dq[1] ** 2 - 2 * h * dq[0] * dq[1] + (m1 * r1 + m2 * l1) * g * c1 + m2 * r2 * g * c12
    second = cross * ddq[0] + (m2 * r2**2 + i2) * ddq[1] + h * dq[0] ** 2 + m2 * r2 * g * c12
    assert torques(body, q, dq, ddq) == pytest.approx([first, second], rel=1e-9, abs=1e-9)


def test_prismatic_axis() -> None:
    body = Body((3.0,), (0.1,), (0.0,), (0.5,), (0.2,), (-9.81, 4.0))
    moved = torques(body, *[np.array([v]) for v in (0.4, 2.0, 1.5)], prismatic=True)
    assert moved[0] == pytest.approx(3.0 * (1.5 + 9.81))
    assert float(ca.DM(mass_matrix(body, [0.4], prismatic=True))) == 3.0


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_torque_is_linear_in_acceleration(n: int) -> None:
    """M(q) a + bias: the mass matrix and the recursion are one model."""
    rng = np.random.default_rng(n)
    draw: Callable[..., tuple[float, ...]] = lambda low, high: tuple(rng.uniform(low, high, n))  # noqa: E731
    body = Body(draw(0.5, 4), draw(-0.2, 0.2), draw(-0.1, 0.1), draw(0.01, 0.2), draw(0.2, 0.5), (3.0, -9.0))
    q, dq, ddq = rng.normal(size=(3, n))
    assert torques(body, q, dq, ddq) == pytest.approx(torques(body, q, dq, 0 * ddq) + mass(body, q) @ ddq, rel=1e-10)
