"""Where the end of a planar chain is, how fast it moves, and the levers of a force there about the joints."""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from stribeck.model.values import Expression, Signals, Tip


def tip_of(
    length: Sequence[Expression], motion: Sequence[Signals]
) -> tuple[Tip, tuple[tuple[Expression, Expression], ...]]:
    """Return the tip of a chain of links, m, and its vector (x, y) from each joint, m, in the base frame."""
    angle: Expression = 0.0
    links = []
    for long, s in zip(length, motion, strict=True):
        angle = angle + s.link_position
        links.append((long * ca.cos(angle), long * ca.sin(angle)))
    x: Expression = 0.0
    y: Expression = 0.0
    dx: Expression = 0.0
    dy: Expression = 0.0
    levers = []
    for (along, across), s in zip(reversed(links), reversed(motion), strict=True):
        x, y = x + along, y + across
        dx, dy = dx - y * s.link_velocity, dy + x * s.link_velocity
        levers.append((x, y))
    return Tip(x, y, dx, dy), tuple(reversed(levers))
