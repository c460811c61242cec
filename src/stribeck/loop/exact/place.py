"""A place of a running loop, as one row of numbers that the C runtime reads and writes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stribeck.simulate.axis import MEMORY
from stribeck.simulate.source import CONTROLLER_STATES

Floats = NDArray[np.float64]

INTEGRAL, FILTER, LAG, THETA = range(4)  # of the controller's own states of a joint, continuous
_MEMORY, _MARKS = MEMORY.itemsize // 8, 5  # numbers of a sampled controller's memory, and of the present round, a joint


@dataclass(frozen=True)
class Place:
    """Where a loop is: enough to go on from.

    Attributes
    ----------
    values : array
        Laid out as `Layout` says.
    past : array (2, D, n)
        Of a sampled controller: its last D computed and issued commands, N m.
    sample : int
        Samples so far.
    """

    values: Floats
    past: Floats
    sample: int = 0

    @property
    def time(self) -> float:
        """Time so far, s."""
        return float(self.values[0])


@dataclass(frozen=True)
class Stretch:
    """What a loop did from one place to the next.

    Attributes
    ----------
    why : str
        Why it stopped: ``enough`` turns, ``quiet`` (nothing moves relative to the references any more), the ``end`` of
        the time, or the engine's status.
    turns : structured array
        ``time``, ``deviation`` (ahead of the reference), and since the joint's turn before ``low``, ``high``,
        ``speed``, ``stuck``; ``joint``.
    place : Place
        Where it stopped.
    record : array (R, 3, n)
        Deviation, velocity and mode, where they were asked for.
    """

    why: str
    turns: np.ndarray
    place: Place
    record: Floats


@dataclass(frozen=True)
class Layout:
    """Where things stand in a place's values.

    Attributes
    ----------
    n, size : int
        Joints, and states of the arm.
    """

    n: int
    size: int

    @property
    def ny(self) -> int:
        """States of the arm and of a continuous controller."""
        return self.size + CONTROLLER_STATES * self.n

    @property
    def state(self) -> slice:
        """All states."""
        return slice(2, 2 + self.ny)

    def _after(self, joints: int, width: int) -> slice:
        begin = 2 + self.ny + joints * self.n
        return slice(begin, begin + width * self.n)

    @property
    def modes(self) -> slice:
        """Contact modes."""
        return self._after(0, 1)

    @property
    def held(self) -> slice:
        """The last sign, other than 0, of each joint's velocity as a continuous law takes it."""
        return self._after(1, 1)

    @property
    def torque(self) -> slice:
        """Commanded torque of each joint, N m."""
        return self._after(2, 1)

    @property
    def memory(self) -> slice:
        """Memory of a sampled controller: last position, filter, integral, held direction, theta (3)."""
        return self._after(3, _MEMORY)

    @property
    def marks(self) -> slice:
        """Of the present round: above, low, high, time stuck, top speed."""
        return self._after(3 + _MEMORY, _MARKS)

    @property
    def memory_width(self) -> int:
        """Numbers of a joint's memory."""
        return _MEMORY

    def own(self, j: int, which: int) -> int:
        """Return the index among all states of a continuous controller's own state of joint j."""
        return self.size + CONTROLLER_STATES * j + which

    def start(self, state: Floats, theta: Floats, sampled: bool) -> Floats:
        """Return the values at time 0 from the arm's state (s,) and the laws' constants (n, 3).

        No position was measured before, so that the first sample sees no velocity.
        """
        values = np.zeros(self.marks.stop)
        values[2 : 2 + self.size] = state
        memory = values[self.memory].reshape(self.n, _MEMORY)
        memory[:, 0], memory[:, 4:] = np.nan, theta
        if not sampled:
            values[2 + self.size : 2 + self.ny].reshape(self.n, CONTROLLER_STATES)[:, THETA:] = theta
        return self.anew(values)

    def anew(self, values: Floats) -> Floats:
        """Return values from which to go on under another reference: modes are to be found, there is no round yet."""
        out = values.copy()
        out[1], out[self.marks] = 1.0, 0.0
        out[self.marks].reshape(self.n, _MARKS)[:, 0] = 2.0
        return out
