"""The vector machine against CasADi's own."""

import casadi as ca
import numpy as np
import pytest

from stribeck.errors import StribeckError
from stribeck.identify import recursion
from stribeck.identify.operations import OPERATIONS, STORE, numbered
from stribeck.identify.recursion import FEW, Recursion
from stribeck.identify.tape import LANES, Tape

UNARY = {
    "NEG": lambda x: -x, "INV": lambda x: 1 / x, "SQ": lambda x: x**2, "TWICE": lambda x: 2 * x, "SQRT": ca.sqrt,
    "EXP": ca.exp, "LOG": ca.log, "SIN": ca.sin, "COS": ca.cos, "TAN": ca.tan, "ASIN": lambda x: ca.asin(x / 9),
    "ACOS": lambda x: ca.acos(x / 9), "ATAN": ca.atan, "SINH": ca.sinh, "COSH": ca.cosh, "TANH": ca.tanh,
    "ASINH": ca.asinh, "ACOSH": lambda x: ca.acosh(x + 1), "ATANH": lambda x: ca.atanh(x / 9), "EXPM1": ca.expm1,
    "LOG1P": ca.log1p, "ERF": ca.erf, "FLOOR": ca.floor, "CEIL": ca.ceil, "FABS": lambda x: ca.fabs(x - 2),
    "SIGN": lambda x: ca.sign(x - 2), "NOT": lambda x: ca.logic_not(x > 2),
}  # fmt: skip
BINARY = {
    "ADD": lambda x, y: x + y, "SUB": lambda x, y: x - y, "MUL": lambda x, y: x * y, "DIV": lambda x, y: x / y,
    "POW": lambda x, y: x**y, "ATAN2": ca.atan2, "HYPOT": ca.hypot, "FMOD": ca.fmod,
    "COPYSIGN": lambda x, y: ca.copysign(x, y - 2), "LT": lambda x, y: x < y, "LE": lambda x, y: x <= y,
    "EQ": lambda x, y: ca.floor(x) == ca.floor(y), "NE": lambda x, y: ca.floor(x) != ca.floor(y),
    "AND": lambda x, y: ca.logic_and(x > 2, y > 2), "OR": lambda x, y: ca.logic_or(x > 3, y > 3), "FMIN": ca.fmin,
    "FMAX": ca.fmax, "IF_ELSE_ZERO": lambda x, y: ca.if_else(x > 2, y, 0),
}  # fmt: skip


def test_every_operation_is_tried() -> None:
    assert set(OPERATIONS) == {*UNARY, *BINARY, "ASSIGN"}


@pytest.mark.parametrize("name", [*UNARY, *BINARY])
@pytest.mark.parametrize("samples", [1, LANES - 1, 2 * LANES + 5])
def test_operation(name: str, samples: int) -> None:
    x, y, p = ca.SX.sym("x", 2), ca.SX.sym("y"), ca.SX.sym("p")
    law = (lambda u: UNARY[name](u) + p * y) if name in UNARY else (lambda u: BINARY[name](u, y) * p)
    function = ca.Function("f", [x, y, p], [ca.densify(ca.vertcat(law(x[0]), law(x[1]), law(p)))])
    rng = np.random.default_rng(0)
    values = [rng.uniform(0.2, 5.0, (2, samples)), rng.uniform(0.2, 5.0, (1, samples)), np.array([1.7])]
    np.testing.assert_allclose(Tape(function, fixed=(2,)).map(values), function(*values).full(), rtol=1e-14, atol=1e-15)


@pytest.mark.parametrize("samples", [1, LANES])  # one at a time, and side by side
def test_sines_are_right_to_the_last_place(samples: int) -> None:
    """Where one is all but zero, where x is far, and where it is no number."""
    x = ca.SX.sym("x")
    tape = Tape(ca.Function("f", [x], [ca.vertcat(ca.sin(x), ca.cos(x))]), fixed=())
    rng = np.random.default_rng(4)
    sizes = (1e-9, 1e-3, 1.0, 60.0, 1e3, 9.9e4)
    quarters = np.pi / 2 * np.unique(rng.integers(-63_000, 63_000, 500))
    values = np.concatenate([*(size * rng.uniform(-1.0, 1.0, 200) for size in sizes), quarters, [0.0, 5e-324]])
    values = np.resize(values, (len(values) // samples + 1, samples))
    found = np.concatenate([tape.map([row[None]]) for row in values], axis=1)
    for own, exact in zip(found, (np.sin, np.cos), strict=True):
        true = exact(values.ravel().astype(np.longdouble))
        assert np.max(np.abs(own - true) / np.spacing(np.abs(true.astype(float)))) < 0.9
    with np.errstate(invalid="ignore"):
        far = np.array([[1.0001e5, -3e9, 1e300, np.inf, np.nan]])
        np.testing.assert_allclose(tape.map([far]), [np.sin(far[0]), np.cos(far[0])], rtol=1e-15)


@pytest.mark.parametrize("runs", [1, FEW, FEW + 1, LANES + 3])
def test_recursion(runs: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """However many steps are worked out ahead."""
    monkeypatch.setattr(recursion, "BLOCK", 7)
    steps = 20
    x, now, after, p = ca.SX.sym("x", 2), ca.SX.sym("now", 3), ca.SX.sym("after", 3), ca.SX.sym("p", 2)
    moved = ca.vertcat(p[0] * x[0] + ca.sin(now[0]) + 3 * p[1], 0.5 * x[1] + after[2] * x[0] + ca.sqrt(p[1]))
    function = ca.Function("f", [x, now, after, p], [moved])
    rng = np.random.default_rng(1)
    start, drive, values = rng.normal(size=(2, runs)), rng.normal(size=(3, steps, runs)), np.array([0.3, 0.7])
    out = Recursion(function, fixed=(3,)).march(start, drive, values)
    for run in range(runs):
        state = start[:, run]
        for k in range(19):
            state = function(state, drive[:, k, run], drive[:, k + 1, run], values).full().ravel()
            np.testing.assert_allclose(out[k + 1, :, run], state, rtol=1e-13)


@pytest.mark.parametrize(("drives", "count"), [(1, LANES + 3), (3, 2), (5, LANES // 3), (LANES + 2, 2)])
def test_few_drives_of_many_values(drives: int, count: int) -> None:
    """What is not fixed may differ from lane to lane; the drives are those of every so many lanes."""
    x, now, after, p, q = ca.SX.sym("x"), ca.SX.sym("now", 2), ca.SX.sym("after", 2), ca.SX.sym("p", 2), ca.SX.sym("q")
    function = ca.Function("f", [x, now, after, p, q], [ca.cos(q) * p[0] * x + ca.sin(now[1]) * p[1] + after[0]])
    rng = np.random.default_rng(2)
    lanes = drives * count
    start, drive = rng.normal(size=(1, lanes)), rng.normal(size=(2, 20, drives))
    values, fixed = rng.uniform(0.1, 0.9, (2, lanes)), np.array([0.4])
    tape = Recursion(function, fixed=(4,))
    out = tape.march(start, drive, values, fixed)
    for run in range(lanes):
        own = drive[:, :, [run % drives]]
        alone = tape.march(start[:, [run]], own, values[:, [run]], fixed)
        state = start[:, run]
        for k in range(19):
            state = function(state, own[:, k, 0], own[:, k + 1, 0], values[:, run], fixed).full().ravel()
        np.testing.assert_allclose([out[-1, :, run], alone[-1, :, 0]], [state, state], rtol=1e-13)


def test_what_no_state_changes_does_not_wait_for_one() -> None:
    x, now, after, p = ca.SX.sym("x"), ca.SX.sym("now"), ca.SX.sym("after"), ca.SX.sym("p")
    function = ca.Function("f", [x, now, after, p], [p * x + ca.erf(ca.sin(now) + after)])
    shared, own = (len(Recursion(function, fixed)._each.code) for fixed in ((3,), ()))
    assert shared == own == 5  # a product with a sum of what is loaded, and a result
    function = ca.Function("f", [x, now, after, p], [x + p * ca.erf(ca.sin(now) + after)])
    assert len(Recursion(function, (3,))._each.code) == 4
    assert len(Recursion(function, ())._each.code) == 5


def test_operations_of_a_kind_follow_one_another_in_a_recursion() -> None:
    """As far as they can: the sine of a sum waits for it."""
    x, now, after, p = ca.SX.sym("x", 3), ca.SX.sym("now"), ca.SX.sym("after"), ca.SX.sym("p", 3)
    moved = ca.vertcat(*[ca.sin(ca.exp(x[i]) + p[i]) / x[(i + 1) % 3] for i in range(3)])
    kinds = Recursion(ca.Function("f", [x, now, after, p], [moved]), ())._each.code[:, 0]
    assert np.count_nonzero(np.diff(kinds)) + 1 == 6  # loads, exponentials, sums, sines, quotients, results


def test_a_product_in_one_sum_is_part_of_it() -> None:
    """To the last digit; one that is asked for twice stays."""
    x, y, z = ca.SX.sym("x"), ca.SX.sym("y"), ca.SX.sym("z")
    values = list(np.random.default_rng(3).normal(size=(3, 1, LANES + 5)))
    for expression, operations in (
        (x * y + z, 1), (z + x * y, 1), (x * y - z, 1), (z - x * y, 1), (x * y + x * z, 2), (x * y + z * z, 2),
        (ca.vertcat(x * y, x * y + z), 2), (x * y + ca.fabs(x * y), 3),
    ):  # fmt: skip
        function = ca.Function("f", [x, y, z], [expression])
        tape = Tape(function, fixed=())
        assert np.count_nonzero(tape._each.code[:, 0] > STORE) == operations, expression
        np.testing.assert_array_equal(tape.map(values), np.array(function.map(LANES + 5)(*values)))


def test_what_is_the_same_twice_is_computed_once() -> None:
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    twice = [ca.sin(x * y) + 1.0, ca.sin(y * x) - 1.0, x - y, y - x]
    operations, results = numbered(ca.Function("f", [x, y], [ca.vertcat(*twice)]))
    assert len(operations) == 2 + 2 + 1 + 4  # inputs, product and sine, one, and what differs
    assert len(set(results)) == 4


def test_outputs_that_no_sample_changes() -> None:
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    tape = Tape(ca.Function("f", [x, p], [ca.densify(ca.vertcat(p**2, 0, 4, x))]), fixed=(1,))
    values = tape.map([np.array([[1.0, 2.0]]), np.array([3.0])])
    np.testing.assert_array_equal(values, [[9, 9], [4, 4], [1, 2]])
    np.testing.assert_array_equal(tape.whole(values.T), [[9, 0, 4, 1], [9, 0, 4, 2]])


def test_what_is_steady_is_worked_out_once() -> None:
    """Of rows that stay as they are; what is read off the recording itself is not stored again."""
    x, s, p = ca.SX.sym("x", 2), ca.SX.sym("s"), ca.SX.sym("p", 3)
    law = ca.vertcat(ca.sin(x[0]) * p[0] + p[1] * x[1] * s, ca.exp(x[1] * p[2]), p[1] ** 2 + x[0])
    function = ca.Function("f", [x, s, p], [law])
    tape = Tape(function, fixed=(2,), steady={0: (0, 1), 2: (0, 2)})
    rng = np.random.default_rng(4)
    samples, state, values = rng.normal(size=(2, LANES + 5)), rng.normal(size=(1, LANES + 5)), np.array([1.3, 0.4, 0.8])
    kept = tape.keep([samples, np.empty((0, 0)), values])
    expected = [np.sin(samples[0]) * 1.3, np.exp(samples[1] * 0.8)]
    np.testing.assert_allclose(sorted(kept.tolist()), sorted(row.tolist() for row in expected), rtol=1e-14)
    for moved in (0.4, -7.0):
        values[1] = moved
        inputs = [samples, state, values]
        np.testing.assert_array_equal(tape.map(inputs, kept), Tape(function, fixed=(2,)).map(inputs))
    kept[:] = 0.0
    np.testing.assert_array_equal(tape.map([samples, state, values], kept)[1], 0.0)


def test_foreign_operation_is_refused() -> None:
    x = ca.SX.sym("x")
    function = ca.Function("f", [x], [ca.remainder(x, 2)])
    with pytest.raises(StribeckError, match="operation"):
        Tape(function, fixed=())
