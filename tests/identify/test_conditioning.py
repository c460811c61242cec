"""Conditioned signals: a known sine comes out as it went in, and the filters do what they say."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stribeck.identify.conditioning import STUCK_TIME, Conditioned, condition, held_command, shaken
from stribeck.identify.cutoff import cutoff_frequency
from stribeck.identify.filters import low_pass
from stribeck.model.balance import UNSURE
from stribeck.run import Run

from .conftest import pendulum, recorded, sines


def inner(run: Conditioned, seconds: float = 0.3) -> slice:
    """The samples clear of the record's ends."""
    k = round(seconds / run.sample_time)
    return slice(k, len(run.time) - k)


@pytest.mark.parametrize("rate", [200.0, 500.0, 1000.0])
def test_sines_keep_amplitude_and_phase(rate: float) -> None:
    """Motion up to 1.3 Hz through a smoother at 37 Hz and more: 1e-4 of position and velocity, 1e-3 of acceleration."""
    run = condition(pendulum(), recorded(rate=rate), 15.0)
    kept = inner(run)
    for found, true, error in zip(
        (run.position, run.velocity, run.acceleration), sines(run.time), (1e-5, 4e-4, 1e-3), strict=True
    ):
        assert found[kept, 0] == pytest.approx(true[kept], abs=error * np.abs(true).max())


def test_filters_that_runs_share_cannot_be_changed_by_one_of_them() -> None:
    first, again = (condition(pendulum(), recorded(), 15.0) for _ in range(2))
    assert first.taps is again.taps
    with pytest.raises(ValueError, match="read-only"):
        first.taps[0] = 0.0
    assert (first.position == again.position).all()


def test_another_conditioning_of_a_run_keeps_its_band() -> None:
    """Noise that is drawn again must pass the filter that the residual has passed."""
    run = condition(pendulum(), recorded(noise=1e-5), 15.0, thin=True)
    assert run.rolled_off(math.inf) is run
    rolled = run.rolled_off(6.0)
    assert rolled.taps == pytest.approx(low_pass(15.0, run.sample_time, 6.0))
    again = shaken(pendulum(), rolled, 15.0, np.zeros(run.run.q.shape))
    assert (again.corner, again.taps is rolled.taps) == (6.0, True)
    assert rolled.rolled_off(math.inf).taps == pytest.approx(run.taps, abs=1e-9)


@pytest.mark.parametrize("rate", [200.0, 1000.0])
def test_no_phase_shift(rate: float) -> None:
    """A sine near the edge of the pass band may shrink but not shift: its quadrature stays empty."""
    t = np.arange(round(8 * rate)) / rate
    hertz = 8.0
    w = 2 * np.pi * hertz
    run = condition(pendulum(), Run("sine", t, 0.1 * np.sin(w * t)[:, None], np.sin(w * t)[:, None]), 10.0)
    kept = inner(run, 0.5)
    kept = slice(kept.start, kept.start + round((kept.stop - kept.start) / rate - 0.5) * round(rate))
    phases = {"position": 0.0, "velocity": np.pi / 2, "acceleration": np.pi}
    for name, lead in phases.items():
        values = getattr(run, name)[kept, 0]
        in_phase = np.mean(values * np.sin(w * t[kept] + lead))
        across = np.mean(values * np.cos(w * t[kept] + lead))
        assert in_phase > 0.0
        assert abs(across) < 1e-6 * in_phase


@pytest.mark.parametrize("turn", [0.1, 0.5, 0.8])
def test_held_command_is_what_acts(turn: float) -> None:
    """A sine of `turn` rad a step, held from sample to sample, acts half a step late and shrunk by sinc(turn / 2)."""
    steps = np.arange(400)
    found = held_command(np.sin(turn * steps)[:, None])[:, 0]
    acting = np.sinc(turn / 2 / np.pi) * np.sin(turn * (steps - 0.5))
    assert found[3:-3] == pytest.approx(acting[3:-3], abs=0.02 * turn**4 + 1e-9)
    run = recorded(rate=250.0)
    assert condition(pendulum(), run, 20.0).command == pytest.approx(held_command(run.tau))


def test_constant_command_stays() -> None:
    assert held_command(np.full((20, 2), 3.0)) == pytest.approx(np.full((20, 2), 3.0))


@settings(max_examples=25)
@given(samples=st.integers(300, 900), cutoff=st.floats(4.0, 40.0), rate=st.sampled_from([200.0, 500.0]))
def test_filtered_is_a_direct_convolution(samples: int, cutoff: float, rate: float) -> None:
    t = np.arange(samples) / rate
    rng = np.random.default_rng(samples)
    run = condition(pendulum(), Run("noise", t, np.sin(3 * t)[:, None], rng.normal(size=(samples, 1))), cutoff)
    values = rng.normal(size=(samples, 2))
    half = len(run.taps) // 2
    assert len(run.taps) % 2 == 1
    assert run.taps == pytest.approx(run.taps[::-1])
    direct = [run.taps @ values[i - half : i + half + 1] for i in run.analysis_index]
    assert run.filtered(values).shape == (len(run.analysis_index), 2)
    assert run.filtered(values) == pytest.approx(np.array(direct).reshape(-1, 2), abs=1e-12)


def test_low_pass_keeps_slow_and_drops_fast() -> None:
    run = condition(pendulum(), recorded(rate=500.0), 20.0)
    t = run.time
    for hertz, gain in ((0.0, 1.0), (5.0, 1.0), (60.0, 0.0)):
        kept = run.filtered(np.cos(2 * np.pi * hertz * t)[:, None])[:, 0]
        assert kept == pytest.approx(gain * np.cos(2 * np.pi * hertz * t[run.analysis_index]), abs=2e-2)


def test_short_record_gives_no_rows_rather_than_wrong_ones() -> None:
    t = np.arange(30) / 500.0
    run = condition(pendulum(), Run("short", t, np.sin(t)[:, None], np.cos(t)[:, None]), 5.0)
    assert len(run.taps) > 30
    assert len(run.analysis_index) == 0
    assert len(run.filtered(run.command)) == 0


@pytest.mark.parametrize("q", [np.zeros(500), np.full(500, 3.0), np.linspace(0, 1, 500)])
def test_no_nan_whatever_the_motion(q: np.ndarray) -> None:
    t = np.arange(500) / 500.0
    run = condition(pendulum(), Run("still", t, q[:, None], np.zeros((500, 1))), 20.0)
    for name in ("position", "velocity", "acceleration", "command", "sliding", "velocity_sd", "stuck", "noise", "taps"):
        assert np.isfinite(getattr(run, name)).all()
    assert (run.velocity_sd > 0.0).all()


def test_stuck_is_rest() -> None:
    rate = 500.0
    t = np.arange(2000) / rate
    q = np.cumsum(np.where((t > 1.0) & (t < 1.5), 0.0, 1.0)) / rate
    run = condition(pendulum(), Run("rest", t, q[:, None], np.zeros((2000, 1))), 40.0, np.array([1e-7]))
    stuck = run.stuck[:, 0] > 0.5
    assert stuck[(t > 1.1) & (t < 1.4)].all()
    assert not stuck[(t < 0.9) | (t > 1.6)].any()


def test_a_filter_that_rings_after_a_stop_tells_no_direction() -> None:
    """Friction holds a joint where it would turn; the smoothed velocity undershoots, far beyond what noise explains."""
    rate, step = 125.0, 5e-5
    t = np.arange(1000) / rate
    q = step * np.round(0.3 * np.cos(2 * np.pi * np.minimum(t, 4.0)) / step)
    run = condition(pendulum(), Run("stop", t, q[:, None], np.zeros((1000, 1))), 10.0, np.array([7.6e-6]))
    after = (t > 4.005) & (t < 6.0)
    assert run.velocity[after].min() < -5.0 * np.min(run.velocity_sd)
    assert (np.abs(run.velocity) <= run.velocity_sd)[after].all()
    before = (t > 2.1) & (t < 2.4)
    assert np.all(run.velocity_sd[before] == np.min(run.velocity_sd))
    noisy = shaken(pendulum(), run, 10.0, np.random.default_rng(0).standard_normal((1000, 1)))
    assert (np.abs(noisy.velocity) <= noisy.velocity_sd)[after[:: len(t) // len(noisy.time)]].all()


def test_nor_does_one_that_rings_at_a_hard_turn() -> None:
    """Friction turns around with the joint, and its acceleration leaps: for some samples the smoothed velocity errs."""
    rate, step = 200.0, 6e-6
    t = np.arange(120) / rate
    since = t - 0.304
    true = np.where(since < 0.0, -11.0, -0.8) * since
    q = step * np.round(0.5 * true * since / step)
    run = condition(pendulum(), Run("turn", t, q[:, None], np.zeros((120, 1))), 30.0)
    velocity, sd = run.velocity[:, 0], run.velocity_sd[:, 0]
    wrong = (np.sign(velocity) != np.sign(true)) & (np.abs(velocity) > UNSURE * sd.min())
    assert wrong.any()
    assert (np.abs(velocity) < UNSURE * sd)[wrong].all()
    assert (sd == sd.min())[(np.abs(since) > 0.1) & (np.abs(since) < 0.2)].all()


@pytest.mark.parametrize(("hertz", "rests"), [(0.3, False), (0.05, True)])
def test_passing_through_zero_is_no_rest(hertz: float, rests: bool) -> None:
    """Below the threshold for less than STUCK_TIME at a reversal: not stuck; for longer: as good as at rest."""
    t = np.arange(5000) / 500.0
    w = 2 * np.pi * hertz
    run = condition(pendulum(), Run("sine", t, np.sin(w * t)[:, None] / w, np.zeros((5000, 1))), 20.0, np.array([5e-5]))
    below = 2 * 3.0 * run.velocity_sd[0, 0] / w  # s, at a speed of amplitude one
    assert 3 * run.sample_time < below
    assert (below > STUCK_TIME) == rests
    assert bool(run.stuck.any()) == rests


def test_velocity_uncertainty_is_that_of_the_noise() -> None:
    """The spread of the velocity of a still, noisy record is what `velocity_sd` says."""
    rng = np.random.default_rng(0)
    t = np.arange(20_000) / 500.0
    q = 1e-4 * rng.standard_normal((20_000, 1))
    run = condition(pendulum(), Run("noise", t, q, np.zeros_like(q)), 15.0)
    assert np.median(run.velocity_sd) == pytest.approx(np.std(run.velocity[:, 0]), rel=0.1)


def test_cutoff_follows_the_noise() -> None:
    inertia = np.array([0.16])

    def cutoff(noise: float, rate: float = 500.0) -> float:
        return cutoff_frequency(pendulum(), [recorded(rate=rate)], inertia, np.array([noise]))

    assert cutoff(1e-7) == 40.0
    assert 5.0 <= cutoff(1e-3) < 20.0
    assert cutoff(1e-3) < cutoff(1e-4) < 40.0
    assert cutoff(1e-7, rate=50.0) <= 0.2 * 50.0
