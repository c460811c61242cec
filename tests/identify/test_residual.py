"""The filtered residual and its derivatives, also where the evaluation is cut into pieces."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import Arm
from stribeck.effects.registry import effect_named, registry
from stribeck.identify import residual as module
from stribeck.identify.conditioning import Conditioned, condition
from stribeck.identify.residual import Residual
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath
from stribeck.run import Run

from .conftest import pendulum, recorded

BRISTLE = {"stiffness": 400.0, "damping": 2.0}


def runs(cutoff: float = 20.0) -> list[Conditioned]:
    return [condition(pendulum(), recorded(rate=rate, duration=3.0, noise=1e-5), cutoff) for rate in (250.0, 500.0)]


def path(*placed: tuple[str, dict[str, float]], arm: Arm | None = None) -> SignalPath:
    return SignalPath(arm or pendulum(), [Placed(registry()[name], 0, values) for name, values in placed])


def differences(residual: Residual, p: np.ndarray) -> np.ndarray:
    """Central differences of the residual (M, n, columns)."""
    out = []
    for i in residual.columns:
        step = 1e-6 * max(abs(p[i]), 1e-2)
        ahead, behind = p.copy(), p.copy()
        ahead[i] += step
        behind[i] -= step
        out.append((residual(ahead)[0] - residual(behind)[0]) / (2 * step))
    return np.stack(out, axis=2)


def test_recorded_law_leaves_no_residual() -> None:
    """Only the filter's ripple and the turning points, where the noise-free law jumps, are left."""
    run = condition(pendulum(), recorded(), 20.0)
    residual = Residual(path(), [run], ())
    r, jacobian = residual(values_of(residual.path.entries))
    assert jacobian.shape == (len(r), 1, 0)
    assert residual.rows == len(r) == len(run.analysis_index)
    assert np.median(np.abs(r)) < 5e-3
    assert np.sqrt(np.mean(r**2)) < 0.02 * np.std(run.command)


@pytest.mark.parametrize("rate", [100.0, 250.0, 500.0, 1000.0])
def test_a_reversal_between_two_samples_leaves_nothing(rate: float) -> None:
    """Friction jumps by 5 N m there; put off to the next sample, that would leave 0.4 N m, and 0.7 N m at 100 Hz."""
    run = condition(pendulum(), recorded(rate=rate), min(20.0, 0.15 * rate), np.full(1, 1e-9), thin=True)
    residual = Residual(path(), [run], ())
    r, _ = residual(values_of(residual.path.entries))
    assert np.abs(r).max() < 0.1


def test_asymmetric_friction_is_symmetric_friction_and_an_offset() -> None:
    """Also at rest and where the sign of the velocity is not sure."""
    noisy = [condition(pendulum(), recorded(rate=250.0, noise=1e-4), 20.0, thin=True)]
    biased = Residual(path(("torque_offset", {"offset": -0.4})), noisy, ())
    uneven = Residual(path(("asymmetric_friction", {"coulomb": 0.4})), noisy, ())
    one, other = (residual(values_of(residual.path.entries))[0] for residual in (biased, uneven))
    assert one == pytest.approx(other, abs=1e-9)
    assert np.std(one) > 0.01


PLAY = {"gap": 0.02, "stiffness": 90.0, "damping": 1.5}
SHAFT = {"stiffness": 60.0, "damping": 0.8}
WHEEL = {"sine": 0.02, "cosine": -0.01, "harmonic": 1.0}


@pytest.mark.parametrize(
    "placed",
    [
        (),
        (("presliding", BRISTLE),),
        (("delay", {"time": 0.013}),),
        (("backlash", PLAY), ("presliding", BRISTLE)),
        (("joint_flexibility", SHAFT), ("encoder_eccentricity", WHEEL), ("actuator_lag", {"time_constant": 0.02})),
    ],
)
def test_jacobian(placed: Sequence[tuple[str, dict[str, float]]]) -> None:
    residual = Residual(path(*placed), runs())
    p = values_of(residual.path.entries)
    p = p * (1.0 + 0.02 * np.cos(np.arange(len(p))))
    exact, approximate = residual(p)[1], differences(residual, p)
    assert "A.friction.alpha" in [residual.path.entries[i].key for i in residual.columns]
    scale = np.abs(approximate).max(axis=(0, 1))
    assert (scale > 0.0).all()
    assert exact / scale == pytest.approx(approximate / scale, abs=1e-4)


@pytest.mark.parametrize("samples", [100, 257, 700])
def test_pieces_make_the_whole(samples: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """However few samples are evaluated at a time, rows and derivatives are the same, states run on."""
    residual = Residual(path(("presliding", BRISTLE), ("delay", {"time": 0.013})), runs())
    p = values_of(residual.path.entries)
    whole, derivatives = residual(p)
    monkeypatch.setattr(module, "SAMPLES", samples)
    again, pieces = residual(p)
    assert again == pytest.approx(whole, abs=1e-10 * np.abs(whole).max())
    assert pieces == pytest.approx(derivatives, abs=1e-10 * np.abs(derivatives).max())


def test_runs_follow_one_another() -> None:
    """Rows of several runs, of different rates, are those of each alone; a state starts anew with each."""
    both = runs()
    model = path(("presliding", BRISTLE))
    p = values_of(model.entries)
    parts = [Residual(model, [run], ())(p)[0] for run in both]
    assert np.concatenate(parts) == pytest.approx(Residual(model, both, ())(p)[0], abs=1e-12)


def test_clocks_that_differ_by_their_rounding_are_one() -> None:
    """Runs of nearly one rate advance side by side, and each comes to what it comes to alone."""
    ticks = (2e-3, 2e-3 * (1.0 + 2e-5))
    alone = [condition(pendulum(), recorded(rate=1.0 / step, duration=3.0, noise=1e-5), 20.0) for step in ticks]
    model = path(("presliding", BRISTLE))
    p = values_of(model.entries)
    parts = [Residual(model, [run], ())(p)[0] for run in alone]
    together = Residual(model, alone, ())
    assert np.concatenate(parts) == pytest.approx(together(p)[0], abs=1e-4 * np.std(alone[0].command))
    assert len(together._machines) == 1


def test_stages_filter_to_the_residual() -> None:
    run = runs()[0]
    residual = Residual(path(("presliding", BRISTLE)), [run], ())
    p = values_of(residual.path.entries)
    stages = residual.stages(run, p)
    assert run.filtered(stages["residual"]) == pytest.approx(residual(p)[0], abs=1e-10)
    left = stages["actuator"] - stages["rotor"] - stages["load"] - stages["friction"]
    assert left == pytest.approx(stages["residual"], abs=1e-10)


def test_states_are_those_of_the_law() -> None:
    """A bristle's torque, by plain Euler steps of the same motion: dz = sigma (v - |v| z / G)."""
    run = condition(pendulum(), recorded(rate=1000.0, duration=2.0), 20.0)
    residual = Residual(path(("presliding", BRISTLE)), [run], (), observe=False)
    states = residual.states(run, values_of(residual.path.entries))
    assert residual.path.state_names == ("0.torque",)
    torque, bristle = 0.0, []
    for a, b in zip(run.position[:-1, 0], run.position[1:, 0], strict=True):
        for _ in range(20):
            v = (b - a) / run.sample_time
            level = 2.0 + 0.5 * np.exp(-abs(v) / 0.05)
            torque += run.sample_time / 20 * 400.0 * (v - abs(v) * torque / level)
        bristle.append(torque)
    assert states[1:, 0] == pytest.approx(np.array(bristle), abs=0.02)


def test_delayed_command() -> None:
    """A delay of whole samples is a shift of the command; before the record the first value holds."""
    run = runs()[1]
    residual = Residual(path(("delay", {"time": 0.01})), [run], ())
    actuator = residual.stages(run, values_of(residual.path.entries))["actuator"]
    assert actuator[5:] == pytest.approx(run.command[:-5], abs=1e-9)
    assert actuator[:5] == pytest.approx(np.broadcast_to(run.command[0], (5, 1)), abs=1e-9)


def test_a_gain_that_goes_with_position_shrinks_no_residual() -> None:
    """In units of the command: a drive of half the strength everywhere cannot halve what is left unexplained."""
    run = condition(pendulum(), recorded(noise=1e-5), 20.0)
    weak = path(("torque_ripple", {"sine": 0.0, "cosine": -0.5, "harmonic": 1e-9}))
    gain = path(("torque_gain", {"gain": 0.5}))
    left = [Residual(one, [run], ())(values_of(one.entries))[0] for one in (weak, gain)]
    assert left[0] == pytest.approx(left[1], abs=1e-9)


@pytest.mark.parametrize("law", ["lugre", "maxwell_slip", "elasto_plastic"])
@pytest.mark.parametrize("rate", [100.0, 1000.0])
def test_a_bristle_is_damped_by_as_much_as_it_bends(law: str, rate: float) -> None:
    """At a reversal within an instant: at the samples alone that pulse is missed, or counted for all of a sample."""
    run = condition(pendulum(), recorded(rate=rate), 10.0, np.full(1, 1e-9))

    def along(damping: float) -> tuple[np.ndarray, np.ndarray]:
        placed = Placed(effect_named("presliding", law), 0, {**BRISTLE, "damping": damping})
        residual = Residual(SignalPath(pendulum(), [placed]), [run], (), observe=False)
        p = values_of(residual.path.entries)
        return residual.states(run, p), residual.stages(run, p)["friction"][:, 0]

    (states, damped), (_, plain) = along(BRISTLE["damping"]), along(0.0)
    held, bending = states[:, :-1].sum(axis=1), states[:, -1]
    np.testing.assert_allclose(bending, np.gradient(held, run.sample_time), atol=1e-6 * np.abs(bending).max())
    np.testing.assert_allclose(damped - plain, BRISTLE["damping"] / BRISTLE["stiffness"] * bending, atol=1e-9)
    middle = slice(50, -50)
    gone = np.sum((damped - plain)[middle]) * run.sample_time  # of momentum
    bent = BRISTLE["damping"] / BRISTLE["stiffness"] * (held[-50] - held[50])
    assert gone == pytest.approx(bent, abs=0.02 * BRISTLE["damping"] / BRISTLE["stiffness"] * np.abs(held).max())


def test_values_leave_no_trace_in_the_runs() -> None:
    """What the runs drive is laid out once: a delay that was tried before, or other runs, change nothing."""
    both = [condition(pendulum(), recorded(duration=3.0, noise=1e-5, seed=seed), 20.0) for seed in (0, 1)]
    late = Residual(path(("delay", {"time": 0.01}), ("actuator_lag", {"time_constant": 0.02})), both, ())
    p = values_of(late.path.entries)
    moved = p.copy()
    moved[[entry.name for entry in late.path.entries].index("time")] = 0.05
    first, between, again = late(p)[0], late(moved)[0], late(p)[0]
    assert np.abs(between - first).max() > 0.1
    assert np.array_equal(again, first)
    alone = [Residual(late.path, [run], ())(moved)[0] for run in both]
    assert between == pytest.approx(np.concatenate(alone), abs=1e-12)
    ahead = late.along(both[::-1])(p)[0]
    assert not np.array_equal(ahead, first)
    assert np.array_equal(late.along(both)(p)[0], first)


def test_records_that_share_a_clock_are_late_together() -> None:
    """As both joints with the same time each; the derivative is that of both at once."""
    arm = Arm("two joints", (9.81, 0.0), tuple(replace(pendulum().joints[0], name=joint) for joint in "AB"))
    one = recorded(duration=3.0, noise=1e-5)
    shifted = [np.column_stack([x[:, 0], np.roll(x[:, 0], 217)]) for x in (one.q, one.tau)]
    run = condition(arm, Run("two", one.t, *shifted), 20.0)
    every, each = effect_named("time_shift", "all_joints"), effect_named("time_shift", "one_joint")
    together = SignalPath(arm, [Placed(every, 0, {"time": -0.013})])
    apart = SignalPath(arm, [Placed(each, joint, {"time": -0.013}) for joint in (0, 1)])
    (first, by_all), (second, by_each) = (Residual(path, [run])(values_of(path.entries)) for path in (together, apart))
    assert first == pytest.approx(second, abs=1e-12)
    assert by_all[..., -1] == pytest.approx(by_each[..., -2] + by_each[..., -1], abs=1e-9 * np.abs(by_all).max())
    assert together.shifts == (len(together.entries) - 1,)
    later = SignalPath(arm, [Placed(every, 0, {"time": -0.02}), Placed(each, 0, {"time": 0.007}), apart.placed[1]])
    twice = SignalPath(arm, [apart.placed[0], Placed(each, 1, {"time": -0.033})])
    summed, single = (Residual(path, [run], ())(values_of(path.entries))[0] for path in (later, twice))
    assert summed == pytest.approx(single, abs=1e-12)
    prompt = SignalPath(arm)
    assert np.abs(first - Residual(prompt, [run], ())(values_of(prompt.entries))[0]).max() > 0.1


@pytest.mark.parametrize("name", ["delay", "time_shift"])
def test_the_second_joint_alone_is_late(name: str) -> None:
    """As the record of that joint moved by whole samples: its command, or its motion and what of it surely slides."""
    arm = Arm("two joints", (9.81, 0.0), tuple(replace(pendulum().joints[0], name=joint) for joint in "AB"))
    one = recorded(duration=3.0, noise=1e-5)
    q = np.column_stack([one.q[:, 0], np.roll(one.q[:, 0], 217)])
    tau = np.column_stack([one.tau[:, 0], np.roll(one.tau[:, 0], 217)])
    run = condition(arm, Run("two", one.t, q, tau), 20.0)
    samples = 5
    bristle = Placed(registry()["presliding"], 1, BRISTLE)
    late = SignalPath(arm, [Placed(registry()[name], 1, {"time": samples * run.sample_time}), bristle])
    sides = ("command",) if name == "delay" else ("position", "velocity", "acceleration", "flutter", "sliding")
    moved = {side: getattr(run, side).copy() for side in sides}
    for values in moved.values():
        values[:, 1] = np.roll(values[:, 1], samples if name == "delay" else -samples)
    asked = Residual(late, [run], ())(values_of(late.entries))[0]
    shifted = SignalPath(arm, [bristle])
    expected = Residual(shifted, [replace(run, **moved)], ())(values_of(shifted.entries))[0]
    inside = slice(len(asked) // 3, -4)  # the record's ends wrap around, and the bristle forgets with which it began
    assert asked[inside] == pytest.approx(expected[inside], abs=1e-9)
    assert np.abs(Residual(shifted, [run], ())(values_of(shifted.entries))[0] - expected)[inside].max() > 0.1


def test_a_run_that_is_shorter_than_the_filter_adds_no_row() -> None:
    long, short = (condition(pendulum(), recorded(rate=1000.0, duration=d, noise=1e-5), 20.0) for d in (4.0, 0.1))
    assert len(short.analysis_index) == 0
    path = SignalPath(pendulum())
    alone, both = (Residual(path, runs)(values_of(path.entries)) for runs in ([long], [long, short]))
    assert all((one == other).all() for one, other in zip(alone, both, strict=True))
    assert short.filtered(np.zeros((0, 2, 3))).shape == (0, 2, 3)
