"""The uniform clock: samples stay where they can; what is resampled keeps the motion and the torque's impulse."""

import dataclasses
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stribeck.errors import InputError
from stribeck.grid import uniform
from stribeck.run import Run


def a_run(t: np.ndarray) -> Run:
    q = np.column_stack([np.sin(3 * t), np.cos(2 * t)])
    dq = np.column_stack([3 * np.cos(3 * t), -2 * np.sin(2 * t)])
    return Run("r.csv", t, q, tau=np.sign(q) + q, dq=dq, tau_meas=q)


def jittered(n: int, step: float, jitter: float, seed: int = 0) -> np.ndarray:
    return step * (np.arange(n) + jitter * np.random.default_rng(seed).uniform(-0.5, 0.5, n))


def test_uniform_clock_is_left_alone() -> None:
    run = a_run(0.1 + 0.002 * np.arange(1000))
    assert uniform(run) == (run, ())


def test_seconds_since_1970_keep_their_step() -> None:
    """As stamped, they have 0.24 us each: a thousandth of a step of velocity, and a thousand of acceleration."""
    run = a_run(0.002 * np.arange(1000))
    even, notes = uniform(dataclasses.replace(run, t=run.t + 1764201234.5))
    assert notes == ("r.csv: times are counted from 1764000000 s on",)
    assert even.t[0] == pytest.approx(201234.5)
    np.testing.assert_allclose(np.diff(even.t), 0.002, rtol=1e-7)
    assert np.array_equal(even.q, run.q)


def test_small_jitter_leaves_the_samples() -> None:
    run = a_run(jittered(1000, 0.002, 1e-3))
    even, notes = uniform(run)
    assert notes == ()
    assert even.q is run.q
    assert even.tau is run.tau
    assert even.gaps is None
    np.testing.assert_allclose(np.diff(even.t), 0.002, rtol=1e-5)
    np.testing.assert_allclose(even.t, run.t, atol=2e-6)


def test_step_of_a_coarsely_printed_clock_is_found() -> None:
    """At 300 Hz in steps of 10 us the median step is 0.1 % off: ten samples over 10000."""
    run = a_run(np.round(np.arange(10_000) / 300.0, 5))
    even, _ = uniform(run)
    assert even.sample_time == pytest.approx(1 / 300, rel=1e-6)
    assert len(even.t) in (9_999, 10_000)
    np.testing.assert_allclose(even.q[:, 0], np.sin(3 * even.t), atol=2e-5)


def test_jitter_is_resampled_and_said() -> None:
    run = a_run(jittered(2000, 0.005, 0.5))
    even, (note,) = uniform(run)
    assert re.match(r"r\.csv: resampled from 2000 samples with steps of 2\.5\d* to 7\.\d* ms to \d+ samples", note)
    assert np.ptp(np.diff(even.t)) < 1e-12
    assert even.gaps is None
    inner = slice(5, -5)
    np.testing.assert_allclose(even.q[inner, 0], np.sin(3 * even.t[inner]), atol=1e-8)  # cubic, not linear (3e-5)
    assert even.dq is not None
    np.testing.assert_allclose(even.dq[inner, 0], 3 * np.cos(3 * even.t[inner]), atol=1e-3)
    assert even.tau_meas is not None
    np.testing.assert_allclose(even.tau_meas[inner, 0], np.sin(3 * even.t[inner]), atol=1e-3)


def stamped_late(n: int, jitter: float, lost: list[int]) -> Run:
    """Samples of a coarse encoder taken evenly, every 5 ms, and stamped when they arrive; some never do."""
    taken = np.delete(0.005 * np.arange(n), lost)
    run = a_run(taken)
    stamps = taken + 0.005 * jitter * np.random.default_rng(0).uniform(-0.5, 0.5, len(taken))
    return dataclasses.replace(run, t=stamps, q=np.round(run.q, 4))


@pytest.mark.parametrize("lost", [[], [500], list(range(500, 520))])
def test_stamps_that_are_off_move_no_sample(lost: list[int]) -> None:
    run = stamped_late(2000, 0.6, lost)
    even, notes = uniform(run)
    found = re.match(r"r\.csv: samples taken as (\S+) ms apart.* up to (\S+) ms off", notes[0])
    assert found
    assert (float(found[1]), float(found[2])) == pytest.approx((5.0, 1.5), rel=0.1)
    assert len(notes) == (1 if not lost else 2 if len(lost) == 1 else 3)  # then what is missing is filled in and told
    assert even.sample_time == pytest.approx(0.005, rel=1e-4)  # 2000 stamps tell no more
    there = np.delete(np.arange(len(even.t)), lost)
    np.testing.assert_allclose(even.q[there], run.q[: len(there)], atol=2e-4)


@pytest.mark.parametrize("digits", [2, 9])
def test_samples_that_are_off_are_moved(digits: int) -> None:
    """Taken when the stamps say so: of a coarse record either will do, and it is taken at its word."""
    run = a_run(jittered(2000, 0.005, 0.6))
    even, (note,) = uniform(dataclasses.replace(run, q=np.round(run.q, digits)))
    assert "resampled" in note
    np.testing.assert_allclose(even.q[5:-5, 0], np.sin(3 * even.t[5:-5]), atol=10.0**-digits + 1e-8)


@given(seed=st.integers(0, 1000), jitter=st.floats(0.01, 0.9))
def test_resampling_keeps_the_impulse_of_the_held_torque(seed: int, jitter: float) -> None:
    rng = np.random.default_rng(seed)
    t = jittered(60, 0.01, jitter, seed)
    run = Run("r", t, np.zeros((60, 1)), rng.normal(size=(60, 1)))
    even, _ = uniform(run)
    step = even.t[1] - even.t[0]
    edges = np.append(even.t, even.t[-1] + step)
    for k in range(1, len(edges)):  # the recorded torque, held (the last without end), integrated up to each new time
        held = np.clip(np.append(t[1:], np.inf), None, edges[k]) - np.clip(t, None, edges[k])
        assert step * even.tau[:k, 0].sum() == pytest.approx(held @ run.tau[:, 0], abs=1e-12)


def test_gaps_are_marked_and_bridged_without_swinging_out() -> None:
    t = 0.002 * np.arange(3000)
    kept = np.delete(t, np.r_[1000:1250, 2000:2020, 2500])  # 0.5 s, 40 ms, and one sample that is no gap
    run = a_run(kept)
    even, (resampled, gaps) = uniform(run)
    assert "resampled" in resampled
    assert gaps == "r.csv: 2 gaps with 0.544 s missing in all; the longest, 0.502 s, follows t = 1.998 s"
    assert even.gaps is not None
    np.testing.assert_array_equal(np.flatnonzero(even.gaps), np.r_[1000:1250, 2000:2020])
    np.testing.assert_allclose(even.t, t, atol=1e-9)
    np.testing.assert_allclose(even.q[~even.gaps, 0], np.sin(3 * t[~even.gaps]), atol=1e-8)
    low, high = np.sin(3 * t[[999, 1250]])
    bridge = even.q[1000:1250, 0]
    assert min(low, high) <= bridge.min() <= bridge.max() <= max(low, high)


@pytest.mark.parametrize("samples", [1, 2, 3])
def test_a_short_stretch_between_gaps_is_kept(samples: int) -> None:
    t = np.concatenate([0.01 * np.arange(50), 0.6 + 0.01 * np.arange(samples), 0.7 + 0.01 * np.arange(50)])
    even, _ = uniform(a_run(t))
    assert even.gaps is not None
    np.testing.assert_allclose(even.t[~even.gaps], t, atol=1e-9)
    np.testing.assert_allclose(even.q[~even.gaps], a_run(t).q, atol=1e-9)


def test_more_missing_than_recorded_is_refused() -> None:
    t = np.append(0.01 * np.arange(100), 1e9)
    with pytest.raises(InputError, match=r"r\.csv: more samples are missing.*t = 0\.99 s: found 1e\+09 s"):
        uniform(a_run(t))


def test_unknown_columns_are_not_interpolated() -> None:
    import pyarrow as pa

    t = jittered(100, 0.01, 0.5)
    even, _ = uniform(dataclasses.replace(a_run(t), extra=pa.table({"note": ["x"] * 100})))
    assert even.extra is None
