"""Machine code of the vector machine: operations in order, each with the places of its operands and its result."""

from __future__ import annotations

import ctypes
from collections import Counter, defaultdict, deque
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stribeck.identify.operations import CONST, FUSED, LOAD, MUL, STORE, Operation

Floats = NDArray[np.float64]


class Argument(ctypes.Structure):
    """Where the machine finds an input: its address, and the steps from row to row and from sample to sample.

    Of a recursion, the lanes after which its columns begin anew; 0 where they do not.
    """

    _fields_ = (
        ("base", ctypes.c_void_p), ("row", ctypes.c_longlong), ("column", ctypes.c_longlong),
        ("period", ctypes.c_longlong),
    )  # fmt: skip


class Line(NamedTuple):
    """An operation, its result and its operands, all by number; of LOAD and CONST, where they read."""

    kind: int
    target: int
    operands: tuple[int, ...]


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
    grouped : bool
        Whether operations of a kind come one after the other, as far as their operands allow.

    Attributes
    ----------
    code : array (K, 5) of int32
        Kind, place of the result, places of up to three operands.
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
        *,
        grouped: bool = False,
    ) -> None:
        lines: list[Line] = []
        loaded: set[int] = set()
        constants: list[float] = []

        def load(number: int) -> None:
            if number in known and number not in loaded:
                loaded.add(number)
                lines.append(Line(LOAD, number, known[number]))

        for number in chosen:
            o = operations[number]
            if o.kind == CONST:
                constants.append(o.value)
                lines.append(Line(CONST, number, (len(constants) - 1, 0)))
                continue
            if o.kind != LOAD:
                load(o.a)
                load(o.b)
            lines.append(Line(o.kind, number, (o.a, o.b)))
        for place, number in enumerate(results):
            load(number)
            lines.append(Line(STORE, place, (number, number)))
        self.outputs = len(results)
        lines = _fused(lines)
        self.code, self.slots = _placed(_grouped(lines) if grouped else lines)
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


def _fused(lines: Sequence[Line]) -> list[Line]:
    """Return the lines with products that a single sum or difference takes made part of that."""
    uses = Counter(number for line in lines if line.kind >= STORE for number in set(line.operands))
    products = {line.target: line for line in lines if line.kind == MUL and uses[line.target] == 1}
    out: list[Line] = []
    gone: set[int] = set()
    for line in lines:
        for side in (0, 1):
            product = products.get(line.operands[side]) if (line.kind, side) in FUSED else None
            if product is not None and line.operands[0] != line.operands[1]:
                gone.add(product.target)
                line = Line(FUSED[line.kind, side], line.target, (*product.operands, line.operands[1 - side]))
                break
        out.append(line)
    return [line for line in out if line.kind != MUL or line.target not in gone]


def _grouped(lines: Sequence[Line]) -> list[Line]:
    """Return the lines with those of a kind one after the other, as far as each has its operands by then.

    Over a few samples, what an operation costs is that the processor cannot foresee which is next.
    """
    producer = {line.target: k for k, line in enumerate(lines) if line.kind != STORE}
    waits = [len(set(line.operands)) if line.kind >= STORE else 0 for line in lines]
    takers: list[list[int]] = [[] for _ in lines]
    for k, line in enumerate(lines):
        if line.kind >= STORE:
            for number in set(line.operands):
                takers[producer[number]].append(k)
    ready: defaultdict[int, deque[int]] = defaultdict(deque)
    for k, count in enumerate(waits):
        if count == 0:
            ready[lines[k].kind].append(k)
    out: list[Line] = []
    while ready:
        kind = max(ready, key=lambda kind: len(ready[kind]))
        mine = ready[kind]
        while mine:
            k = mine.popleft()
            out.append(lines[k])
            for taker in takers[k]:
                waits[taker] -= 1
                if waits[taker] == 0:
                    ready[lines[taker].kind].append(taker)
        del ready[kind]
    return out


def _placed(lines: Sequence[Line]) -> tuple[NDArray[np.int32], int]:
    """Return the code (K, 5) with results in places, and the number of places."""
    last: dict[int, int] = {}
    for k, line in enumerate(lines):
        if line.kind >= STORE:
            last |= dict.fromkeys(line.operands, k)
    free: list[int] = []
    at: dict[int, int] = {}
    count = 0
    code = np.zeros((len(lines), 5), dtype=np.int32)
    for k, (kind, target, operands) in enumerate(lines):
        if kind >= STORE:
            places = [at[number] for number in operands]
            free += [at.pop(number) for number in set(operands) if last[number] == k]
        else:
            places = list(operands)
        code[k, 0], code[k, 2 : 2 + len(places)] = kind, places
        if kind == STORE:
            code[k, 1] = target
            continue
        if not free:
            free.append(count)
            count += 1
        place = free.pop()
        code[k, 1] = place
        if target in last:
            at[target] = place
        else:
            free.append(place)
    return code, count
