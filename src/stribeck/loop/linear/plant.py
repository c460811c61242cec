"""An arm with its effects, linear about an operating point."""

from __future__ import annotations

from dataclasses import dataclass, replace

import casadi as ca
import control as ct
import numpy as np
from numpy.typing import NDArray

from stribeck.arm import Arm
from stribeck.effects.placing import placed_effects, vanishes
from stribeck.errors import StribeckError
from stribeck.loop.linear.bends import adds
from stribeck.loop.linear.operating import OperatingPoint
from stribeck.model.effect import ActuatorEffect, FrictionEffect
from stribeck.model.forward import Forward
from stribeck.model.layout import values_of
from stribeck.model.path import SignalPath

Floats = NDArray[np.float64]

MOST_STEPS = 60
CLOSE = 1e-9  # of the steady state's balance, in units of each rate


@dataclass(frozen=True)
class LinearPlant:
    """A linear plant: command (N m) of the moving joints in, their recorded position and velocity out.

    Attributes
    ----------
    system : control.StateSpace
        Continuous; m inputs, 2 m outputs: all positions, then all velocities.
    joints : tuple of m ints
        The joints that move, by index.
    delays : array (m,)
        Delay of each input by the arm's own effects, s; no state space of finite size holds it.
    inertia : array (m,)
        That each joint moves, the others held, kg m^2.
    """

    system: ct.StateSpace
    joints: tuple[int, ...]
    delays: Floats
    inertia: Floats


def linearise(arm: Arm, point: OperatingPoint, *, at_motor: bool = False) -> LinearPlant:
    """Return an arm with the effects of its file, linear about an operating point, by exact derivatives.

    A dead zone passes torques as they came, and the faces of a play meet: where little is asked for, neither hands on
    any, and no gain would seem to hold the joint.

    Parameters
    ----------
    arm : Arm
    point : OperatingPoint
        The command and the effects' states that keep it steady are found by Newton's method.
    at_motor : bool
        The input is the torque at the motor, where friction acts, in place of the command: actuator effects are left
        out, but what they add whatever the command.

    Raises
    ------
    StribeckError
        When no command keeps the arm steady there.
    """
    forward, p = _model(arm, point, at_motor)
    n = arm.n
    modes = np.array([_mode(v, c) for v, c in zip(point.velocity, point.contact, strict=True)])
    modes = np.where([c == "sticks" and not forward.bristles[j] for j, c in enumerate(point.contact)], 0.0, modes)
    y, u = _steady(forward, p, point, modes)
    moving = [j for j in range(n) if modes[j] != 0.0]
    whole = np.asarray(forward.jacobian(0.0, y, modes, u, p).full())
    kept = [i for i in range(forward.size) if _moves(forward, i, moving)]
    a, b = whole[np.ix_(kept, kept)], whole[np.ix_(kept, [forward.size + j for j in moving])]
    c = _seen(forward, y, modes, u, p)[np.ix_([*moving, *(n + j for j in moving)], kept)]
    delays = np.zeros(n)
    for j, i in forward.delays:
        delays[j] += p[i]
    inertia = np.asarray(forward.inertia(y[:n], p).full()).ravel()
    system = ct.ss(a, b, c, np.zeros((len(c), len(moving))), **_labels(arm, moving))
    return LinearPlant(system, tuple(moving), delays[moving], inertia[moving])


def _model(arm: Arm, point: OperatingPoint, at_motor: bool) -> tuple[Forward, Floats]:
    """Return the forward equations without the effects that a linear model leaves out, and their parameter values."""
    placed = []
    for place in placed_effects(arm):
        frictionless = isinstance(place.effect, FrictionEffect) and point.contact[place.joint] in ("free", "clamped")
        passed = isinstance(place.effect, ActuatorEffect) and (place.effect.zone or (at_motor and not adds(place)))
        if not (vanishes(place) or frictionless or passed):
            placed.append(place)
    forward = Forward(SignalPath(replace(arm, effects=()), placed), touching=True)
    entries = forward.path.entries
    p = values_of(entries)
    for i, entry in enumerate(entries):
        if entry.owner == "friction" and entry.name != "alpha" and point.contact[entry.joint] in ("free", "clamped"):
            p[i] = 0.0
    return forward, p


def _mode(velocity: float, contact: str) -> float:
    return 0.0 if contact == "clamped" else 1.0 if velocity >= 0.0 else -1.0


def _steady(forward: Forward, p: Floats, point: OperatingPoint, modes: Floats) -> tuple[Floats, Floats]:
    """Return state and command without acceleration, with the effects' states at rest."""
    n, size = forward.n, forward.size
    position, velocity = np.array(point.position), np.array(point.velocity)
    parts = [*forward.true_motion(position, velocity, p), forward.settled(position, velocity, np.zeros(n), p)]
    y = np.concatenate([part.full().ravel() for part in parts])
    u = np.zeros(n)
    driven = [j for j in range(n) if modes[j] != 0.0]
    columns = [*range(2 * n, size), *(size + j for j in driven)]
    target = np.zeros(size)
    for j in forward.path.flexible:
        target[2 * n + forward.path.state_index(f"link[{j}].position")] = velocity[j]
    rows = np.array([*(n + j for j in driven), *range(2 * n, size)], dtype=int)
    for _ in range(MOST_STEPS):
        rates = np.asarray(forward.flow(0.0, y, modes, u, p)[0].full()).ravel()
        miss = rates[rows] - target[rows]
        slopes = np.asarray(forward.jacobian(0.0, y, modes, u, p).full())[np.ix_(rows, columns)]
        if not (np.all(np.isfinite(miss)) and np.all(np.isfinite(slopes))):
            break
        scale = 1.0 + np.abs(slopes) @ np.abs(np.concatenate([y[2 * n :], u[driven]]))
        if np.all(np.abs(miss) <= CLOSE * scale):
            return y, u
        move = np.linalg.lstsq(slopes, miss, rcond=1e-12)[0]
        y[2 * n :] -= move[: size - 2 * n]
        u[driven] -= move[size - 2 * n :]
    worst = f"{float(np.max(np.abs(miss))):.3g}"
    raise StribeckError("no command keeps the arm steady at this operating point", worst, "choose another one")


def _moves(forward: Forward, row: int, moving: list[int]) -> bool:
    """Tell whether a state belongs to what moves: not to a joint that is held."""
    n, path = forward.n, forward.path
    if row < 2 * n:
        return row % n in moving
    name = path.state_names[row - 2 * n]
    if name.startswith("link["):
        return True
    place = path.placed[int(name.split(".")[0])]
    return place.joint in moving or (place.effect.whole_arm and bool(moving))


def _seen(forward: Forward, y: Floats, modes: Floats, u: Floats, p: Floats) -> Floats:
    """Return d(recorded position and velocity)/d(state), (2 n, size)."""
    position, velocity, _, _ = forward.outputs(*forward.inputs)
    slope = ca.jacobian(ca.vertcat(position, velocity), forward.y)
    value = ca.Function("seen", forward.inputs, [ca.densify(slope)])(0.0, y, modes, u, p)
    return np.asarray(value.full())


def _labels(arm: Arm, moving: list[int]) -> dict[str, list[str]]:
    names = [arm.names[j] for j in moving]
    return {
        "inputs": [f"tau[{name}]" for name in names],
        "outputs": [f"{what}[{name}]" for what in ("q", "dq") for name in names],
    }
