"""What a closed loop did, in numbers: ``simulation.json`` (``stribeck.simulation/1``)."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from stribeck.arm import Arm, unit_at
from stribeck.run import save_run
from stribeck.simulate.closed import Closed
from stribeck.simulate.loop import Loop
from stribeck.version import package_version

SCHEMA = "stribeck.simulation/1"
UNITS = {
    "mean_error": "rad",
    "rms_error": "rad",
    "peak_error": "rad",
    "stick_fraction": "1",
    "peak_velocity": "rad/s",
    "peak_torque": "N m",
    "ended": "s",
}

_SWITCHES = ("too_many_events", "too_many_steps", "step_too_small")  # how a simulation ends that jumps without end
MUCH_LIMITED = 0.01  # of the time with the command at its limit, from which on it is said


def measures(closed: Closed, joint: int, start: int) -> dict[str, float | None]:
    """Return the measures of one joint over the rows from ``start`` that were reached; None where there are none.

    Error is reference less measured position. Time stuck and speed are those between the rows too.
    """
    motion, rows = closed.motion, slice(start, closed.motion.filled)
    error = closed.error[rows, joint]
    time = motion.t[rows]
    if len(time) < 2:
        return dict.fromkeys(list(UNITS)[:6])
    stuck = motion.stuck_time[rows, joint]
    return {
        "mean_error": float(np.mean(error)),
        "rms_error": float(np.sqrt(np.mean(error**2))),
        "peak_error": float(np.max(np.abs(error))),
        "stick_fraction": float((stuck[-1] - stuck[0]) / (time[-1] - time[0])),
        "peak_velocity": float(np.max(motion.top_speed[rows, joint][1:])),
        "peak_torque": float(np.max(np.abs(closed.command[rows, joint]))),
    }


def share_at_limit(closed: Closed, arm: Arm, joint: int) -> float:
    """Return the share of the time for which the command of one joint is at the limit of its drive."""
    limit, rows = arm.joints[joint].torque_limit, slice(0, closed.motion.filled)
    if limit is None or not closed.motion.filled:
        return 0.0
    return float(np.mean(np.abs(closed.command[rows, joint]) >= limit * (1.0 - 1e-9)))


def limited(closed: Closed, arm: Arm) -> list[str]:
    """Return a line for each joint whose command is at its limit for much of the time."""
    shares = {arm.names[j]: share_at_limit(closed, arm, j) for j in closed.controlled}
    return [
        f"{name}: the command is at its limit for {100.0 * share:.3g} % of the time"
        for name, share in shares.items()
        if share >= MUCH_LIMITED
    ]


def simulation_json(closed: Closed, arm: Arm, loop: Loop) -> dict[str, Any]:
    """Return the content of ``simulation.json``: plain values, null where one is not finite."""
    half = len(closed.motion.t) // 2
    joints = {arm.names[j]: {**measures(closed, j, half), "whole": measures(closed, j, 0)} for j in closed.controlled}
    return {
        "schema": SCHEMA,
        "version": package_version(),
        "arm": arm.name,
        "units": {name: unit_at(unit, arm.joints[0].kind) for name, unit in UNITS.items()},
        "status": closed.motion.status,
        "ended": closed.ended,
        "duration": loop.duration,
        "sample_time": loop.sample_time,
        "seed": loop.seed,
        "events": closed.motion.event_count,
        "joints": _finite(joints),
    }


def write_simulation(closed: Closed, arm: Arm, loop: Loop, folder: Path) -> None:
    """Write ``simulation.csv`` (a run) and ``simulation.json`` into an existing folder."""
    save_run(closed.run("simulation.csv"), folder / "simulation.csv")
    text = json.dumps(simulation_json(closed, arm, loop), indent=2, ensure_ascii=False, allow_nan=False)
    (folder / "simulation.json").write_text(text + "\n", encoding="utf-8")


def stopped(closed: Closed, loop: Loop) -> list[str]:
    """Return a line on a simulation that ended early: when, and why where the loop's settings tell."""
    status = closed.motion.status
    if closed.motion.ok:
        return []
    said = f"{status} after {closed.ended:.6g} s"
    jumps = [entry.joint for entry in loop.joints if entry.compensation.kind == "robust"]
    if status in _SWITCHES and loop.sample_time == 0.0 and jumps:
        said += (
            f": a continuous robust law jumps, at {', '.join(jumps)}, and may switch without end; give a sample_time"
        )
    return [said]


def told(closed: Closed, arm: Arm) -> str:
    """Return one line on a simulation: how long, how many events, the error over the second half of its duration."""
    half, unit = len(closed.motion.t) // 2, unit_at("rad", arm.joints[0].kind)
    errors = [(arm.names[j], measures(closed, j, half)["rms_error"]) for j in closed.controlled]
    shown = ", ".join(f"{error:.3g} {unit} at {name}" for name, error in errors if error is not None)
    count = closed.motion.event_count
    said = f"{closed.ended:g} s simulated, {count} event{'s' * (count != 1)}"
    part = "the second half" if closed.motion.ok else "what was reached of the second half"
    return f"{said}; rms error over {part}: {shown}" if shown else said


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    return None if isinstance(value, float) and not math.isfinite(value) else value
