"""A joint that a brake holds: what a recording says of it, which is nothing, and of the others, which is all."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import Arm
from stribeck.gap.answer.motion import motion_gap
from stribeck.gap.records.prepare import prepare
from stribeck.identify.braked import braked, unmoved
from stribeck.identify.conditioning import Conditioned, condition, shaken
from stribeck.identify.cutoff import cutoff_frequency
from stribeck.identify.residual import Residual
from stribeck.model.layout import values_of
from stribeck.model.path import SignalPath
from stribeck.run import Run

from .conftest import PENDULUM, pendulum, recorded

NOISE = 2e-5
TWO = replace(pendulum(), joints=(PENDULUM, replace(PENDULUM, name="B", encoder_resolution=NOISE)))


def beside(run: Run, q: np.ndarray | float, tau: np.ndarray | float) -> Run:
    """The pendulum's run with a second joint."""
    both = ((run.q, q), (run.tau, tau))
    again = [np.column_stack([own[:, 0], np.broadcast_to(other, len(run.t))]) for own, other in both]
    return Run(run.name, run.t, *again)


def ways() -> dict[str, tuple[np.ndarray | float, np.ndarray | float]]:
    """Position and torque of a second joint beside :func:`recorded`."""
    t = np.arange(3000) / 500.0
    shaky = 0.7 + NOISE * np.random.default_rng(0).standard_normal(len(t))
    return {
        "braked": (0.7, 0.0),
        "braked, a noisy encoder": (shaky, 0.0),
        "braked, a noisy torque": (0.7, 0.02 * np.random.default_rng(1).standard_normal(len(t))),
        "braked, its drive set": (0.7, 3.0),
        "held by its drive": (0.7, np.sin(t)),
        "swung by others": (0.7 + 0.3 * np.sin(t), 0.0),
        "creeping": (0.7 + 20.0 * NOISE * t / t[-1], 0.0),
    }


@pytest.mark.parametrize("way", ways())
def test_what_neither_moves_nor_is_driven(way: str) -> None:
    run = beside(recorded(), *ways()[way])
    assert braked(TWO, run, np.full(2, NOISE)).tolist() == [False, way.startswith("braked")]


def test_what_stands_still_at_any_torque() -> None:
    """A joint that trembles to and fro moves, though it is where it was in every window."""
    t = np.arange(3000) / 500.0
    trembling = 0.7 + 20.0 * NOISE * np.sin(2.0 * np.pi * 40.0 * t)
    told = {way: beside(recorded(), *values) for way, values in {**ways(), "trembling": (trembling, 0.0)}.items()}
    still = {way for way, run in told.items() if unmoved(run, np.full(2, NOISE))[1]}
    assert still == {way for way in ways() if way.startswith("braked")} | {"held by its drive"}


def braked_run(arm: Arm = TWO) -> Conditioned:
    return condition(arm, beside(recorded(noise=NOISE), 0.7, 0.0), 15.0, np.full(2, NOISE), thin=True)


def test_nothing_is_left_at_it_whatever_it_would_have_to_hold() -> None:
    """Gravity asks for more than its friction holds; of the joint that moves everything is left as it was."""
    run = braked_run()
    path = SignalPath(TWO)
    there = Residual(path, [replace(run, braked=np.zeros(2, dtype=bool))])(values_of(path.entries))
    here = Residual(path, [run])(values_of(path.entries))
    assert np.abs(there[0][:, 1]).max() > PENDULUM.friction.C0
    for with_brake, without in zip(here, there, strict=True):
        assert not with_brake[:, 1].any()
        np.testing.assert_array_equal(with_brake[:, 0], without[:, 0])


def test_noise_that_is_added_does_not_release_it() -> None:
    again = shaken(TWO, braked_run(), 15.0, 30.0 * np.random.default_rng(0).standard_normal((3000, 2)))
    assert again.braked.tolist() == [False, True]


def test_it_is_told_of_and_held_in_simulations() -> None:
    runs = [replace(beside(recorded(), 0.7, 0.0), name=name) for name in ("a", "b")]
    prepared = prepare(TWO, runs)
    assert any("a, b: B neither moves nor is driven" in note for note in prepared.notes)
    gap, failed = motion_gap(TWO, prepared.held, prepared.cutoff, 0.5)
    assert failed == 0
    assert gap["B"] < 1e-3
    free = [replace(run, braked=np.zeros(2, dtype=bool)) for run in prepared.held]
    assert motion_gap(TWO, free, prepared.cutoff, 0.5)[0]["B"] > 0.1  # it falls
    driven = [replace(beside(recorded(), 0.7, np.linspace(0.0, 1.0, 3000)), name=name) for name in ("a", "b")]
    assert not any("B neither" in note for note in prepare(TWO, driven).notes)


def test_it_does_not_narrow_what_is_analysed() -> None:
    """Nor does a joint without a drive that others swing; one that is driven by next to nothing does."""
    inertia, noise = np.full(2, 0.16), np.full(2, 1e-4)
    alone = cutoff_frequency(pendulum(), [recorded()], inertia[:1], noise[:1])
    swung = recorded().q[:, 0]

    def cutoff(q: np.ndarray | float, tau: np.ndarray | float) -> float:
        return cutoff_frequency(TWO, [beside(recorded(), q, tau)], inertia, noise)

    assert cutoff(0.7, 0.0) == alone
    assert cutoff(swung, 0.0) == pytest.approx(alone, rel=0.3)
    assert cutoff(0.7 + 0.01 * swung, 0.0) < 0.5 * alone


def test_a_recording_that_moves_it_later_is_not_said_to_hold_it() -> None:
    """Rows are lost in between: of its two stretches the first one holds the joint."""
    run = beside(recorded(noise=NOISE), 0.7, 0.0)
    late = np.arange(len(run.t)) >= 1500
    run.q[late, 1], run.tau[late, 1] = run.q[late, 0], run.tau[late, 0]
    kept = np.abs(np.arange(len(run.t)) - 1500) > 20
    torn = replace(run, name="a", t=run.t[kept], q=run.q[kept], tau=run.tau[kept])
    prepared = prepare(TWO, [torn], [replace(beside(recorded(), 0.7, 0.0), name="b")])
    assert [run.braked[1] for run in prepared.fit] == [True, False]
    assert [note.partition(":")[0] for note in prepared.notes if "neither moves" in note] == ["b"]
