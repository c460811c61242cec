"""Rigid-body dynamics of a planar serial chain by the recursive Newton-Euler method.

Luh, Walker & Paul (1980), "On-line computational scheme for mechanical manipulators", in the plane.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import casadi as ca

from stribeck.model.values import Body, Expression


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
    links = (body.mass, body.com_x, body.com_y, body.inertia, body.length, body.gravity)
    given = [ca.SX(ca.vertcat(*values)) for values in (*links, position, velocity, acceleration)]
    return list(ca.vertsplit(_newton_euler(len(position))(*given)))


@cache
def _newton_euler(n: int) -> ca.Function:
    """Return the recursion as a function: to call it is many times faster than to write it down again."""
    links = [ca.SX.sym(name, n) for name in ("mass", "com_x", "com_y", "inertia", "length")]
    gravity = ca.SX.sym("gravity", 2)
    motion = [ca.SX.sym(name, n) for name in ("position", "velocity", "acceleration")]
    body = Body(*[ca.vertsplit(values) for values in (*links, gravity)])
    frames = _outward(body, *[ca.vertsplit(values) for values in motion])
    return ca.Function("newton_euler", [*links, gravity, *motion], [ca.vertcat(*_inward(body, frames))])


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
    n = len(position)
    zero = [0.0] * n
    still = _no_gravity(body)
    columns = [
        ca.vertcat(
            *inverse_dynamics(still, position, zero, [1.0 if i == k else 0.0 for i in range(n)], prismatic=prismatic)
        )
        for k in range(n)
    ]
    return ca.horzcat(*columns)


def base_force(
    body: Body, position: Sequence[Expression], velocity: Sequence[Expression], way: tuple[Expression, Expression]
) -> tuple[Expression, list[Expression], Expression]:
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
    coupling : list of n expressions
        Torque at each joint by the base's acceleration, and force by that of the joint, N m/(m/s^2).
    mass : expression
        The arm's, kg.
    """
    still = [0.0] * len(position)
    frames = _outward(_no_gravity(body), position, velocity, still)
    force: Expression = 0.0
    mass: Expression = 0.0
    for k, (_, _, _, _, cx, cy, _) in enumerate(frames):
        force, mass = force + body.mass[k] * (cx * way[0] + cy * way[1]), mass + body.mass[k]
    pushed = replace(body, gravity=(-way[0], -way[1]))
    return force, inverse_dynamics(pushed, position, still, still), mass


def _no_gravity(body: Body) -> Body:
    return Body(body.mass, body.com_x, body.com_y, body.inertia, body.length, (0.0, 0.0))
