"""A CasADi function as a list of operations that the vector machine has, and which of them every sample shares."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

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


@dataclass(frozen=True)
class Operation:
    """One operation with every result a number of its own: ``a``, ``b`` are results, or where LOAD reads."""

    kind: int
    a: int
    b: int
    value: float = 0.0


def numbered(function: ca.Function) -> tuple[list[Operation], list[int]]:
    """Return a function's operations, each with a result of its own number, and the numbers of the outputs."""
    operations: list[Operation] = []
    holds: dict[int, int] = {}
    results = [-1] * function.numel_out(0)
    for k in range(function.n_instructions()):
        op, target, source = function.instruction_id(k), function.instruction_output(k), function.instruction_input(k)
        if op == ca.OP_OUTPUT:
            results[target[1]] = holds[source[0]]
            continue
        if op == ca.OP_INPUT:
            operation = Operation(LOAD, source[0], source[1])
        elif op == ca.OP_CONST:
            operation = Operation(CONST, 0, 0, function.instruction_constant(k))
        elif op in _KIND:
            numbers = [holds[i] for i in source]
            operation = Operation(_KIND[op], numbers[0], numbers[1] if _KIND[op] in _PAIRS else numbers[0])
        else:
            raise StribeckError("an operation that the vector machine has not", f"CasADi operation {op}")
        holds[target[0]] = len(operations)
        operations.append(operation)
    if -1 in results:  # an output that nothing sets is zero
        operations.append(Operation(CONST, 0, 0, 0.0))
        results = [len(operations) - 1 if number < 0 else number for number in results]
    return operations, results


def constant_results(operations: Sequence[Operation], fixed: Sequence[int]) -> list[bool]:
    """Tell which results are the same for all samples."""
    flags: list[bool] = []
    for o in operations:
        if o.kind == LOAD:
            flags.append(o.a in fixed)
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
