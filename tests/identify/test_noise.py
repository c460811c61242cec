"""Noise read off records: right within a tenth for any rate and quantisation, blind to the motion and its blows."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.grid import uniform
from stribeck.identify.noise import doubtful_resolutions, encoder_noise, noise_of_run, position_noise
from stribeck.quantum import smallest_step
from stribeck.run import Run

from .conftest import pendulum


def record(rate: float, noise: float, step: float, seed: int = 0, duration: float = 10.0) -> np.ndarray:
    t = np.arange(round(duration * rate)) / rate
    q = 0.8 * np.sin(2 * np.pi * 0.4 * t) + 0.3 * np.sin(2 * np.pi * 1.7 * t + 1.0)
    q = q + noise * np.random.default_rng(seed).standard_normal(len(q))
    return np.round(q / step) * step if step else q


@pytest.mark.parametrize("rate", [100.0, 250.0, 1000.0])
@pytest.mark.parametrize("noise", [1e-5, 1e-3])
@pytest.mark.parametrize("step", [0.0, 1.0])
def test_white_noise(rate: float, noise: float, step: float) -> None:
    """With quantisation of `step` standard deviations its own noise adds, step / sqrt(12) (Widrow & Kollar)."""
    found = [position_noise([record(rate, noise, step * noise, seed)], [1.0 / rate]) for seed in range(3)]
    expected = noise * np.hypot(1.0, step / np.sqrt(12.0))
    assert np.mean(found) == pytest.approx(expected, rel=0.1)


@pytest.mark.parametrize("rate", [250.0, 1000.0])
def test_quantisation_alone(rate: float) -> None:
    step = 1e-4
    found = position_noise([record(rate, 0.0, step)], [1.0 / rate], step)
    assert found >= step / np.sqrt(12.0) * (1 - 1e-9)
    assert found < 1.3 * step / np.sqrt(12.0)


def test_joint_that_hardly_moves_has_at_least_the_noise_of_its_encoder() -> None:
    q = np.zeros(2000)
    q[1000:] = 1e-3
    assert position_noise([q], [1e-3], resolution=1e-3) == pytest.approx(1e-3 / np.sqrt(12.0), rel=0.05)
    assert position_noise([np.zeros(2000)], [1e-3]) == 1e-12  # nothing known, nothing divided by zero


def test_resonance_does_not_pass_for_noise() -> None:
    """A structural mode in the upper band is narrow: the median looks past it."""
    rate = 500.0
    t = np.arange(5000) / rate
    q = record(rate, 1e-5, 0.0) + 3e-5 * np.sin(2 * np.pi * 200.0 * t)
    assert position_noise([q], [1.0 / rate]) == pytest.approx(1e-5, rel=0.15)


@pytest.mark.parametrize("rate", [125.0, 500.0])
def test_a_blow_is_no_noise(rate: float) -> None:
    """A play that hits now and then bends the position; its velocity leaps by a tenth of the joint's."""
    t = np.arange(round(10.0 * rate)) / rate
    beaten = 0.05 * np.abs(((0.7 * t) % 2.0) - 1.0) / 0.7
    q = record(rate, 2e-5, 0.0) + beaten
    assert position_noise([q], [1.0 / rate]) == pytest.approx(2e-5, rel=0.15)


def test_a_quiet_run_tells_of_the_encoder() -> None:
    """What one run shows beyond the others is how its joint moved: chatter, say."""
    chatter = 1e-3 * np.random.default_rng(1).standard_normal(2000)
    calm = record(200.0, 2e-5, 0.0)
    assert position_noise([calm + chatter, calm, calm[::-1]], [0.005] * 3) == pytest.approx(2e-5, rel=0.15)
    assert position_noise([calm + chatter], [0.005]) > 1e-4


def test_a_rest_does_not_hide_the_noise_of_motion() -> None:
    """At rest a coarse encoder shows one count; most of this record rests."""
    moving = record(500.0, 1e-4, 1e-4)
    q = np.concatenate([moving, np.full(20_000, moving[-1])])
    assert position_noise([q], [0.002], 1e-4) == pytest.approx(1e-4 * np.hypot(1.0, 1.0 / np.sqrt(12.0)), rel=0.1)


def test_runs_of_unlike_rates_have_one_encoder() -> None:
    fine, coarse = record(1000.0, 2e-5, 0.0), record(100.0, 2e-5, 0.0)
    assert position_noise([fine, coarse], [1e-3, 1e-2]) == pytest.approx(2e-5, rel=0.1)


def test_a_run_whose_rests_show_more_noise_has_its_own() -> None:
    """What shows in motion alone may be motion."""
    rng, rate = np.random.default_rng(2), 250.0
    moving, rest = record(rate, 2e-5, 0.0), 2e-5 * rng.standard_normal(4000)
    for q, own in ((moving, 2e-5), (rest, 2e-5), (2.0 * rest, 4e-5), (record(rate, 6e-5, 0.0), 2e-5)):
        run = Run("run", np.arange(len(q)) / rate, q[:, None], np.zeros((len(q), 1)))
        assert noise_of_run(pendulum(), run, np.array([2e-5])) == pytest.approx(own, rel=0.1)


def test_coarse_steps_show_though_the_clock_jitters() -> None:
    """Its record is resampled by splines, whose values lie on no grid."""
    rng, step = np.random.default_rng(4), 2.0 * np.pi / 1024
    t = 0.002 * np.arange(5000)
    late = t + 2e-4 * rng.uniform(-1.0, 1.0, len(t))
    q = step * np.round(np.sin(2.0 * np.pi * 0.4 * late) / step)
    run = Run("jitters", late, q[:, None], np.zeros((len(t), 1)))
    even, notes = uniform(run)
    assert "resampled" in notes[0]
    arm = pendulum()
    assert smallest_step(even.q[:, 0])[0] < 1e-6
    assert encoder_noise(arm, [even], [run])[0] == pytest.approx(step / np.sqrt(12.0), rel=0.15)


def test_smallest_step() -> None:
    assert smallest_step(record(500.0, 0.0, 2e-4))[0] == pytest.approx(2e-4, rel=1e-6)
    assert smallest_step(record(500.0, 1e-4, 0.0)) == (0.0, 0.0)
    assert smallest_step(np.zeros(100)) == (0.0, 0.0)


@pytest.mark.parametrize("rate", [30.0, 500.0, 10_000.0])
def test_a_resolution_that_the_records_are_finer_than_is_told_of(rate: float) -> None:
    """One that they go by is not, however slowly; nor is one of a joint that rests, or no coarser than the noise."""
    step, arm = 6e-6, pendulum()
    t = np.arange(round(20.0 * rate)) / rate
    rest, slow = np.zeros(len(t)), 2e-3 * np.sin(2.0 * np.pi * 0.05 * t)

    def told(stated: float, q: np.ndarray) -> list[str]:
        joint = replace(arm.joints[0], encoder_resolution=stated)
        return doubtful_resolutions(replace(arm, joints=(joint,)), [Run("run", t, q[:, None], np.zeros((len(t), 1)))])

    (said,) = told(1e-3, record(rate, step, step, duration=20.0))
    assert "encoder_resolution is 0.001 rad" in said
    for stated, q in ((1e-3, rest), (1e-4, slow), (1e-3, record(rate, 0.0, 1e-3, duration=20.0))):
        assert not told(stated, stated * np.round(q / stated))
    assert not told(4.0 * step, record(rate, 2.0 * step, step, duration=20.0))
