"""A recursion over recorded samples, several runs or parameter values side by side, on the vector machine.

What a step needs that no state changes is computed ahead, for many samples at once; only the rest has to wait for the
step before.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence

import casadi as ca
import numpy as np

from stribeck.identify.operations import constant_results, crossing, numbered
from stribeck.identify.program import Argument, Floats, Program
from stribeck.identify.tape import LANES, argument, known_values, library, work

FEW = 4  # as in tape.h
BLOCK = 512  # steps whose drive is worked out ahead: what it gives stays in the cache
STATES, NOW, AFTER = 0, 1, 2  # inputs


class Recursion:
    """A CasADi SX function (states, drive now, drive after, others...) -> states as programs of the vector machine.

    Parameters
    ----------
    function : casadi.Function
        Of dense inputs and one dense output.
    fixed : sequence of int
        Inputs that are the same at all times and on all lanes: what depends on them alone is computed once.
    """

    def __init__(self, function: ca.Function, fixed: Sequence[int]) -> None:
        self.rows = function.numel_out(0)
        operations, results = numbered(function)
        rows = [range(function.numel_in(i)) for i in range(function.n_in())]
        constant, early = (
            constant_results(operations, {i: rows[i] for i in same}) for same in (fixed, (*fixed, NOW, AFTER))
        )
        needed = crossing(operations, results, constant)
        driven = [i for i in crossing(operations, results, early) if not constant[i]]
        count = function.n_in()
        known = {number: (count, k) for k, number in enumerate(needed)}
        told = {number: (count + 1, k) for k, number in enumerate(driven)}
        ahead = [i for i, flag in enumerate(early) if flag and not constant[i]]
        self._once = Program(operations, [i for i, flag in enumerate(constant) if flag], needed, {})
        self._ahead = Program(operations, ahead, driven, known)
        self._each = Program(
            operations, [i for i, flag in enumerate(early) if not flag], results, known | told, grouped=True
        )

    def march(self, start: Floats, drive: Floats, *others: Floats) -> Floats:
        """Return the states (T, rows, R).

        Parameters
        ----------
        start : array (rows, R)
            States at the first sample, R lanes side by side.
        drive : array (d, T, D)
            Of the first D lanes, of the next D, and so on: a D that divides R.
        *others : array
            The remaining inputs, the same at all samples: (rows,) where fixed, else (rows, R).
        """
        (_, samples, drives), runs = drive.shape, start.shape[1]
        if runs > LANES:
            wide = LANES // drives * drives or LANES
            parts = []
            for lo in range(0, runs, wide):
                here = slice(lo, lo + wide)
                own = (v if v.ndim == 1 else v[:, here] for v in others)
                mine = drive[:, :, np.arange(runs)[here] % drives] if drives > LANES else drive
                parts.append(self.march(start[:, here], mine, *own))
            return np.concatenate(parts, axis=2)
        lanes = -(-runs // FEW) * FEW if runs > 1 else 1
        index = np.minimum(np.arange(lanes), runs - 1)
        drive = np.ascontiguousarray(drive, dtype=float)
        out = np.empty((samples, self.rows, lanes))
        out[0] = start[:, index]
        values = [np.ascontiguousarray(v if v.ndim == 1 else v[:, index], dtype=float) for v in others]
        firsts = [out[0], drive[:, 0], drive[:, 0], *(v.reshape(len(v), -1) for v in values)]
        known = known_values(self._once, [np.ascontiguousarray(first[:, :1]) for first in firsts])
        still = [argument(v, lanes, repeated=v.ndim == 1) for v in values]
        for lo in range(0, samples - 1, BLOCK):
            self._block(out[lo : lo + BLOCK + 1], drive[:, lo : lo + BLOCK + 1], still, known)
        return out[:, :, :runs]

    def _block(self, out: Floats, drive: Floats, still: Sequence[Argument], known: Floats) -> None:
        """Fill in the states (B + 1, rows, lanes) after the first of them, under a drive (d, B + 1, columns)."""
        steps, columns, lanes = len(out) - 1, drive.shape[2], out.shape[2]
        count, row, once = steps * columns, drive.strides[0] // drive.itemsize, argument(known, 1, repeated=True)
        now, after = (Argument(drive.ctypes.data + later * columns * drive.itemsize, row, 1, 0) for later in (0, 1))
        told = np.empty((max(1, self._ahead.outputs), count))
        nothing = Argument(None, 0, 0, 0)
        call = self._ahead.call([nothing, now, after, *still, once], told)
        library().tape_map(*call, ctypes.c_longlong(count), work(self._ahead.slots))
        pushed = Argument(told.ctypes.data, count, 1, 0 if columns == lanes else columns)
        call = self._each.call([nothing, nothing, nothing, *still, once, pushed], out)
        sizes = [ctypes.c_longlong(size) for size in (steps, self.rows, 4 + len(still), columns, lanes)]
        library().tape_march(*call, *sizes, work(self._each.slots))
