"""A CasADi function as a list of operations that the vector machine has, and which of them every sample shares."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import casadi as ca

from stribeck.errors import StribeckError

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
ADD, SUB, MUL = (_KIND[getattr(ca, f"OP_{name}")] for name in ("ADD", "SUB", "MUL"))
FUSED = {
    (kind, side): 3 + len(OPERATIONS) + k for kind, side, k in ((ADD, 0, 0), (ADD, 1, 0), (SUB, 0, 1), (SUB, 1, 2))
}
"""Kinds of a sum or difference by which of its two is a product: x y + z, x y + z, x y - z, z - x y."""
KINDS = tuple(f"load const store {' '.join(OPERATIONS)} mul_add mul_sub sub_mul".lower().split())
"""Names of all kinds in their order, the fused ones last."""
_EITHER_WAY = frozenset(_KIND[getattr(ca, f"OP_{name}")] for name in ("ADD", "MUL"))


class Operation(NamedTuple):
    """One operation with every result a number of its own: ``a``, ``b`` are results, or where LOAD reads.

    Of a constant, ``a`` tells whether it is negative.
    """

    kind: int
    a: int
    b: int
    value: float = 0.0


def numbered(function: ca.Function) -> tuple[list[Operation], list[int]]:
    """Return a function's operations, each with a result of its own number, and the numbers of the outputs.

    What is the same twice has one number (value numbering, Cocke & Schwartz 1970).
    """
    operations: list[Operation] = []
    number: dict[tuple[int, int, int, float], int] = {}
    holds: dict[int, int] = {}
    results = [-1] * function.numel_out(0)

    def number_of(kind: int, a: int, b: int, value: float = 0.0) -> int:
        key = kind, a, b, value  # to make an operation of it takes longer than to look it up
        if key not in number:
            number[key] = len(operations)
            operations.append(Operation(kind, a, b, value))
        return number[key]

    for k in range(function.n_instructions()):
        op, target, source = function.instruction_id(k), function.instruction_output(k), function.instruction_input(k)
        if op in _KIND:
            kind, first = _KIND[op], holds[source[0]]
            second = holds[source[1]] if kind in _PAIRS else first
            if first > second and kind in _EITHER_WAY:
                first, second = second, first
            holds[target[0]] = number_of(kind, first, second)
        elif op == ca.OP_OUTPUT:
            results[target[1]] = holds[source[0]]
        elif op == ca.OP_INPUT:
            holds[target[0]] = number_of(LOAD, source[0], source[1])
        elif op == ca.OP_CONST:
            holds[target[0]] = number_of(*_constant(function.instruction_constant(k)))
        else:
            raise StribeckError("an operation that the vector machine has not", f"CasADi operation {op}")
    if -1 in results:  # an output that nothing sets is zero
        zero = number_of(*_constant(0.0))
        results = [zero if number < 0 else number for number in results]
    return operations, results


def _constant(value: float) -> Operation:
    """Return a constant; zeros of either sign are two."""
    return Operation(CONST, int(math.copysign(1.0, value) < 0.0), 0, value)


def constant_results(operations: Sequence[Operation], same: Mapping[int, Collection[int]]) -> list[bool]:
    """Tell which results depend on some rows of the inputs alone."""
    flags: list[bool] = []
    for o in operations:
        if o.kind == LOAD:
            flags.append(o.b in same.get(o.a, ()))
        else:
            flags.append(o.kind == CONST or (flags[o.a] and flags[o.b]))
    return flags


def crossing(operations: Sequence[Operation], results: Sequence[int], constant: Sequence[bool]) -> list[int]:
    """Return the constant results that varying ones, or outputs, use."""
    used = {i for i in results if constant[i]}
    for o, flag in zip(operations, constant, strict=True):
        if not flag and o.kind != LOAD:
            used |= {i for i in (o.a, o.b) if constant[i]}
    return sorted(used)
