"""A cut's functions as programs of the vector machine: states along recordings, side by side.

To write the equations down and to put them in order takes as long as to run them along a short recording. They are the
same for all values of the parameters, so that a search meets most of its models several times.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Hashable, Sequence
from functools import cached_property

import numpy as np

from stribeck.identify.conditioning import emphasised
from stribeck.identify.recursion import Recursion
from stribeck.identify.tape import Tape
from stribeck.model.cut import Cut
from stribeck.model.path import SignalPath

KEPT = 512  # machines, of the last that were asked for: a tenth of a megabyte each for two joints
MOST_KEPT = 8_000_000  # numbers that one residual keeps
_kept: OrderedDict[Hashable, Machine] = OrderedDict()


def machine_of(
    path: SignalPath,
    sample_time: float,
    columns: tuple[int, ...],
    *,
    observe: bool,
    moving: tuple[int, ...] | None = None,
) -> Machine:
    """Return the machine of a path's cut, the same for all paths of one structure.

    Parameters
    ----------
    path, sample_time, columns, observe : SignalPath, float, tuple of int, bool
        As of :class:`stribeck.model.cut.Cut`; the time in s.
    moving : tuple of int or None
        As of :class:`Machine`.
    """
    key = path.structure, sample_time, columns, observe, moving
    machine = _kept.pop(key, None) or Machine(Cut(path, sample_time, columns, observe=observe), moving)
    _kept[key] = machine
    while len(_kept) > KEPT:
        _kept.popitem(last=False)
    return machine


class Abreast:
    """Drives side by side; the last ones are kept, for a fit asks for the same ones again."""

    def __init__(self) -> None:
        self._last: tuple[tuple[np.ndarray, ...], np.ndarray] = ((), np.empty(0))

    def of(self, machine: Machine, drives: Sequence[np.ndarray]) -> np.ndarray:
        """Return drives as a machine takes them (rows, T, R), each ending with its last sample again and again."""
        known, together = self._last
        if len(known) == len(drives) and all(one is other for one, other in zip(known, drives, strict=True)):
            return together
        self._last = (), np.empty(0)  # its memory is free before it is needed again
        lengths = [drive.shape[1] for drive in drives]
        together = np.empty((drives[0].shape[0], max(lengths), len(drives)))
        for i, drive in enumerate(drives):
            together[:, : lengths[i], i] = machine.between(drive)
            together[:, lengths[i] :, i] = together[:, lengths[i] - 1, None, i]
        self._last = tuple(drives), together
        return together


class Kept:
    """What a residual's moving parameters and states do not change, along each drive: made once."""

    def __init__(self) -> None:
        self._by = b""
        self._of: dict[int, tuple[np.ndarray, np.ndarray]] = {}

    def along(self, machine: Machine, drive: np.ndarray, p: np.ndarray, delays: np.ndarray) -> np.ndarray | None:
        """Return what a machine's tape keeps along a drive; None where all may change, or it would be too much."""
        if machine.moving is None:
            return None
        by = p[machine.still].tobytes() + delays.tobytes()
        if by != self._by:
            self._by, self._of = by, {}
        if id(drive) not in self._of:
            if sum(values.size for _, values in self._of.values()) > MOST_KEPT:
                return None
            self._of[id(drive)] = drive, machine.evaluate.keep([drive, np.empty((0, 0)), p, delays])
        return self._of[id(drive)][1]


class Machine:
    """A cut's functions as programs.

    Parameters
    ----------
    cut : Cut
    moving : tuple of int or None
        The only parameters that change from call to call, the drive being the same; None where all may change.
    """

    def __init__(self, cut: Cut, moving: tuple[int, ...] | None = None) -> None:
        self.cut, self.moving = cut, moving
        self.still = [] if moving is None else [i for i in range(cut.path.p.numel()) if i not in moving]

    @cached_property
    def evaluate(self) -> Tape:
        """Residual and Jacobian of each sample."""
        function = self.cut.evaluate
        drive, delays = (range(function.numel_in(i)) for i in (0, 3))
        steady = {} if self.moving is None else {0: drive, 2: self.still, 3: delays}
        return Tape(function, fixed=(2, 3), steady=steady)

    @cached_property
    def follow(self) -> Recursion:
        """States one sample later, at the same values on all lanes."""
        return Recursion(self.cut.follow, fixed=(3, 4))

    @cached_property
    def begin_each(self) -> Tape:
        """States at the first sample, at values of each lane's own."""
        return Tape(self.cut.begin, fixed=(0, 2))

    @cached_property
    def follow_each(self) -> Recursion:
        """States one sample later, at values of each lane's own."""
        return Recursion(self.cut.follow, fixed=(4,))

    def states(
        self, drives: Sequence[np.ndarray], p: np.ndarray, delays: np.ndarray, abreast: Abreast
    ) -> list[np.ndarray]:
        """Return states and sensitivities (nx (1 + active), N) for each drive, advanced side by side."""
        cut, lengths = self.cut, [drive.shape[1] for drive in drives]
        if cut.nx == 0 or not drives:
            return [np.zeros((0, length)) for length in lengths]
        start = np.hstack([cut.begin(drive[:, 0], p, delays).full() for drive in drives])
        out = self.follow.march(start, abreast.of(self, drives), p, delays)
        return [cut.settled(out[:length, :, i].T) for i, length in enumerate(lengths)]

    def states_at(
        self, drives: Sequence[np.ndarray], values: Sequence[np.ndarray], delays: np.ndarray, abreast: Abreast
    ) -> list[list[np.ndarray]]:
        """Return states and sensitivities (nx (1 + active), N) for each drive at each of some parameter values."""
        cut, count, columns = self.cut, len(drives), np.transpose(values)
        first = [self.begin_each.whole(self.begin_each.map([drive[:, 0], columns, delays]).T).T for drive in drives]
        shape = cut.follow.numel_in(0), count * len(values)  # all drives at the first values, then at the next ones
        start = np.stack(first, axis=2).reshape(shape)
        out = self.follow_each.march(start, abreast.of(self, drives), np.repeat(columns, count, axis=1), delays)
        return [
            [cut.settled(out[: drive.shape[1], :, i + count * k].T) for k in range(len(values))]
            for i, drive in enumerate(drives)
        ]

    def between(self, drive: np.ndarray) -> np.ndarray:
        """Return a drive (rows, N) whose acceleration does not droop between samples, where it runs straight."""
        rows = slice(1 + 3 * self.cut.n, 1 + 4 * self.cut.n)
        out = drive.copy()
        out[rows] = emphasised(drive[rows].T).T
        return out
