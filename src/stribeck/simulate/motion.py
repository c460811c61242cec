"""What the engine gives back: a simulated motion, or many windows of one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

STATUS = ("ok", "unbounded", "too_many_events", "step_too_small", "too_many_steps", "not_finite")
EVENT = np.dtype([("time", float), ("before", float), ("after", float), ("joint", np.int32), ("_", np.int32)])
BOUND = 1e5  # rad and rad/s; beyond it a motion is unbounded


@dataclass(frozen=True)
class Trajectory:
    """A simulated motion of M samples, n joints and s states.

    Attributes
    ----------
    t : array (M,)
        s.
    q, dq : array (M, n)
        Position and velocity as the sensor gives them, rad and rad/s.
    modes : array (M, n)
        -1 or 1 sliding, 0 stuck; with a bristle, the velocity's sign.
    friction, actuator : array (M, n)
        Friction torque and the actuator's torque, N m.
    stuck_time : array (M, n)
        Time stuck since the start, s.
    top_speed : array (M, n)
        Largest speed on the motor side since the sample before, rad/s.
    state : array (M, s)
        True motor positions and velocities, then the path's states.
    events : structured array
        ``time``, ``joint``, ``before``, ``after`` (modes); the first ones where there are more than were asked for.
    status : str
        ``ok``, or why it ended early; then the rows from ``filled`` on are not a number.
    filled : int
        Rows that were reached.
    event_count, steps : int
        All events, and steps of the integration.
    """

    t: Floats
    q: Floats
    dq: Floats
    modes: Floats
    friction: Floats
    actuator: Floats
    stuck_time: Floats
    top_speed: Floats
    state: Floats
    events: np.ndarray
    status: str
    filled: int
    event_count: int
    steps: int

    @classmethod
    def of(
        cls, t: Floats, signals: Floats, modes: Floats, states: Floats, log: np.ndarray, info: np.ndarray
    ) -> Trajectory:
        """Return it from the runtime's arrays.

        Parameters
        ----------
        t : array (M,)
            s.
        signals : array (M, 6, n)
            Position, velocity, friction, actuator torque, stuck time and top speed.
        modes : array (M, n)
        states : array (M, s)
        log : structured array
            Events, then empty rows.
        info : array (4,) of int
            Number of the status, rows filled, events, steps.
        """
        status, filled, events, steps = (int(v) for v in info)
        kept = log[: min(events, len(log))][["time", "joint", "before", "after"]]
        columns = [signals[:, i] for i in range(signals.shape[1])]
        q, dq, friction, actuator, stuck_time, top_speed = columns
        return cls(
            t, q, dq, modes, friction, actuator, stuck_time, top_speed, states, kept, STATUS[status], filled, events,
            steps,
        )  # fmt: skip

    @property
    def ok(self) -> bool:
        """Whether it reached its end."""
        return self.status == "ok"


@dataclass(frozen=True)
class Windows:
    """Simulated windows, their R rows one after the other.

    Attributes
    ----------
    q, dq, modes, friction : array (R, n)
        As in `Trajectory`. Rows of a window from its ``filled`` on are not a number.
    samples, filled : array (W,) of int
        Rows of each window, and how many of them were reached.
    status : tuple of str
        Of each window.
    """

    q: Floats
    dq: Floats
    modes: Floats
    friction: Floats
    samples: np.ndarray
    filled: np.ndarray
    status: tuple[str, ...]
