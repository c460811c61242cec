"""Machine code of the vector machine: operations in order, each with the places of its operands and its result."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from stribeck.identify.operations import CONST, LOAD, STORE, Operation

Floats = NDArray[np.float64]


class Argument(ctypes.Structure):
    """Where the machine finds an input: its address, and the steps from row to row and from sample to sample."""

    _fields_ = (("base", ctypes.c_void_p), ("row", ctypes.c_longlong), ("column", ctypes.c_longlong))


class Program:
    """Machine code of some operations; results are given places that are used again once they are not needed.

    Parameters
    ----------
    operations : sequence of Operation
    chosen : sequence of int
        Operations to carry out, in order.
    results : sequence of int
        Operations whose results are the outputs.
    known : dict of int to (int, int)
        Results that are given: the number of the input that gives each, and the row there.

    Attributes
    ----------
    code : array (K, 4) of int32
        Kind, place of the result, places of the operands.
    slots, outputs : int
        Places that the code needs, and results that it stores.
    constants : array
    """

    def __init__(
        self,
        operations: Sequence[Operation],
        chosen: Sequence[int],
        results: Sequence[int],
        known: Mapping[int, tuple[int, int]],
    ) -> None:
        lines: list[tuple[int, int, int, int]] = []  # kind, result, operands, all by number
        loaded: set[int] = set()
        constants: list[float] = []

        def load(number: int) -> None:
            if number in known and number not in loaded:
                loaded.add(number)
                lines.append((LOAD, number, *known[number]))

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

    def call(self, arguments: Sequence[Argument], out: Floats) -> tuple[object, ...]:
        """Return the first five arguments of the machine's functions."""
        table = (Argument * len(arguments))(*arguments)
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
