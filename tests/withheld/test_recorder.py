"""The laboratory: its controller, its motions, its arms."""

from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import load_arm, save_arm
from stribeck.errors import StribeckError
from stribeck.withheld import Motion, default_gains, record
from stribeck.withheld.arms import misinformed, random_arm
from stribeck.withheld.excitation import KINDS, SHARE, needed_torque, programme
from stribeck.withheld.motions import hold, multisine, sweep
from stribeck.withheld.recorder import SETTLE


def swing(seconds=2.0):
    a = multisine(np.array([0.3, 0.1]), np.array([0.5, 1.5]), np.array([0.1, 2.0]), 0.2, seconds, 0.3)
    return Motion("swing", seconds, (a, hold(-0.1)))


def test_command_is_the_controllers_law_on_what_it_sees(bench):
    """Recomputed from the recorded encoder: PID on the error, velocity from filtered differences, held at the limit."""
    arm = bench.two_link()
    arm = replace(arm, joints=(replace(arm.joints[0], torque_limit=9.0), arm.joints[1]))
    gains = replace(default_gains(arm, 3.0, forward="none"), velocity_filter=0.004)
    # a motion that rests first, so that the state of the controller at the start of the record is known
    rest = 0.5
    moving = swing()
    curve = moving.curves[0]

    def late(t):
        q, dq, ddq = curve(np.maximum(t - rest, 0.0))
        return q, np.where(t > rest, dq, 0.0), np.where(t > rest, ddq, 0.0)

    motion = Motion("rest and swing", rest + 2.0, (late, hold(-0.1)))
    (run,) = record(arm, [], [motion], rate=400.0, encoder_bits=16, gains=gains, channels=("q_ref", "dq_ref"))
    for k, limit in ((0, 9.0), (1, 60.0)):
        keep, rate, total, seen = np.exp(-1 / 400.0 / 0.004), 0.0, 0.0, run.q[0, k]
        total = (SETTLE * 400.0 + 0.0) / 400.0 * (run.q_ref[0, k] - run.q[0, k])
        for i, q in enumerate(run.q[:, k]):
            rate = keep * rate + (1 - keep) * (q - seen) * 400.0
            seen, error = q, run.q_ref[i, k] - q
            u = gains.kp[k] * error + gains.kd[k] * (run.dq_ref[i, k] - rate) + gains.ki[k] * (total + error / 400.0)
            if abs(u) <= limit:
                total += error / 400.0
            assert run.tau[i, k] == pytest.approx(np.clip(u, -limit, limit), abs=1e-9)
    assert np.abs(run.tau[:, 0]).max() == 9.0


def test_record_has_the_channels_the_clock_and_the_encoder_asked_for(bench):
    channels = ("dq", "q_ref", "dq_ref", "tau_meas")
    (run,) = record(bench.two_link(), [], [swing()], rate=250.0, encoder_bits=14, channels=channels, torque_noise=0.1)
    assert run.t == pytest.approx(np.arange(501) / 250.0)
    counts = run.q / (2 * np.pi / 2**14)
    assert counts == pytest.approx(np.round(counts), abs=1e-9)
    assert all(getattr(run, c).shape == (501, 2) for c in channels)
    assert (run.tau_meas[1:] - run.tau[:-1]).std() == pytest.approx(0.1, rel=0.1)
    assert np.abs(run.dq[:, 0] - np.gradient(run.q[:, 0], run.t)).mean() < 0.05
    (bare,) = record(bench.two_link(), [], [swing()], rate=250.0)
    assert bare.dq is None
    assert bare.q_ref is None
    with pytest.raises(StribeckError, match="no such channel"):
        record(bench.two_link(), [], [swing()], rate=250.0, channels=("speed",))


def test_encoder_noise_has_its_size(bench):
    still = Motion("still", 2.0, (hold(0.3), hold(0.1)))
    (run,) = record(bench.two_link(), [], [still], rate=500.0, noise=2e-4)
    assert run.q[:, 0].std() == pytest.approx(2e-4, rel=0.1)


def test_wrong_model_in_the_feedforward_makes_the_arm_sag(bench):
    arm = bench.two_link((9.81, 0.0), rough=False)
    heavy = replace(arm, joints=tuple(replace(j, mass=1.3 * j.mass) for j in arm.joints))
    still = Motion("still", 2.0, (hold(0.9), hold(0.3)))
    gains = default_gains(arm, 3.0, integral=0.0)
    (right,) = record(arm, [], [still], rate=500.0, gains=gains)
    (wrong,) = record(arm, [], [still], rate=500.0, gains=gains, model=heavy)
    assert np.abs(right.q[-1] - [0.9, 0.3]).max() < 1e-6
    assert wrong.q[-1, 0] - 0.9 > 0.005


def test_too_many_joints_are_refused(bench):
    arm = bench.two_link()
    five = replace(arm, joints=tuple(replace(arm.joints[0], name=n) for n in "ABCDE"))
    with pytest.raises(StribeckError, match="at most 4"):
        record(five, [], [Motion("still", 1.0, (hold(0.0),) * 5)], rate=100.0)


@pytest.mark.parametrize("kind", KINDS)
def test_motions_are_smooth_start_and_end_at_rest_and_stay_within_the_torque(kind):
    rng = np.random.default_rng(8)
    arm = random_arm(rng, 2, vertical=True)
    (motion,) = programme(arm, rng, [kind], 8.0)
    t = np.linspace(0.0, 8.0, 40001)
    q, dq, ddq = motion.sample(t)
    assert np.abs(np.gradient(q, t, axis=0) - dq)[1:-1].max() < 0.02 * np.abs(dq).max()
    inner = np.abs(np.gradient(dq, t, axis=0) - ddq)[1:-1]
    assert np.median(inner) < 1e-3 * np.abs(ddq).max()  # acceleration may jump, at knots
    assert np.abs(dq[[0, -1]]).max() < 1e-9
    assert np.all(np.ptp(q, axis=0) > 0.01)
    assert np.all(np.ptp(q, axis=0) < 4.0)
    limits = [joint.torque_limit for joint in arm.joints]
    assert np.all(np.abs(needed_torque(arm, q, dq, ddq)) <= SHARE * np.array(limits) * 1.02)
    before, after = motion.sample(np.array([-1.0, 9.0]))[0]
    assert np.array_equal(before, q[0])
    assert np.array_equal(after, q[-1])


def test_sweep_ends_at_its_highest_frequency():
    t = np.linspace(0.0, 10.0, 100001)
    q, dq, _ = sweep(0.5, 0.2, 4.0, 0.0, 10.0, fade=0.1)(t)
    up = t[1:][(q[:-1] < 0) & (q[1:] >= 0)]
    assert 1.0 / (up[-2] - up[-3]) == pytest.approx(4.0, rel=0.15)
    assert np.abs(dq[5000:95000]).max() == pytest.approx(0.5 * 2 * np.pi * 0.2, rel=0.03)


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_random_arms_are_sound_and_of_every_size(tmp_path, n):
    limits = []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        arm = random_arm(rng, n, vertical=seed % 2 == 1)
        save_arm(arm, tmp_path / "arm.toml")
        assert load_arm(tmp_path / "arm.toml") == arm
        for joint in arm.joints:
            f = joint.friction
            assert f.C2 * f.alpha < f.C1  # the curve bends down at low speed
            assert 0.02 <= f.C0 / joint.torque_limit <= 0.08 * 1.001
        limits.append(arm.joints[0].torque_limit)
    assert max(limits) / min(limits) > 50.0


def test_a_data_sheet_is_off_by_no_more_than_two_deviations():
    arm = random_arm(np.random.default_rng(0), 3)
    ratios = []
    for seed in range(60):
        nominal = misinformed(arm, np.random.default_rng(seed), 0.1, 0.2)
        assert nominal.tolerance.inertial == 0.1
        assert nominal.tolerance.friction == 0.2
        for true, told in zip(arm.joints, nominal.joints, strict=True):
            assert told.length == true.length
            ratios.append([np.log(told.mass / true.mass) / 0.1, np.log(told.friction.C0 / true.friction.C0) / 0.2])
            assert told.friction == told.backward
    assert np.abs(ratios).max() < 2.02
    assert np.std(ratios, axis=0) == pytest.approx([0.96, 0.96], rel=0.15)
