"""Effects that the records show by themselves."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

from stribeck.effects.sensing.encoder_quantisation import EncoderQuantisation
from stribeck.effects.sensing.velocity_filter import VelocityFilter
from stribeck.model.values import Record

STEP = 2e-3


def record(
    *, step: float = 1e-5, resolution: float | None = 1e-5, lag: float = 0.0, velocity: bool = True, runs: int = 3
) -> Record:
    t = STEP * np.arange(4000)
    rng = np.random.default_rng(3)
    positions, velocities = [], []
    for run in range(runs):
        slow, fast = 1.0 + 0.2 * run, 2.3 + 0.1 * run
        q = np.sin(2 * np.pi * 0.4 * slow * t) + 0.2 * np.sin(2 * np.pi * fast * t)
        dq = np.gradient(q, STEP)
        if lag:
            dq = signal.lsim(([1.0], [lag, 1.0]), dq, t)[1]
        positions.append(step * np.round((q + 0.3 * step * rng.standard_normal(len(q))) / step))
        velocities.append(dq + 0.01 * rng.standard_normal(len(q)))
    return Record(tuple(positions), tuple(velocities) if velocity else (), (STEP,) * runs, resolution)


@pytest.mark.parametrize("resolution", [1e-5, None])
def test_coarse_steps_are_seen(resolution: float | None) -> None:
    seen = EncoderQuantisation().observed(record(step=2e-3, resolution=resolution))
    assert seen is not None
    assert seen.values["resolution"][0] == pytest.approx(2e-3, rel=1e-6)
    assert seen.probability > 0.9


def test_coarse_steps_are_seen_though_the_clock_jitters() -> None:
    """What was resampled lies on no grid."""
    seen = record(step=2e-3)
    smooth = tuple(q + 1e-5 * np.sin(np.arange(len(q))) for q in seen.position)
    assert EncoderQuantisation().observed(replace(seen, position=smooth)) is None
    found = EncoderQuantisation().observed(replace(seen, position=smooth, read=seen.position))
    assert found is not None
    assert found.values["resolution"][0] == pytest.approx(2e-3, rel=1e-6)


@pytest.mark.parametrize(("step", "coarse"), [(1e-3, (False, True)), (2e-5, (False, False)), (2e-3, (True, True))])
def test_what_is_coarse_where_the_file_says_nothing_is_told_of_a_turn_or_of_a_scale(
    step: float, coarse: tuple[bool, bool]
) -> None:
    turning = record(step=step, resolution=None)
    seen = [EncoderQuantisation().observed(one) for one in (turning, replace(turning, prismatic=True))]
    assert tuple(one is not None for one in seen) == coarse


def test_a_joint_that_rests_in_one_recording_is_coarse_in_the_others() -> None:
    seen = record(step=2e-3)
    rests, shakes = np.full(500, 0.4), np.where(np.arange(500) == 200, 0.402, 0.4)
    still = replace(seen, position=(*seen.position, rests, shakes), sample_time=(STEP,) * 5)
    found = EncoderQuantisation().observed(still)
    assert found is not None
    assert found.values["resolution"][0] == pytest.approx(2e-3, rel=1e-6)
    assert EncoderQuantisation().observed(replace(seen, position=(rests,), sample_time=(STEP,))) is None


def test_a_joint_that_is_never_slow_steps_over_many_quanta_at_a_time() -> None:
    """As from side to side at constant speed; printed with six digits."""
    way = signal.sawtooth(2 * np.pi * 0.7137 * STEP * np.arange(4000), 0.5)
    fast = Record((np.round(2e-3 * np.round(8.0 * way / 2e-3), 6),), (), (STEP,), 1e-5)
    seen = EncoderQuantisation().observed(fast)
    assert seen is not None
    value, low, high = seen.values["resolution"]
    assert low <= value <= high
    assert value == pytest.approx(2e-3, rel=1e-3)


def test_a_printed_record_holds_its_step_within_the_interval() -> None:
    true = 2 * np.pi / 2400
    seen = record(step=true)
    printed = replace(seen, position=tuple(np.round(position, 6) for position in seen.position))
    found = EncoderQuantisation().observed(printed)
    assert found is not None
    value, low, high = found.values["resolution"]
    assert low < true < high
    assert high - low < 2e-3 * value


@pytest.mark.parametrize("digits", [6, 9])
def test_so_does_one_that_is_printed_with_significant_digits(digits: int) -> None:
    """As most writers do: near zero they keep more decimals than elsewhere, and no number of these holds for all."""
    true = 2 * np.pi / 2400
    seen = record(step=true)
    printed = replace(seen, position=tuple(significant(position, digits) for position in seen.position))
    found = EncoderQuantisation().observed(printed)
    assert found is not None
    value, low, high = found.values["resolution"]
    assert low < true < high
    assert value == pytest.approx(true, rel=1e-3)


def significant(values: np.ndarray, digits: int) -> np.ndarray:
    """The values as a file holds them."""
    return np.array([float(f"{value:.{digits}g}") for value in values])


@pytest.mark.parametrize("digits", [6, 16])
@pytest.mark.parametrize("sweeps", [1, 5])
def test_constant_speed_is_no_grid(digits: int, sweeps: int) -> None:
    """Every step is a hundred counts of a fine encoder, or one more or less."""
    way = signal.sawtooth(2 * np.pi * sweeps * np.arange(5000) / 5003, 0.5)
    jog = np.round(1e-5 * np.round(2.5 * way / 1e-5), digits)
    assert EncoderQuantisation().observed(Record((jog,), (), (STEP,), 1e-5)) is None


def test_noise_is_no_grid() -> None:
    noise = np.cumsum(np.random.default_rng(0).standard_normal(3000)) * 1e-3
    for record_of_it in (noise, significant(noise, 4), significant(noise, 8)):
        assert EncoderQuantisation().observed(Record((record_of_it,), (), (STEP,), 1e-5)) is None


@pytest.mark.parametrize(
    ("step", "stated", "news"),
    [
        (2e-3, 2e-3, False),
        (2e-3, 1.5e-3, False),
        (2e-3, 1.2e-3, True),
        (1e-4, 1e-5, True),
        (1e-5, 1e-5, False),
        (1e-3, None, False),
    ],
)
def test_steps_that_the_arm_file_states_are_no_news(step: float, stated: float | None, news: bool) -> None:
    assert (EncoderQuantisation().observed(record(step=step, resolution=stated)) is not None) == news


@pytest.mark.parametrize("lag", [0.004, 0.01, 0.05])
def test_lag_of_the_velocity_is_seen(lag: float) -> None:
    seen = VelocityFilter().observed(record(lag=lag))
    assert seen is not None
    value, low, high = seen.values["time"]
    assert low < value < high
    assert value == pytest.approx(lag, rel=0.1)


def test_a_velocity_a_sample_late_is_what_any_drive_gives() -> None:
    assert VelocityFilter().observed(record(lag=STEP)) is None


@pytest.mark.parametrize("samples", [5, 12, 30])
def test_a_moving_average_is_a_filter(samples: int) -> None:
    """It is late by half its width, and damps what is fast, which no late record does."""
    plain = record()
    taps = np.full(samples, 1.0 / samples)
    mean = tuple(signal.lfilter(taps, [1.0], dq, zi=dq[0] * signal.lfilter_zi(taps, [1.0]))[0] for dq in plain.velocity)
    seen = VelocityFilter().observed(Record(plain.position, mean, plain.sample_time, plain.resolution))
    assert seen is not None
    assert seen.values["time"][0] == pytest.approx(0.5 * (samples - 1) * STEP, rel=0.1)


def test_two_poles_are_a_filter() -> None:
    plain = record()
    t = STEP * np.arange(4000)
    twice = tuple(signal.lsim(([1.0], [1e-4, 0.02, 1.0]), dq, t)[1] for dq in plain.velocity)
    seen = VelocityFilter().observed(Record(plain.position, twice, plain.sample_time, plain.resolution))
    assert seen is not None
    assert seen.values["time"][0] == pytest.approx(0.02, rel=0.1)


def test_velocity_without_a_lag_shows_nothing() -> None:
    assert VelocityFilter().observed(record()) is None


@pytest.mark.parametrize("samples", [5, 14])
def test_a_late_velocity_is_no_filter(samples: int) -> None:
    plain = record()
    late = tuple(np.concatenate([np.full(samples, dq[0]), dq[:-samples]]) for dq in plain.velocity)
    assert VelocityFilter().observed(Record(plain.position, late, plain.sample_time, plain.resolution)) is None


def test_in_a_lower_band_a_filter_is_seen_behind_noise() -> None:
    """Neither a late velocity nor one without a lag is told there."""

    def noisy(plain: Record, samples: int = 0) -> Record:
        rng = np.random.default_rng(0)
        late = (np.concatenate([np.full(samples, dq[0]), dq[: len(dq) - samples]]) for dq in plain.velocity)
        return replace(plain, velocity=tuple(dq + 4.0 * rng.standard_normal(len(dq)) for dq in late))

    seen = VelocityFilter().observed(noisy(record(lag=0.04)))
    assert seen is not None
    assert seen.probability > 0.7
    value, low, high = seen.values["time"]
    assert low < 0.04 < high
    assert value == pytest.approx(0.04, rel=0.1)
    assert VelocityFilter().observed(noisy(record())) is None
    assert VelocityFilter().observed(noisy(record(), samples=40)) is None


@pytest.mark.parametrize("step", [1e-3, 0.02, 0.05])
@pytest.mark.parametrize("speed", [0.0, 0.1, 0.5])
def test_at_one_speed_nothing_can_trail(speed: float, step: float) -> None:
    """A joint at rest, or on a ramp: what differs is rounding."""
    t = step * np.arange(400)
    steady = Record((speed * t,), (np.full(len(t), speed),), (step,), 1e-5)
    assert VelocityFilter().observed(steady) is None


@pytest.mark.parametrize("late", [0.0, 0.01])
def test_a_late_velocity_beside_a_coarse_position_is_no_filter(late: float) -> None:
    """A lag would take the noise of the position from its slope, whatever the velocity is."""
    plain = record()
    samples = round(late / STEP)
    seen = tuple(np.concatenate([np.full(samples, dq[0]), dq[: len(dq) - samples]]) for dq in plain.velocity)
    for step in (4e-4, 1.5e-3):
        rough = tuple(step * np.round(q / step) for q in plain.position)
        assert VelocityFilter().observed(replace(plain, position=rough, velocity=seen)) is None
    noisy = tuple(q + 5e-4 * np.random.default_rng(1).standard_normal(len(q)) for q in plain.position)
    assert VelocityFilter().observed(replace(plain, position=noisy, velocity=seen)) is None


def test_a_butterworth_is_a_filter() -> None:
    plain, lag = record(), 0.03
    low_pass = signal.butter(2, np.sqrt(2.0) / (2.0 * np.pi * lag), fs=1.0 / STEP)
    seen = tuple(signal.lfilter(*low_pass, dq, zi=signal.lfilter_zi(*low_pass) * dq[0])[0] for dq in plain.velocity)
    found = VelocityFilter().observed(replace(plain, velocity=seen))
    assert found is not None
    assert found.values["time"][0] == pytest.approx(lag, rel=0.05)


SLOW = 0.01  # s, a sample of a logger that keeps every fifth


def slowly(velocity: tuple[np.ndarray, ...], plain: Record) -> Record:
    every = round(SLOW / STEP)
    position, velocity = (tuple(v[::every] for v in values) for values in (plain.position, velocity))
    return Record(position, velocity, (SLOW,) * len(position), None)


def test_a_filter_faster_than_a_sample_is_seen() -> None:
    """By what it damps: it is hardly later than a difference of two positions, half a sample."""
    plain = record(lag=0.4 * SLOW)
    seen = VelocityFilter().observed(slowly(plain.velocity, plain))
    assert seen is not None
    assert seen.values["time"][0] == pytest.approx(0.4 * SLOW, rel=0.1)


def test_a_difference_of_two_positions_is_no_filter() -> None:
    plain = record()
    back = round(SLOW / STEP)
    quotient = tuple(np.concatenate([np.zeros(back), q[back:] - q[:-back]]) / SLOW for q in plain.position)
    assert VelocityFilter().observed(slowly(quotient, plain)) is None


def test_a_run_that_hardly_moves_does_not_widen_the_interval() -> None:
    busy, idle = record(lag=0.02), record(lag=0.02)
    still = tuple(1e-3 * q for q in idle.position[:1])
    noise = tuple(1e-3 * np.random.default_rng(1).standard_normal(len(q)) for q in still)
    seen = VelocityFilter().observed(Record(busy.position + still, busy.velocity + noise, (STEP,) * 4, 1e-5))
    assert seen is not None
    value, low, high = seen.values["time"]
    assert value == pytest.approx(0.02, rel=0.03)
    assert high - low < 0.2 * value


def test_without_a_velocity_nothing_can_be_seen() -> None:
    assert VelocityFilter().observed(record(lag=0.05, velocity=False)) is None


def test_steps_of_more_than_a_radian_are_counts_and_no_encoder() -> None:
    """No arm file could state such a one."""
    assert EncoderQuantisation().observed(record(step=1.5, resolution=None)) is None
