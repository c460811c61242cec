"""CasADi functions over many samples at once, by a small vector machine in C.

CasADi's own machine takes one sample at a time. A recorded motion has tens of thousands, and code generated for each
candidate would have to be compiled each time; this machine is compiled once per user and takes any function.
"""

from __future__ import annotations

import ctypes
from collections.abc import Collection, Mapping, Sequence
from functools import cache
from importlib.resources import files
from types import MappingProxyType

import casadi as ca
import numpy as np

from stribeck.compiler import build, load
from stribeck.identify.operations import CONST, KINDS, LOAD, constant_results, crossing, numbered
from stribeck.identify.program import Argument, Floats, Program
from stribeck.mirrored import check_names, check_structure

LANES = 64  # as in tape.h


class Tape:
    """A CasADi SX function of one output as a program of the vector machine.

    Parameters
    ----------
    function : casadi.Function
        Of dense inputs and one dense output.
    fixed : sequence of int
        Inputs that are the same for all samples: what depends on them alone is computed once.
    steady : mapping of int to collection of int
        Rows of inputs that stay as they are from call to call: what depends on them alone can be kept.
    """

    def __init__(
        self, function: ca.Function, fixed: Sequence[int], steady: Mapping[int, Collection[int]] = MappingProxyType({})
    ) -> None:
        self.fixed = tuple(fixed)
        operations, results = numbered(function)
        self._zero = np.array([operations[i].kind == CONST and operations[i].value == 0.0 for i in results], dtype=bool)
        results = [number for number, zero in zip(results, self._zero, strict=True) if not zero]
        everything = {i: range(function.numel_in(i)) for i in self.fixed}
        constant, still = constant_results(operations, everything), constant_results(operations, steady)
        needed = crossing(operations, results, constant)
        across = [i for i in crossing(operations, results, still) if not constant[i]]
        read = {i for i in across if operations[i].kind == LOAD}  # from the recording itself
        kept = [i for i in across if i not in read]
        known = {number: (function.n_in(), k) for k, number in enumerate(needed)}
        told = {number: (function.n_in() + 1, k) for k, number in enumerate(kept)}
        changing = [i for i, flag in enumerate(constant) if not flag]
        self._once = Program(operations, [i for i, flag in enumerate(constant) if flag], needed, {})
        self._last: tuple[bytes, Floats] = b"", np.empty(0)
        self._still = Program(operations, [i for i in changing if still[i]], kept, known)
        self._each = Program(operations, [i for i in changing if not still[i] or i in read], results, known | told)

    def map(self, inputs: Sequence[Floats], kept: Floats | None = None) -> Floats:
        """Return the outputs (K, N) that are not always zero, at N samples.

        Parameters
        ----------
        inputs : sequence of array
            (rows,) where fixed, else (rows, N).
        kept : array or None
            What :meth:`keep` returned for the same steady rows.
        """
        kept = self.keep(inputs) if kept is None else kept
        return self._run(self._each, inputs, kept)

    def keep(self, inputs: Sequence[Floats]) -> Floats:
        """Return what depends on steady rows alone, at N samples; inputs as of :meth:`map`."""
        return self._run(self._still, inputs)

    def _known(self, inputs: Sequence[Floats]) -> Floats:
        """Return what depends on fixed inputs alone: most calls, along one run after the other, have the same."""
        by = b"".join(inputs[i].tobytes() for i in self.fixed)
        same, known = self._last  # by a name of its own: another thread may ask with other values
        if not known.size or same != by:
            firsts = [v if i in self.fixed else v[:, :1] for i, v in enumerate(inputs)]
            known = known_values(self._once, firsts)
            self._last = by, known
        return known

    def whole(self, values: Floats) -> Floats:
        """Return all outputs (M, rows) of those (M, K) that are not always zero."""
        out = np.zeros((len(values), len(self._zero)))
        out[:, ~self._zero] = values
        return out

    def _run(self, program: Program, inputs: Sequence[Floats], *kept: Floats) -> Floats:
        inputs = [np.ascontiguousarray(values, dtype=float) for values in inputs]
        samples = next(values.shape[1] for i, values in enumerate(inputs) if i not in self.fixed)
        out = np.empty((program.outputs, samples))
        if not program.outputs:
            return out
        known = self._known(inputs)
        arguments = [argument(v, samples, repeated=i in self.fixed) for i, v in enumerate(inputs)]
        arguments += [argument(known, samples, repeated=True), *(argument(v, samples) for v in kept)]
        library().tape_map(*program.call(arguments, out), ctypes.c_longlong(samples), work(program.slots))
        return out


def known_values(once: Program, inputs: Sequence[Floats]) -> Floats:
    """Return the values (K, 1) of a program that are the same for all samples."""
    arguments = [argument(values, 1) for values in inputs]
    out = np.zeros((max(1, once.outputs), 1))
    library().tape_map(*once.call(arguments, out), ctypes.c_longlong(1), work(once.slots))
    return out


def argument(values: Floats, samples: int, *, repeated: bool = False) -> Argument:
    """Return where the machine finds values: rows of one number a sample, or of one that is ``repeated`` for all."""
    return Argument(values.ctypes.data, 1 if repeated else samples, 0 if repeated else 1, 0)


def work(slots: int) -> ctypes.Array[ctypes.c_double]:
    """Return room for a program's working values."""
    return (ctypes.c_double * (LANES * max(1, slots)))()


@cache
def library() -> ctypes.CDLL:
    """Return the compiled machine."""
    export = "#ifdef _WIN32\n#define TAPE_EXPORT __declspec(dllexport)\n#else\n#define TAPE_EXPORT\n#endif\n"
    text = (files("stribeck.identify") / "c" / "tape.h").read_text(encoding="utf-8")
    found = load(build(export + text, level="-O3"))
    check_structure(found, "argument", Argument)
    check_names(found, "kinds", KINDS)
    return found
