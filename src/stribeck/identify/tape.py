"""CasADi functions over many samples at once, by a small vector machine in C.

CasADi's own machine takes one sample at a time. A recorded motion has tens of thousands, and code generated for each
candidate would have to be compiled each time; this machine is compiled once per user and takes any function.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from stribeck.compiler import build, load
from stribeck.errors import StribeckError

Floats = NDArray[np.float64]
LANES, FEW = 64, 4  # as in tape.h
LOAD, CONST, STORE = 0, 1, 2
OPERATIONS = (  # noqa: SIM905
    "ADD SUB MUL DIV NEG INV SQ TWICE SQRT EXP LOG POW SIN COS TAN ASIN ACOS ATAN SINH COSH TANH ASINH ACOSH ATANH "
    "EXPM1 LOG1P ERF ATAN2 HYPOT FLOOR CEIL FMOD FABS SIGN COPYSIGN LT LE EQ NE NOT AND OR FMIN FMAX IF_ELSE_ZERO "
    "ASSIGN"
).split()
_KIND = {getattr(ca, f"OP_{name}"): 3 + place for place, name in enumerate(OPERATIONS)}
_KIND[ca.OP_CONSTPOW] = _KIND[ca.OP_POW]
PAIRED = "ADD SUB MUL DIV POW ATAN2 HYPOT FMOD COPYSIGN LT LE EQ NE AND OR FMIN FMAX IF_ELSE_ZERO".split()  # noqa: SIM905
_PAIRS = frozenset(_KIND[getattr(ca, f"OP_{name}")] for name in PAIRED)


@dataclass(frozen=True)
class _Operation:
    """One operation with every result a number of its own: ``a``, ``b`` are results, or where LOAD reads."""

    kind: int
    a: int
    b: int
    value: float = 0.0


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
        operations, results = _numbered(function)
        constant = _constant(operations, self.fixed)
        needed = _crossing(operations, results, constant)
        count = function.n_in()
        self._once = _Program(operations, [i for i, flag in enumerate(constant) if flag], needed, {}, count)
        place = {number: k for k, number in enumerate(needed)}
        self._each = _Program(operations, [i for i, flag in enumerate(constant) if not flag], results, place, count)

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

    def march(self, start: Floats, drive: Floats, *fixed: Floats) -> Floats:
        """Return the states (T, rows, R) of a recursion (states, drive now, drive after, fixed...) -> states.

        Parameters
        ----------
        start : array (rows, R)
            States at the first sample, R runs side by side.
        drive : array (T, d, R)
        fixed : array (rows,)
            The remaining inputs.
        """
        samples, rows, runs = drive.shape
        if runs > LANES:
            parts = [slice(lo, lo + LANES) for lo in range(0, runs, LANES)]
            return np.concatenate([self.march(start[:, p], drive[:, :, p], *fixed) for p in parts], axis=2)
        lanes = -(-runs // FEW) * FEW if runs > 1 else 1
        index = np.minimum(np.arange(lanes), runs - 1)
        drive = np.ascontiguousarray(drive[:, :, index], dtype=float)
        out = np.empty((samples, self.rows_out, lanes))
        out[0] = start[:, index]
        values = [np.ascontiguousarray(v, dtype=float) for v in fixed]
        known = self._known([out[0, :, :1], drive[0, :, :1], drive[0, :, :1], *values])
        moving = [_Argument(None, lanes, 1), _Argument(drive.ctypes.data, lanes, 1), _Argument(None, lanes, 1)]
        still = [_argument(v, 1, repeated=True) for v in (*values, known)]
        call = self._each.call([*moving, *still], out)
        sizes = [ctypes.c_longlong(size) for size in (samples - 1, self.rows_out, rows, lanes)]
        _library().tape_march(*call, *sizes, _work(self._each.slots))
        return out[:, :, :runs]


class _Argument(ctypes.Structure):
    _fields_ = (("base", ctypes.c_void_p), ("row", ctypes.c_longlong), ("column", ctypes.c_longlong))


def _argument(values: Floats, samples: int, *, repeated: bool = False) -> _Argument:
    return _Argument(values.ctypes.data, 1 if repeated else samples, 0 if repeated else 1)


def _work(slots: int) -> ctypes.Array[ctypes.c_double]:
    return (ctypes.c_double * (LANES * max(1, slots)))()


class _Program:
    """Machine code of some operations; results are given places that are used again once they are not needed."""

    def __init__(
        self, operations: Sequence[_Operation], chosen: Sequence[int], results: Sequence[int], known: dict[int, int],
        argument: int,
    ) -> None:  # fmt: skip
        lines: list[tuple[int, int, int, int]] = []  # kind, result, operands, all by number
        loaded: set[int] = set()
        constants: list[float] = []

        def load(number: int) -> None:
            if number in known and number not in loaded:
                loaded.add(number)
                lines.append((LOAD, number, argument, known[number]))

        for number in chosen:
            o = operations[number]
            if o.kind == CONST:
                constants.append(o.value)
                lines.append((CONST, number, len(constants) - 1, 0))
                continue
            if o.kind != LOAD:
                load(o.a)
                load(o.b)
            lines.append((o.kind, number, o.a, o.b))
        for place, number in enumerate(results):
            load(number)
            lines.append((STORE, place, number, number))
        self.outputs = len(results)
        self.code, self.slots = _placed(lines)
        self.constants = np.array([*constants, 0.0])

    def call(self, arguments: Sequence[_Argument], out: Floats) -> tuple[object, ...]:
        """Return the first five arguments of the machine's functions."""
        table = (_Argument * len(arguments))(*arguments)
        pointers = (self.code.ctypes.data, len(self.code), self.constants.ctypes.data)
        code, length, constants = pointers
        return (
            ctypes.c_void_p(code),
            ctypes.c_longlong(length),
            ctypes.c_void_p(constants),
            table,
            ctypes.c_void_p(out.ctypes.data),
        )


def _placed(lines: Sequence[tuple[int, int, int, int]]) -> tuple[NDArray[np.int32], int]:
    """Return the code (K, 4) with results in places, and the number of places."""
    last: dict[int, int] = {}
    for k, (kind, _, a, b) in enumerate(lines):
        if kind >= STORE:
            last[a] = last[b] = k
    free: list[int] = []
    at: dict[int, int] = {}
    count = 0
    code = np.zeros((len(lines), 4), dtype=np.int32)
    for k, (kind, target, a, b) in enumerate(lines):
        if kind >= STORE:
            places = at[a], at[b]
            free += [at.pop(number) for number in {a, b} if last[number] == k]
        else:
            places = a, b
        if kind == STORE:
            code[k] = (kind, target, *places)
            continue
        if not free:
            free.append(count)
            count += 1
        place = free.pop()
        code[k] = (kind, place, *places)
        if target in last:
            at[target] = place
        else:
            free.append(place)
    return code, count


def _numbered(function: ca.Function) -> tuple[list[_Operation], list[int]]:
    """Return a function's operations, each with a result of its own number, and the numbers of the outputs."""
    operations: list[_Operation] = []
    holds: dict[int, int] = {}
    results = [-1] * function.numel_out(0)
    for k in range(function.n_instructions()):
        op, target, source = function.instruction_id(k), function.instruction_output(k), function.instruction_input(k)
        if op == ca.OP_OUTPUT:
            results[target[1]] = holds[source[0]]
            continue
        if op == ca.OP_INPUT:
            operation = _Operation(LOAD, source[0], source[1])
        elif op == ca.OP_CONST:
            operation = _Operation(CONST, 0, 0, function.instruction_constant(k))
        elif op in _KIND:
            numbers = [holds[i] for i in source]
            operation = _Operation(_KIND[op], numbers[0], numbers[1] if _KIND[op] in _PAIRS else numbers[0])
        else:
            raise StribeckError("an operation that the vector machine has not", f"CasADi operation {op}")
        holds[target[0]] = len(operations)
        operations.append(operation)
    if -1 in results:  # an output that nothing sets is zero
        operations.append(_Operation(CONST, 0, 0, 0.0))
        results = [len(operations) - 1 if number < 0 else number for number in results]
    return operations, results


def _constant(operations: Sequence[_Operation], fixed: Sequence[int]) -> list[bool]:
    """Tell which results are the same for all samples."""
    flags: list[bool] = []
    for o in operations:
        if o.kind == LOAD:
            flags.append(o.a in fixed)
        else:
            flags.append(o.kind == CONST or (flags[o.a] and flags[o.b]))
    return flags


def _crossing(operations: Sequence[_Operation], results: Sequence[int], constant: Sequence[bool]) -> list[int]:
    """Return the constant results that varying ones, or outputs, use."""
    used = {i for i in results if constant[i]}
    for o, flag in zip(operations, constant, strict=True):
        if not flag and o.kind != LOAD:
            used |= {i for i in (o.a, o.b) if constant[i]}
    return sorted(used)


@cache
def _library() -> ctypes.CDLL:
    """Return the compiled machine."""
    export = "#ifdef _WIN32\n#define TAPE_EXPORT __declspec(dllexport)\n#else\n#define TAPE_EXPORT\n#endif\n"
    return load(build(export + (files("stribeck.identify") / "c" / "tape.h").read_text(encoding="utf-8"), level="-O3"))
