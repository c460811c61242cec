"""Measured beside commanded torque: how they are related, and on which side of the measurement the gap lies."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.gap.answer.delivered import as_commanded, delivered, relation, told_lacking
from stribeck.gap.fitted.model import Model, retune
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.gap.result import Delivered, Estimate
from stribeck.identify.conditioning import condition
from stribeck.run import Run
from stribeck.withheld.excitation import programme
from stribeck.withheld.injections import Injection
from stribeck.withheld.recorder import default_gains, record

from ...effects.bench import nominal_arm, true_arm
from ..conftest import NOMINAL, TRUE, recorded, sines

FLOOR = np.full(1, 0.01)


def wavy(delay: float = 0.0) -> Run:
    """Torque of a few frequencies: commanded (the mean over the step to come), and measured at the instant, late."""
    run = sines(12.0)
    step = run.sample_time

    def torque(t: np.ndarray) -> np.ndarray:
        return (3.0 * np.sin(5.0 * t) + np.sin(31.0 * t + 1.0))[:, None]

    return replace(run, tau=torque(run.t + 0.5 * step), tau_meas=torque(run.t - delay))


def test_a_measured_torque_stands_in_for_the_command() -> None:
    run = wavy()
    first, second = (condition(TRUE, r, 15.0) for r in (run, as_commanded(run)))
    inside = slice(50, -50)
    assert np.max(np.abs(first.command - second.command)[inside]) < 2e-3


@pytest.mark.parametrize(("gain", "offset", "delay"), [(1.0, 0.0, 0.0), (0.83, 0.4, 0.012), (1.2, -0.1, -0.003)])
def test_relation(gain: float, offset: float, delay: float) -> None:
    run = wavy(delay)
    assert run.tau_meas is not None
    noise = 0.05 * np.random.default_rng(0).standard_normal(run.tau.shape)
    run = replace(run, tau_meas=gain * run.tau_meas + offset + noise)
    commanded, measured = (condition(TRUE, r, 15.0) for r in (run, as_commanded(run)))
    found = relation([commanded], [measured], 0)
    for estimate, true, close in zip(found[:3], (gain, offset, delay), (0.01, 0.02, 5e-4), strict=True):
        assert estimate.low - 1e-3 * close <= true <= estimate.high + 1e-3 * close
        assert estimate.high - estimate.low < 2.0 * close
    assert 0.005 < found[3] < 0.05  # noise below the cutoff


def looked_at(runs: tuple[Run, ...]) -> tuple[Delivered, ...]:
    prepared = prepare(NOMINAL, runs)
    return delivered(prepared, base_of(prepared), FLOOR)[0]


def base_of(prepared: Prepared) -> Model:
    return retune(prepared, FLOOR)


def test_a_late_drive_is_seen_before_the_measurement() -> None:
    (row,) = looked_at(recorded(("delay", {"time": 0.02}), channels=("tau_meas",)))
    assert row.joint == "A"
    assert row.delay.value == pytest.approx(0.02, abs=0.003)
    assert row.gain.value == pytest.approx(1.0, abs=0.02)
    assert row.share is not None
    assert row.share.low > 0.5  # the record's half a sample of delay is more than nothing to this floor
    assert row.share.value > 0.8


def test_a_late_encoder_is_not() -> None:
    (row,) = looked_at(recorded(("time_shift", {"time": 0.02}), channels=("tau_meas",)))
    assert row.share is not None
    assert row.share.high < 0.1


@pytest.mark.parametrize(("gain", "offset"), [(0.7, 0.0), (1.3, 0.0), (-0.7, 0.0), (1.0, 1.0), (0.7, 1.0)])
def test_the_scale_of_the_sensor_is_no_part_of_the_gap(gain: float, offset: float) -> None:
    """What an ideal drive is blamed for, nothing, and what a late one is, whatever units the sensor reads in."""
    late = recorded(("delay", {"time": 0.02}), channels=("tau_meas",))
    for runs, share in ((recorded(("time_shift", {"time": 0.02}), channels=("tau_meas",)), 0.0), (late, 0.988)):
        (row,) = looked_at(tuple(replace(run, tau_meas=gain * measured(run) + offset) for run in runs))
        assert row.gain.value == pytest.approx(gain, abs=1e-3)
        assert row.share is not None
        assert row.share.value == pytest.approx(share, abs=0.01)


def measured(run: Run) -> np.ndarray:
    assert run.tau_meas is not None
    return run.tau_meas


def test_a_drive_that_loses_a_constant_part_looks_like_a_sensor_that_does() -> None:
    (row,) = looked_at(recorded(("torque_gain", {"gain": 0.7}), channels=("tau_meas",)))
    assert row.gain.value == pytest.approx(0.7, abs=0.01)
    assert row.share is not None
    assert row.share.value == pytest.approx(0.0, abs=0.01)


def test_no_share_by_a_sensor_that_reads_something_else() -> None:
    rng = np.random.default_rng(0)
    runs = recorded(("delay", {"time": 0.02}), channels=("tau_meas",))
    (row,) = looked_at(tuple(replace(run, tau_meas=rng.standard_normal(run.tau.shape)) for run in runs))
    assert row.gain.low < 0.0 < row.gain.high
    assert row.share is None


def test_a_sensor_that_adds_more_than_is_gone_tells_nothing() -> None:
    rng = np.random.default_rng(0)
    runs = recorded(("delay", {"time": 0.005}), channels=("tau_meas",))
    loud = tuple(replace(run, tau_meas=measured(run) + 5.0 * rng.standard_normal(run.tau.shape)) for run in runs)
    prepared = prepare(NOMINAL, loud)
    (row,), whole = delivered(prepared, base_of(prepared), FLOOR)
    assert row.share == whole == Estimate(0.0, 0.0, 1.0)


def test_no_share_is_below_nothing() -> None:
    """What a gain closes of a weak drive's gap is more than its noisy measurement does."""
    rng = np.random.default_rng(0)
    runs = recorded(("torque_gain", {"gain": 0.7}), channels=("tau_meas",))
    loud = tuple(replace(run, tau_meas=measured(run) + 0.5 * rng.standard_normal(run.tau.shape)) for run in runs)
    (row,) = looked_at(loud)
    assert row.share is not None
    assert row.share.low == row.share.value == 0.0


def test_nothing_is_said_without_the_measurement() -> None:
    runs = recorded(channels=("tau_meas",))
    assert looked_at((*runs[:-1], replace(runs[-1], tau_meas=None))) == ()
    broken = replace(runs[-1], tau_meas=np.where(np.arange(len(runs[-1].t)) == 7, np.nan, 1.0)[:, None])
    assert looked_at((*runs[:-1], broken)) == ()


def test_runs_without_the_measurement_are_told_where_others_hold_it() -> None:
    runs = recorded(channels=("tau_meas",))
    bare = tuple(replace(run, tau_meas=None) for run in runs)
    assert told_lacking(prepare(NOMINAL, runs)) == told_lacking(prepare(NOMINAL, bare)) == []
    (note,) = told_lacking(prepare(NOMINAL, (runs[0], *bare[1:3], runs[3])))
    assert {run.name for run in runs if run.name in note} == {bare[1].name, bare[2].name}


def test_no_share_of_no_gap() -> None:
    prepared = prepare(NOMINAL, recorded(channels=("tau_meas",)))
    (row,), whole = delivered(prepared, base_of(prepared), np.full(1, 10.0))
    assert (row.share, whole) == (None, None)


@pytest.mark.parametrize(("commanded", "measured"), [(0.0, 1.0), (1.0, 0.0)])
def test_a_joint_without_torque_tells_nothing(commanded: float, measured: float) -> None:
    """A passive joint, or a sensor that reads zero: no delay of no width is made up."""
    run = wavy()
    assert run.tau_meas is not None
    run = replace(run, tau=commanded * run.tau, tau_meas=measured * run.tau_meas)
    found = relation([condition(TRUE, run, 15.0)], [condition(TRUE, as_commanded(run), 15.0)], 0)
    assert all(np.isnan(estimate.value) and np.isnan(estimate.low) for estimate in found[:3])
    assert np.isfinite(found[3])


def test_what_one_drive_does_to_the_other_joint_is_not_laid_to_that_one() -> None:
    """B's drive is weak and late, A's does as it is told; through the coupling B's bends the values of A, too."""
    arm, nominal = true_arm(bend=False), nominal_arm(bend=False)
    hidden = [Injection("actuator_lag", "B", {"time": 0.012}), Injection("torque_gain", "B", {"gain": 0.88})]
    motions = programme(nominal, np.random.default_rng(1), ("multisine", "via points", "slow reversals"), 4.0)
    gains, channels = default_gains(nominal, 3.0), ("tau_meas",)
    runs = record(arm, hidden, motions, rate=250.0, noise=1e-5, gains=gains, model=nominal, seed=5, channels=channels)
    prepared, floor = prepare(nominal, runs), np.array([0.02, 0.01])
    (perfect, late), whole = delivered(prepared, retune(prepared, floor), floor)
    assert perfect.share is not None
    assert (perfect.share.value, perfect.share.low) == (0.0, 0.0)
    assert perfect.share.high < 1e-4
    assert late.share is not None
    assert late.share.low > 0.2  # the lag's part; that of the gain may be the sensor's
    assert whole is not None
    assert 0.2 < whole.low < whole.high < 0.9


def test_a_dead_zone_is_seen_before_the_measurement() -> None:
    """Gain and offset of the straight line through it are not those that the sensor may have."""
    (row,) = looked_at(recorded(("torque_dead_zone", {"width": 3.0}), channels=("tau_meas",)))
    assert row.share is not None
    assert row.share.low > 0.9
