"""CasADi functions over many samples at once, by a small vector machine in C.

CasADi's own machine takes one sample at a time. A recorded motion has tens of thousands, and code generated for each
candidate would have to be compiled each time; this machine is compiled once per user and takes any function.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from functools import cache
from importlib.resources import files

import casadi as ca
import numpy as np

from stribeck.compiler import build, load
from stribeck.identify.operations import constant_results, crossing, numbered
from stribeck.identify.program import Argument, Floats, Program

LANES, FEW = 64, 4  # as in tape.h


class Tape:
    """A CasADi SX function of one output as a program of the vector machine.

    Parameters
    ----------
    function : casadi.Function
        Of dense inputs and one dense output.
    fixed : sequence of int
        Inputs that are the same for all samples: what depends on them alone is computed once.
    """

    def __init__(self, function: ca.Function, fixed: Sequence[int]) -> None:
        self.fixed = tuple(fixed)
        self.rows_in = tuple(function.numel_in(i) for i in range(function.n_in()))
        self.rows_out = function.numel_out(0)
        operations, results = numbered(function)
        constant = constant_results(operations, self.fixed)
        needed = crossing(operations, results, constant)
        count = function.n_in()
        self._once = Program(operations, [i for i, flag in enumerate(constant) if flag], needed, {}, count)
        place = {number: k for k, number in enumerate(needed)}
        self._each = Program(operations, [i for i, flag in enumerate(constant) if not flag], results, place, count)

    def _known(self, inputs: Sequence[Floats]) -> Floats:
        """Return the values that are the same for all samples."""
        arguments = [_argument(values, 1) for values in inputs]
        out = np.zeros((max(1, self._once.outputs), 1))
        _library().tape_map(*self._once.call(arguments, out), ctypes.c_longlong(1), _work(self._once.slots))
        return out

    def map(self, inputs: Sequence[Floats]) -> Floats:
        """Return outputs (rows, N) at N samples.

        Parameters
        ----------
        inputs : sequence of array
            (rows,) where fixed, else (rows, N).
        """
        inputs = [np.ascontiguousarray(values, dtype=float) for values in inputs]
        samples = next(values.shape[1] for i, values in enumerate(inputs) if i not in self.fixed)
        known = self._known([v if i in self.fixed else v[:, :1] for i, v in enumerate(inputs)])
        arguments = [_argument(v, samples, repeated=i in self.fixed) for i, v in enumerate(inputs)]
        out = np.empty((self.rows_out, samples))
        call = self._each.call([*arguments, _argument(known, samples, repeated=True)], out)
        _library().tape_map(*call, ctypes.c_longlong(samples), _work(self._each.slots))
        return out

    def march(self, start: Floats, drive: Floats, *others: Floats) -> Floats:
        """Return the states (T, rows, R) of a recursion (states, drive now, drive after, others...) -> states.

        Parameters
        ----------
        start : array (rows, R)
            States at the first sample, R runs side by side.
        drive : array (T, d, R) or (T, d, 1)
            Each run's own, or that of all.
        others : array
            The remaining inputs, the same at all samples: (rows,) where fixed, else (rows, R).
        """
        (samples, rows, drives), runs = drive.shape, start.shape[1]
        if runs > LANES:
            parts = []
            for lo in range(0, runs, LANES):
                here = slice(lo, lo + LANES)
                own = (v if v.ndim == 1 else v[:, here] for v in others)
                parts.append(self.march(start[:, here], drive[:, :, here] if drives > 1 else drive, *own))
            return np.concatenate(parts, axis=2)
        lanes = -(-runs // FEW) * FEW if runs > 1 else 1
        index = np.minimum(np.arange(lanes), runs - 1)
        drive = np.ascontiguousarray(drive[:, :, index] if drives > 1 else drive, dtype=float)
        out = np.empty((samples, self.rows_out, lanes))
        out[0] = start[:, index]
        values = [np.ascontiguousarray(v if v.ndim == 1 else v[:, index], dtype=float) for v in others]
        firsts = [out[0], drive[0], drive[0], *(v.reshape(len(v), -1) for v in values)]
        known = self._known([first[:, :1] for first in firsts])
        shared = drive.shape[2] == 1
        pushed = Argument(drive.ctypes.data, drive.shape[2], 0 if shared else 1)
        moving = [Argument(None, lanes, 1), pushed, Argument(None, pushed.row, pushed.column)]
        still = [_argument(v, lanes, repeated=v.ndim == 1) for v in values]
        call = self._each.call([*moving, *still, _argument(known, 1, repeated=True)], out)
        sizes = [ctypes.c_longlong(size) for size in (samples - 1, self.rows_out, rows * drive.shape[2], lanes)]
        _library().tape_march(*call, *sizes, _work(self._each.slots))
        return out[:, :, :runs]


def _argument(values: Floats, samples: int, *, repeated: bool = False) -> Argument:
    return Argument(values.ctypes.data, 1 if repeated else samples, 0 if repeated else 1)


def _work(slots: int) -> ctypes.Array[ctypes.c_double]:
    return (ctypes.c_double * (LANES * max(1, slots)))()


@cache
def _library() -> ctypes.CDLL:
    """Return the compiled machine."""
    export = "#ifdef _WIN32\n#define TAPE_EXPORT __declspec(dllexport)\n#else\n#define TAPE_EXPORT\n#endif\n"
    return load(build(export + (files("stribeck.identify") / "c" / "tape.h").read_text(encoding="utf-8"), level="-O3"))
