"""Energy balance, orders of convergence, and what the tolerance buys."""

import numpy as np
import pytest

from stribeck.simulate import Engine

from .reference import Reference

NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)


def test_energy_balance(hanging_arm: Engine) -> None:
    """Energy gained = work of the command less work of friction, by quadrature between events."""
    samples = 0.0125 * np.arange(241)
    command = np.stack([12.0 * np.sin(3.0 * samples), 5.0 * np.sin(5.0 * samples + 1.0)], axis=1)
    start = np.array([0.3, 0.1, 0.0, 0.0])
    first = hanging_arm.run(hanging_arm.p, start, samples, command, tolerance=1e-11)
    assert first.event_count >= 8
    breaks = np.union1d(samples, first.events["time"])
    half = 0.5 * np.diff(breaks)
    nodes = (breaks[:-1] + half)[:, None] + half[:, None] * NODES
    times = np.union1d(samples, nodes)
    held = command[np.searchsorted(samples, times, side="right") - 1]
    found = hanging_arm.run(hanging_arm.p, start, times, held, tolerance=1e-11)
    inside = np.searchsorted(times, nodes)
    power = np.sum((held - found.friction) * found.dq, axis=1)[inside]
    work = float(np.sum(half[:, None] * WEIGHTS * power))
    reference = Reference(hanging_arm.path.arm)
    gained = reference.energy(found.state[-1]) - reference.energy(found.state[0])
    spent = float(np.sum(half[:, None] * WEIGHTS * np.sum(np.abs(found.friction * found.dq), axis=1)[inside]))
    assert spent > 5.0
    assert abs(work - gained) < 1e-8
    assert (np.sum(found.friction * found.dq, axis=1) >= 0.0).all()


@pytest.mark.parametrize(("implicit", "order"), [(False, 5), (True, 4)])
def test_order(hanging_arm: Engine, implicit: bool, order: int) -> None:
    state, modes, command = np.array([0.3, 0.2, 2.0, -3.0]), np.array([1.0, -1.0]), np.array([20.0, -5.0])

    def after(steps: int, by_implicit: bool = implicit) -> np.ndarray:
        p = hanging_arm.p
        return hanging_arm.fixed_steps(p, state, modes, command, 0.1 / steps, steps, implicit=by_implicit)

    exact = after(1024, False)
    errors = [np.abs(after(steps) - exact).max() for steps in (8, 16, 32)]
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx([order, order], abs=0.45)


def test_tolerance(hanging_arm: Engine) -> None:
    times = 0.0125 * np.arange(321)
    command = np.stack([12.0 * np.sin(3.0 * times), 5.0 * np.sin(5.0 * times)], axis=1)
    exact = hanging_arm.run(hanging_arm.p, np.zeros(4), times, command, tolerance=1e-13)
    errors = []
    for tolerance in (1e-4, 1e-6, 1e-8, 1e-10):
        found = hanging_arm.run(hanging_arm.p, np.zeros(4), times, command, tolerance=tolerance)
        assert found.event_count == exact.event_count
        errors.append(np.abs(found.q - exact.q).max())
        assert errors[-1] < tolerance
    assert errors == sorted(errors, reverse=True)


def test_a_long_stretch_ends_where_short_ones_do(hanging_arm: Engine) -> None:
    """Under one command for minutes: the link goes round and round, with more steps than one short stretch may have."""
    ends = []
    for count in (1, 500):
        times = np.linspace(0.0, 500.0, count + 1)
        found = hanging_arm.run(hanging_arm.p, np.zeros(4), times, np.tile([60.0, 0.0], (len(times), 1)))
        assert found.status == "ok"
        ends.append(found.dq[-1])
    assert found.steps > 60_000
    np.testing.assert_allclose(ends[0], ends[1], rtol=0.0, atol=1e-3)
