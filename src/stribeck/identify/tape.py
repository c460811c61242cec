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

LANES = 64  # as in tape.h


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
        self._once = Program(operations, [i for i, flag in enumerate(constant) if flag], needed, {})
        known = {number: (function.n_in(), k) for k, number in enumerate(needed)}
        self._each = Program(operations, [i for i, flag in enumerate(constant) if not flag], results, known)

    def map(self, inputs: Sequence[Floats]) -> Floats:
        """Return outputs (rows, N) at N samples.

        Parameters
        ----------
        inputs : sequence of array
            (rows,) where fixed, else (rows, N).
        """
        inputs = [np.ascontiguousarray(values, dtype=float) for values in inputs]
        samples = next(values.shape[1] for i, values in enumerate(inputs) if i not in self.fixed)
        known = known_values(self._once, [v if i in self.fixed else v[:, :1] for i, v in enumerate(inputs)])
        arguments = [argument(v, samples, repeated=i in self.fixed) for i, v in enumerate(inputs)]
        out = np.empty((self.rows_out, samples))
        call = self._each.call([*arguments, argument(known, samples, repeated=True)], out)
        library().tape_map(*call, ctypes.c_longlong(samples), work(self._each.slots))
        return out


def known_values(once: Program, inputs: Sequence[Floats]) -> Floats:
    """Return the values (K, 1) of a program that are the same for all samples."""
    arguments = [argument(values, 1) for values in inputs]
    out = np.zeros((max(1, once.outputs), 1))
    library().tape_map(*once.call(arguments, out), ctypes.c_longlong(1), work(once.slots))
    return out


def argument(values: Floats, samples: int, *, repeated: bool = False) -> Argument:
    """Return where the machine finds values: rows of one number a sample, or of one that is ``repeated`` for all."""
    return Argument(values.ctypes.data, 1 if repeated else samples, 0 if repeated else 1)


def work(slots: int) -> ctypes.Array[ctypes.c_double]:
    """Return room for a program's working values."""
    return (ctypes.c_double * (LANES * max(1, slots)))()


@cache
def library() -> ctypes.CDLL:
    """Return the compiled machine."""
    export = "#ifdef _WIN32\n#define TAPE_EXPORT __declspec(dllexport)\n#else\n#define TAPE_EXPORT\n#endif\n"
    return load(build(export + (files("stribeck.identify") / "c" / "tape.h").read_text(encoding="utf-8"), level="-O3"))
