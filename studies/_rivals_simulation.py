"""The same control loop in MuJoCo and in scipy, to be timed against the engine."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from _paper import SAMPLE, bench
from scipy.integrate import solve_ivp

KP = np.array([60.0, 60.0])
AMPLITUDE, FREQUENCY = 0.3, 0.4  # rad, Hz: both joints reverse, stick and break away
SUBSTEPS = 25  # MuJoCo steps of half a millisecond a sample


def reference(t: float) -> tuple[float, float]:
    """Return position and velocity that both joints shall have."""
    w = 2.0 * np.pi * FREQUENCY
    return AMPLITUDE * np.sin(w * t), AMPLITUDE * w * np.cos(w * t)


def command(t: float, q: np.ndarray, last: np.ndarray) -> np.ndarray:
    """Return the PD torque, velocity by finite difference."""
    r, dr = reference(t)
    return KP * (r - q) + 2.0 * np.sqrt(KP) * (dr - (q - last) / SAMPLE)


def by_scipy(duration: float) -> tuple[np.ndarray, int]:
    """Simulate with `solve_ivp` and its events, on the engine's own equations; return the positions and the events."""
    flow, p, y, modes, events = bench().forward.flow, bench().p, np.zeros(4), np.zeros(2), 0
    last, rows = y[:2].copy(), []
    for k in range(round(duration / SAMPLE)):
        u = command(k * SAMPLE, y[:2], last)
        rows.append(y[:2].copy())
        last, t = y[:2].copy(), 0.0
        modes = _settled(flow, y, modes, u, p)
        while t < SAMPLE:
            found = solve_ivp(
                _rate(flow, modes, u, p), (t, SAMPLE), y, rtol=1e-9, atol=1e-10, events=_watch(flow, modes, u, p)
            )
            t, y = float(found.t[-1]), found.y[:, -1].copy()
            if found.status == 0:
                break
            events += 1
            for j in (0, 1):
                if modes[j] and len(found.t_events[j]):
                    y[2 + j] = 0.0
            modes = _settled(flow, y, modes, u, p)
    return np.array(rows), events


def _rate(flow: Any, modes: np.ndarray, u: np.ndarray, p: np.ndarray) -> Any:
    return lambda t, y: flow(t, y, modes, u, p)[0].full().ravel()


def _watch(flow: Any, modes: np.ndarray, u: np.ndarray, p: np.ndarray) -> list[Any]:
    def of(j: int) -> Any:
        def event(t: float, y: np.ndarray) -> float:
            if modes[j]:
                return float(modes[j] * y[2 + j]) + (1e-300 if y[2 + j] == 0.0 else 0.0)
            margins = flow(t, y, modes, u, p)[1].full().ravel()
            return float(min(margins[j], margins[2 + j]))

        event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]
        return event

    return [of(j) for j in (0, 1)]


def _settled(flow: Any, y: np.ndarray, before: np.ndarray, u: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return the modes that go with a state: rest where it holds, else the sign that the joint leaves in."""
    options = [[float(np.sign(w))] if w else [0.0, 1.0, -1.0] for w in y[2:]]
    for modes in sorted(itertools.product(*options), key=lambda m: sum(map(abs, m))):
        rates, margins = (v.full().ravel() for v in flow(0.0, y, modes, u, p))
        at_rest = [j for j in (0, 1) if y[2 + j] == 0.0]
        if all(modes[j] * rates[2 + j] > 0.0 if modes[j] else min(margins[j], margins[2 + j]) >= 0.0 for j in at_rest):
            return np.array(modes)
    return before


def mujoco_model() -> Any:
    """Return the paper's arm as a MuJoCo model; Coulomb friction at break-away's level, viscous friction as it is."""
    import mujoco

    one, two = bench().path.arm.joints
    bodies = [
        f'<joint name="{j.name}" axis="0 0 1" armature="{j.rotor_inertia}" damping="{j.friction.C2}" '
        f'frictionloss="{j.friction.C0 + j.friction.C1}"/>'
        f'<inertial pos="{j.com[0]} {j.com[1]} 0" mass="{j.mass}" diaginertia="{j.inertia} {j.inertia} {j.inertia}"/>'
        for j in (one, two)
    ]
    motors = "".join(f'<motor joint="{j.name}"/>' for j in (one, two))
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{SAMPLE / SUBSTEPS}" gravity="0 0 0" integrator="implicitfast"/><worldbody><body>'
        f'{bodies[0]}<body pos="{one.length} 0 0">{bodies[1]}</body></body></worldbody>'
        f"<actuator>{motors}</actuator></mujoco>"
    )


def by_mujoco(duration: float, model: Any) -> np.ndarray:
    """Simulate with MuJoCo; return the positions."""
    import mujoco

    data = mujoco.MjData(model)
    last, rows = data.qpos.copy(), []
    for k in range(round(duration / SAMPLE)):
        q = data.qpos.copy()
        data.ctrl[:] = command(k * SAMPLE, q, last)
        rows.append(q)
        last = q
        mujoco.mj_step(model, data, SUBSTEPS)
    return np.array(rows)


def mujoco_creep(model: Any, share: float = 0.9, duration: float = 100.0) -> float:
    """Return how far MuJoCo's joint A moves (rad) under a share of its break-away torque, where it should stay."""
    import mujoco

    data, friction = mujoco.MjData(model), bench().path.arm.joints[0].friction
    data.ctrl[0] = share * (friction.C0 + friction.C1)
    mujoco.mj_step(model, data, round(duration / model.opt.timestep))
    return float(abs(data.qpos[0]))
