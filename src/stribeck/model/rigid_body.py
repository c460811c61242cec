"""Rigid-body dynamics of a planar serial chain by the recursive Newton-Euler method.

Luh, Walker & Paul (1980), "On-line computational scheme for mechanical manipulators", in the plane.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import casadi as ca

from stribeck.model.values import Body, Expression

LINKS = ("mass", "com_x", "com_y", "inertia", "length")


def inverse_dynamics(
    body: Body,
    position: Sequence[Expression],
    velocity: Sequence[Expression],
    acceleration: Sequence[Expression],
    *,
    prismatic: bool = False,
) -> list[Expression]:
    """Return the joint torques (N m) that a motion needs, without rotors, friction or external torques.

    Parameters
    ----------
    body : Body
        Inertial parameters and gravity.
    position, velocity, acceleration : sequence of n expressions
        Relative joint angles (rad) and their derivatives; metres for a single prismatic axis.
    prismatic : bool
        The chain is one axis that slides along the base frame's x.
    """
    if prismatic:
        return [body.mass[0] * (acceleration[0] - body.gravity[0])]
    motion = [_column(values) for values in (position, velocity, acceleration)]
    return list(ca.vertsplit(_newton_euler(len(position))(*_links(body), _column(body.gravity), *motion)))


# as functions they are called many times faster than they are written down again


@cache
def _newton_euler(n: int) -> ca.Function:
    """Return (links, gravity, position, velocity, acceleration) -> torques (n, 1)."""
    links, gravity = _symbols(n, *LINKS), ca.SX.sym("gravity", 2)
    motion = _symbols(n, "position", "velocity", "acceleration")
    body = Body(*[ca.vertsplit(values) for values in (*links, gravity)])
    frames = _outward(body, *[ca.vertsplit(values) for values in motion])
    return ca.Function("newton_euler", [*links, gravity, *motion], [ca.vertcat(*_inward(body, frames))])


@cache
def _mass_matrix(n: int) -> ca.Function:
    """Return (links, position) -> mass matrix (n, n): the torques at unit accelerations, column by column."""
    links, position, zero = _symbols(n, *LINKS), ca.SX.sym("position", n), ca.DM.zeros(n)
    columns = [_newton_euler(n)(*links, ca.DM.zeros(2), position, zero, one) for one in ca.horzsplit(ca.DM.eye(n))]
    return ca.Function("mass_matrix", [*links, position], [ca.horzcat(*columns)])


@cache
def _base_force(n: int) -> ca.Function:
    """Return (links, position, velocity, way) -> force, coupling (n, 1) and mass of :func:`base_force`."""
    links, (position, velocity), way = _symbols(n, *LINKS), _symbols(n, "position", "velocity"), ca.SX.sym("way", 2)
    body = Body(*[ca.vertsplit(values) for values in (*links, ca.DM.zeros(2))])
    frames = _outward(body, ca.vertsplit(position), ca.vertsplit(velocity), [0.0] * n)
    force = sum(m * (cx * way[0] + cy * way[1]) for m, (_, _, _, _, cx, cy, _) in zip(body.mass, frames, strict=True))
    zero = ca.DM.zeros(n)
    coupling = _newton_euler(n)(*links, -way, position, zero, zero)
    return ca.Function("base_force", [*links, position, velocity, way], [force, coupling, ca.sum1(links[0])])


def _symbols(n: int, *names: str) -> list[ca.SX]:
    return [ca.SX.sym(name, n) for name in names]


def _links(body: Body) -> list[ca.SX]:
    return [_column(getattr(body, name)) for name in LINKS]


def _column(values: Sequence[Expression]) -> ca.SX:
    return ca.SX(ca.vertcat(*values))


_Frame = tuple[Expression, Expression, Expression, Expression, Expression, Expression, Expression]


def _outward(
    body: Body, position: Sequence[Expression], velocity: Sequence[Expression], acceleration: Sequence[Expression]
) -> list[_Frame]:
    """Return per link: com lever, link lever (base frame), com acceleration less gravity, angular acceleration."""
    angle: Expression = 0.0
    omega: Expression = 0.0
    alpha: Expression = 0.0
    ax, ay = -body.gravity[0], -body.gravity[1]
    frames = []
    for k in range(len(position)):
        angle, omega, alpha = angle + position[k], omega + velocity[k], alpha + acceleration[k]
        cos, sin = ca.cos(angle), ca.sin(angle)
        rx, ry = body.com_x[k] * cos - body.com_y[k] * sin, body.com_x[k] * sin + body.com_y[k] * cos
        lx, ly = body.length[k] * cos, body.length[k] * sin
        cx, cy = ax - alpha * ry - omega**2 * rx, ay + alpha * rx - omega**2 * ry
        frames.append((rx, ry, lx, ly, cx, cy, alpha))
        ax, ay = ax - alpha * ly - omega**2 * lx, ay + alpha * lx - omega**2 * ly
    return frames


def _inward(body: Body, frames: Sequence[_Frame]) -> list[Expression]:
    """Return joint torques by summing forces and moments from the tip to the base."""
    fx: Expression = 0.0
    fy: Expression = 0.0
    moment: Expression = 0.0
    torques: list[Expression] = []
    for k in reversed(range(len(frames))):
        rx, ry, lx, ly, cx, cy, alpha = frames[k]
        m = body.mass[k]
        moment = moment + body.inertia[k] * alpha + m * (rx * cy - ry * cx) + lx * fy - ly * fx
        fx, fy = fx + m * cx, fy + m * cy
        torques.append(moment)
    return torques[::-1]


def mass_matrix(body: Body, position: Sequence[Expression], *, prismatic: bool = False) -> ca.SX:
    """Return the mass matrix (n, n), kg m^2, without rotors; symmetric positive definite."""
    if prismatic:
        return ca.SX(body.mass[0])
    return _mass_matrix(len(position))(*_links(body), _column(position))


def base_force(
    body: Body, position: Sequence[Expression], velocity: Sequence[Expression], way: tuple[Expression, Expression]
) -> tuple[Expression, ca.SX, Expression]:
    """Return what the arm asks of a base that slides: force, torque at the joints by its acceleration, and mass.

    Parameters
    ----------
    body : Body
        Inertial parameters; its gravity is left out.
    position, velocity : sequence of n expressions
        Relative joint angles (rad) and velocities.
    way : (x, y)
        Unit vector along which the base slides.

    Returns
    -------
    force : expression
        Along the way, N, that the joints' velocities need; weight, which never changes, and accelerations apart.
    coupling : casadi.SX (n, 1)
        Torque at each joint by the base's acceleration, and force by that of the joint, N m/(m/s^2).
    mass : expression
        The arm's, kg.
    """
    given = (*_links(body), _column(position), _column(velocity), _column(way))
    force, coupling, mass = _base_force(len(position))(*given)
    return force, coupling, mass
