"""Each effect: absent at its null value, present otherwise, and showing what it is known for."""

import math
from dataclasses import replace

import numpy as np
import pytest

from stribeck.errors import StribeckError
from stribeck.withheld import KNOWN, UNKNOWN, Injection, Motion, null, record
from stribeck.withheld.example import true_arm
from stribeck.withheld.injections import assemble
from stribeck.withheld.motions import multisine
from stribeck.withheld.plant import rigid_torque

PRESENT = {
    "asymmetric_friction": {"C0": 0.8},
    "negative_damping": {"amount": 1.0},
    "presliding": {"stiffness": 1500.0, "damping": 5.0},
    "frictional_lag": {"time": 0.02},
    "dwell_time": {"rise": 2.0},
    "history": {"change": -0.3},
    "position_dependent_friction": {"amplitude": 1.0, "harmonic": 2.0},
    "load_dependent_friction": {"ratio": 0.1},
    "quadratic_damping": {"coefficient": 0.3},
    "actuator_lag": {"time": 0.01},
    "delay": {"time": 0.0053},
    "torque_gain": {"gain": 0.9},
    "torque_offset": {"offset": 0.4},
    "torque_saturation": {"limit": 6.0},
    "torque_dead_zone": {"width": 0.5},
    "cogging": {"amplitude": 0.5},
    "torque_ripple": {"ratio": 0.1},
    "joint_flexibility": {"stiffness": 800.0},
    "backlash": {"gap": 0.01},
    "encoder_eccentricity": {"amplitude": 0.01},
    "encoder_offset": {"offset": 0.05},
    "encoder_quantisation": {"resolution": 0.005},
    "velocity_filter": {"time": 0.02},
    "time_shift": {"time": 0.007},
    "payload": {"mass": 0.5},
    "gravity_tilt": {"x": 0.5, "y": 0.2},
    "base_flexibility": {"stiffness": 2000.0},
    "cable_spring": {"stiffness": 2.0},
    "contact": {"stiffness": 500.0, "position": 0.1},
    "input_disturbance": {"noise": 0.5, "amplitude": 0.5},
    "supply_bang": {"torque": 0.5},
    "loaded_sticky_spot": {"torque": 1.5},
    "friction_jumps": {"change": 0.3},
    "tendon_coupling": {"stiffness": 5.0},
    "hardening_gain": {"change": 0.2},
    "sloshing_mass": {"mass": 0.8},
}


def motion(seconds=1.5):
    rng = np.random.default_rng(5)
    tones = np.array([0.7, 1.1, 1.9, 2.7])
    sizes = [(rng.uniform(0.05, 0.2, 4), rng.uniform(0, 6, 4)) for _ in range(2)]
    return Motion("multisine", seconds, tuple(multisine(a, tones, b, 0.1, seconds, 0.3) for a, b in sizes))


def recorded(arm, effects=(), **changes):
    settings = {"rate": 500.0, "encoder_bits": 17, "noise": 1e-5, "channels": ("dq", "tau_meas"), "seed": 4, **changes}
    return record(arm, effects, [motion()], **settings)[0]


@pytest.fixture(scope="module")
def untouched():
    cache = {}

    def run(arm):
        if arm not in cache:
            cache[arm] = recorded(arm)
        return cache[arm]

    return run


def test_every_effect_is_tried():
    assert set(PRESENT) == set(KNOWN) | set(UNKNOWN)


PLACES = [  # fast in one joint, A and B in turn
    pytest.param(effect, joint, marks=[] if (i + j) % 2 else pytest.mark.slow)
    for i, effect in enumerate(PRESENT)
    for j, joint in enumerate("AB")
]


@pytest.mark.parametrize(("effect", "joint"), PLACES)
def test_null_value_changes_nothing_and_a_value_does(bench, untouched, effect, joint):
    arm = bench.two_link((9.81, 0.0))
    plain, absent = untouched(arm), recorded(arm, [null(effect, joint)])
    assert np.array_equal(plain.q, absent.q)
    assert np.array_equal(plain.tau, absent.tau)
    assert np.array_equal(plain.dq, absent.dq)
    hidden = recorded(arm, [Injection(effect, joint, PRESENT[effect])])
    channel, least = {"velocity_filter": ("dq", 0.02), "time_shift": ("q", 2e-3)}.get(effect, ("tau", 0.02))
    assert np.abs(getattr(hidden, channel) - getattr(plain, channel)).max() > least
    assert np.abs(hidden.tau).max() < 200.0


def test_same_seed_same_numbers_and_other_seed_other_noise(bench):
    arm = bench.two_link()
    a, b, c = recorded(arm), recorded(arm), recorded(arm, seed=5)
    assert a.q.tobytes() == b.q.tobytes()
    assert a.tau.tobytes() == b.tau.tobytes()
    assert not np.array_equal(a.q, c.q)


def test_an_effect_leaves_the_other_random_numbers_alone(bench):
    arm = bench.two_link()
    base = [Injection("input_disturbance", "A", {"noise": 0.5, "amplitude": 0.0})]
    more = [*base, Injection("friction_jumps", "B", {"change": 0.0})]
    assert np.array_equal(recorded(arm, base).q, recorded(arm, more).q)


@pytest.mark.parametrize(
    ("injection", "says"),
    [
        (("gremlin", "A", {}), "no such effect"),
        (("delay", "Z", {"time": 0.1}), "no such joint"),
        (("delay", "A", {"tim": 0.1}), "no such parameter"),
        (("delay", "A", {}), "needs the parameter time"),
        (("asymmetric_friction", "A", {"C0": 20.0}), "negative"),
    ],
)
def test_wrong_injections_are_refused(bench, injection, says):
    with pytest.raises(StribeckError, match=says):
        recorded(bench.two_link(), [injection])


def free(bench, effects, torque, duration=1.0, rate=1000.0, **changes):
    """A frictionless joint under a torque (N,) -> (N,)."""
    arm = bench.one_link(**changes)
    return bench.open_loop(arm, lambda t: torque(t)[:, None], duration, tuple(effects), rate=rate)


def test_delay_shifts_by_its_time_also_between_samples(bench):
    swing = lambda t: np.where(t > 0.1, np.sin(9 * t), 0.0)  # noqa: E731
    t, late = free(bench, [Injection("delay", "A", {"time": 0.00237})], swing)
    held = free(bench, [], swing)[1]
    shifted = np.interp(t - 0.00237, t, held.link[:, 0])
    assert np.abs(late.link[:, 0] - shifted).max() < 3e-6
    assert np.abs(late.link[:, 0] - held.link[:, 0]).max() > 1e-4


def test_lag_rises_like_a_first_order_system(bench):
    t, trace = free(bench, [Injection("actuator_lag", "A", {"time": 0.05})], lambda t: np.where(t > 0.0, 2.0, 0.0))
    expected = 2.0 * (1.0 - np.exp(-(t - 1e-3) / 0.05))
    assert trace.torque[5:, 0] == pytest.approx(expected[5:], abs=2.0 * 2e-5 / 0.05)


@pytest.mark.parametrize(
    ("effect", "params", "law"),
    [
        ("torque_gain", {"gain": 0.8}, lambda u: 0.8 * u),
        ("torque_offset", {"offset": 0.3}, lambda u: u + 0.3),
        ("torque_saturation", {"limit": 1.2}, lambda u: np.clip(u, -1.2, 1.2)),
        ("torque_dead_zone", {"width": 0.4}, lambda u: np.sign(u) * np.maximum(np.abs(u) - 0.4, 0.0)),
        ("torque_dead_zone", {"width": 0.4, "jump": 1.0}, lambda u: np.where(np.abs(u) > 0.4, u, 0.0)),
        ("hardening_gain", {"change": 0.2, "torque": 2.0}, lambda u: u * (1 + 0.2 * (u / 2.0) ** 2)),
    ],
)
def test_drive_laws(bench, effect, params, law):
    _, trace = free(bench, [Injection(effect, "A", params)], lambda t: 2.0 * np.sin(20 * t))
    assert trace.torque[1:, 0] == pytest.approx(law(trace.tau[:-1, 0]), abs=1e-12)


def test_what_speed_takes_of_the_voltage_a_driving_motor_has_no_more(bench):
    params = {"limit": 1.2, "fade": 0.08}
    _, trace = free(bench, [Injection("torque_saturation", "A", params)], lambda t: 2.0 * np.sin(6.0 * t), 2.0)
    u, speed = trace.tau[:-1, 0], trace.dq[1:, 0]
    limit = np.where(u * speed > 0.0, 1.2 * np.maximum(0.0, 1.0 - 0.08 * np.abs(speed)), 1.2)
    assert np.ptp(limit) > 0.3
    firm = np.abs(speed) > 0.1  # where it turns about, it drives and brakes within a sample
    expected = np.clip(u, -limit, limit)
    assert trace.torque[1:, 0][firm] == pytest.approx(expected[firm], abs=2e-3)


def test_cogging_and_ripple_follow_the_angle(bench):
    heavy = {"inertia": 50.0}
    params = {"harmonic": 7.0, "phase": 0.4}
    start = ((0.0, 3.0),)
    arm = bench.one_link(**heavy)
    for effect, size, u in (("cogging", {"amplitude": 0.6}, 0.0), ("torque_ripple", {"ratio": 0.2}, 3.0)):
        hidden = (Injection(effect, "A", {**params, **size}),)
        _, trace = bench.open_loop(arm, lambda t, u=u: np.full((len(t), 1), u), 1.0, hidden, start)
        wave = np.sin(7.0 * (trace.motor[1:, 0] - 3.0 * 2e-5) + 0.4)
        expected = 0.6 * wave if effect == "cogging" else u * (1.0 + 0.2 * wave)
        assert trace.torque[1:, 0] == pytest.approx(expected, abs=1e-3)


def test_flexible_joint_rings_at_the_frequency_of_two_inertias(bench):
    hidden = [Injection("joint_flexibility", "A", {"stiffness": 300.0, "damping": 0.0})]
    t, trace = free(bench, hidden, lambda t: np.where(t < 0.005, 5.0, 0.0), 2.0)
    link, rotor = 0.01 + 1.0 * 0.25**2, 0.02
    twist = trace.motor[10:, 0] - trace.link[10:, 0]
    up = np.flatnonzero((twist[:-1] < 0) & (twist[1:] >= 0))
    cross = t[10:][up] - twist[up] / (twist[up + 1] - twist[up]) * 1e-3
    period = np.diff(cross).mean()
    assert 2 * math.pi / period == pytest.approx(math.sqrt(300.0 * (1 / link + 1 / rotor)), rel=1e-3)
    assert np.abs(twist[-300:]).max() == pytest.approx(np.abs(twist[:300]).max(), rel=0.02)  # undamped stays undamped
    speed = (rotor * trace.motor_rate[-1, 0] + link * trace.link_rate[-1, 0]) / (rotor + link)
    assert speed == pytest.approx(5.0 * 0.005 / (rotor + link), rel=1e-6)


def test_backlash_loses_its_gap_at_a_reversal(bench):
    arm = bench.one_link((9.81, 0.0), friction=bench.SMOOTH)
    hidden = [Injection("backlash", "A", {"gap": 0.02})]
    _, trace = bench.open_loop(arm, lambda t: 3.0 * np.sin(4 * t)[:, None], 3.0, tuple(hidden))
    twist = trace.motor[:, 0] - trace.link[:, 0]
    stiffness = 0.02 * (2 * math.pi * 100) ** 2
    assert np.abs(twist).max() <= 0.01 + 1.1 * np.abs(trace.load).max() / stiffness
    touching = np.abs(trace.load[:, 0]) > 0.3
    assert np.mean(np.abs(twist[touching]) > 0.0098) > 0.99
    assert twist.max() > 0.0099
    assert twist.min() < -0.0099
    push = trace.load[:, 0] * twist
    assert np.all(push >= -1e-6)  # flanks never pull


def test_a_play_on_a_soft_shaft_keeps_it():
    """In whatever order they are put there."""
    shaft, play = Injection("joint_flexibility", "A", {"stiffness": 800.0}), Injection("backlash", "A", {"gap": 0.02})
    both = [assemble(true_arm(), order).plant for order in ((shaft, play), (play, shaft))]
    assert [plant.get(0, "stiffness") for plant in both] == [800.0, 800.0]
    assert [plant.get(0, "gap") for plant in both] == [0.02, 0.02]


def test_sensing_effects(bench):
    arm = bench.one_link(inertia=5.0)
    spin = ((0.2, 2.0),)

    def seen(effect, params, **kw):
        return bench.open_loop(
            arm, lambda t: np.sin(9 * t)[:, None], 2.0, (Injection(effect, "A", params),), spin, **kw
        )

    _, trace = seen("encoder_eccentricity", {"amplitude": 0.02, "harmonic": 2.0, "phase": 0.3})
    assert trace.q == pytest.approx(trace.motor + 0.02 * np.sin(2 * trace.motor + 0.3), abs=1e-12)
    oval = {"amplitude": 0.02, "phase": 0.3, "overtone": 0.01, "overtone_phase": -0.4}
    _, trace = seen("encoder_eccentricity", oval)
    expected = trace.motor + 0.02 * np.sin(trace.motor + 0.3) + 0.01 * np.sin(2 * trace.motor - 0.4)
    assert trace.q == pytest.approx(expected, abs=1e-12)
    _, trace = seen("encoder_offset", {"offset": 0.07})
    assert trace.q - trace.motor == pytest.approx(0.07, abs=1e-12)
    _, trace = seen("encoder_quantisation", {"resolution": 0.01})
    assert np.abs(trace.q - trace.motor).max() <= 0.005 + 1e-12
    assert trace.q / 0.01 == pytest.approx(np.round(trace.q / 0.01), abs=1e-9)
    for shift in (0.0123, -0.0061):
        t, trace = seen("time_shift", {"time": shift})
        inside = slice(20, -20)
        assert trace.q[inside, 0] == pytest.approx(np.interp(t - shift, t, trace.motor[:, 0])[inside], abs=2e-6)
    t, trace = seen("velocity_filter", {"time": 0.1})
    late = np.interp(t, t, trace.motor_rate[:, 0])
    state = [2.0]
    for v in late[1:]:
        state.append(state[-1] + (v - state[-1]) * 1e-3 / 0.1)
    assert trace.dq[:, 0] == pytest.approx(state, abs=2e-3)
    assert np.abs(trace.dq - trace.motor_rate).max() > 5e-3


def test_payload_acts_as_a_body_at_the_tip(bench):
    arm = bench.two_link((9.81, 0.0), rough=False)
    b = arm.joints[1]
    heavy = replace(arm, joints=(arm.joints[0], replace(b, mass=1e-9 + 1.5, com=(0.3, 0.0), inertia=0.02)))
    hidden = (Injection("payload", "B", {"mass": 1.5, "inertia": 0.02}),)
    start = ((0.5, 0.3), (0.9, -0.4))
    _, trace = bench.open_loop(arm, lambda t: np.zeros((len(t), 2)), 0.3, hidden, start, rate=10000.0)
    q, w = trace.link[1500:1501], trace.link_rate[1500:1501]
    acceleration = (trace.link_rate[1501] - trace.link_rate[1499])[None] * 5000.0
    # the torques of arm and body add; rotor and first link are counted once
    massless = replace(heavy, joints=(replace(arm.joints[0], mass=1e-12, inertia=0.0, rotor_inertia=0.0),
                                      replace(heavy.joints[1], mass=1.5, rotor_inertia=0.0)))  # fmt: skip
    total = rigid_torque(arm, q, w, acceleration) + rigid_torque(massless, q, w, acceleration)
    assert total == pytest.approx(np.zeros((1, 2)), abs=2e-3)


def test_gravity_tilt_pulls_like_gravity(bench):
    flat, tilted = bench.two_link(rough=False), bench.two_link((1.5, -0.8), rough=False)
    still = lambda t: np.zeros((len(t), 2))  # noqa: E731
    _, a = bench.open_loop(flat, still, 1.0, (Injection("gravity_tilt", "A", {"x": 1.5, "y": -0.8}),))
    _, b = bench.open_loop(tilted, still, 1.0)
    assert np.array_equal(a.link, b.link)
    assert np.abs(a.link).max() > 0.1


def test_soft_base_swings_with_the_stuck_arm_on_it(bench):
    arm = bench.two_link()
    hidden = (Injection("base_flexibility", "A", {"stiffness": 900.0, "damping": 0.0, "inertia": 0.8}),)
    kick = lambda t: np.stack([np.where(t < 0.03, 12.0, 0.0), 0 * t], axis=1)  # noqa: E731
    _, trace = bench.open_loop(arm, kick, 3.0, hidden)
    assert np.all(trace.link_rate[-500:] == 0.0)
    rigid = replace(arm, joints=tuple(replace(j, rotor_inertia=0.0) for j in arm.joints))
    pose = trace.link[-1:]
    inertia = 0.8 + rigid_torque(rigid, pose, 0 * pose, np.array([[1.0, 0.0]]))[0, 0]
    holding = trace.friction[-1000:, 0]  # friction carries the swinging arm
    up = np.flatnonzero((holding[:-1] < 0) & (holding[1:] >= 0))
    cross = up - holding[up] / (holding[up + 1] - holding[up])
    assert 2 * math.pi / (np.diff(cross).mean() * 1e-3) == pytest.approx(math.sqrt(900.0 / inertia), rel=2e-3)


def test_a_sliding_base_swings_with_the_stuck_arm_on_it(bench):
    arm = bench.two_link()
    params = {"stiffness": 4000.0, "damping": 0.0, "mass": 3.0, "direction": 0.4}
    kick = lambda t: np.stack([np.where(t < 0.03, 12.0, 0.0), 0 * t], axis=1)  # noqa: E731
    _, trace = bench.open_loop(arm, kick, 3.0, (Injection("base_flexibility", "A", params),), ((1.9, 0.0), (0.3, 0.0)))
    assert np.all(trace.link_rate[-500:] == 0.0)
    holding = trace.friction[-1000:]
    up = np.flatnonzero((holding[:-1, 0] < 0) & (holding[1:, 0] >= 0))
    cross = up - holding[up, 0] / (holding[up + 1, 0] - holding[up, 0])
    whole = 3.0 + sum(joint.mass for joint in arm.joints)
    assert 2 * math.pi / (np.diff(cross).mean() * 1e-3) == pytest.approx(math.sqrt(4000.0 / whole), rel=2e-3)
    # the base's acceleration is felt as gravity along its way is
    pulled = replace(arm, gravity=(math.cos(0.4), math.sin(0.4)))
    felt = rigid_torque(pulled, trace.link[-1:], 0 * trace.link[-1:], 0 * trace.link[-1:])[0]
    assert holding[:, 1] / holding[:, 0] == pytest.approx(felt[1] / felt[0], rel=1e-6)


def test_cable_is_a_spring(bench):
    arm = bench.one_link()
    hidden = (Injection("cable_spring", "A", {"stiffness": 3.0, "rest": 0.4}),)
    t, trace = bench.open_loop(arm, lambda t: np.zeros((len(t), 1)), 4.0, hidden)
    omega = math.sqrt(3.0 / (0.01 + 0.02 + 0.0625))
    assert trace.link[:, 0] == pytest.approx(0.4 - 0.4 * np.cos(omega * t), abs=1e-5)


def test_a_stiffening_cable_swings_as_its_energy_says(bench):
    arm = bench.one_link()
    hidden = (Injection("cable_spring", "A", {"stiffness": 1.0, "rest": 0.4, "cubic": 20.0}),)
    _, trace = bench.open_loop(arm, lambda t: np.zeros((len(t), 1)), 4.0, hidden)
    away = trace.link[:, 0] - 0.4
    energy = 0.5 * 0.0925 * trace.link_rate[:, 0] ** 2 + 0.5 * away**2 + 0.25 * 20.0 * away**4
    assert away.max() == pytest.approx(0.4, abs=1e-3)
    assert energy == pytest.approx(energy[0], rel=1e-3)


def test_wall_pushes_back_and_takes_energy(bench):
    arm = bench.one_link()
    start = ((0.0, 1.0),)
    params = {"stiffness": 3000.0, "position": 0.2, "side": 1.0}
    still = lambda t: np.zeros((len(t), 1))  # noqa: E731
    back = []
    for damping in (0.0, 0.5):
        _, trace = bench.open_loop(arm, still, 1.0, (Injection("contact", "A", {**params, "damping": damping}),), start)
        back.append(-trace.link_rate[-1, 0])
        inertia = 0.01 + 0.02 + 0.0625
        if damping == 0.0:
            depth = (0.5 * inertia * 1.0**2 * 2.5 / 3000.0) ** 0.4
            assert trace.link.max() - 0.2 == pytest.approx(depth, rel=2e-3)
    assert back[0] == pytest.approx(1.0, abs=1e-3)
    assert 0.5 < back[1] < 0.9


def test_a_wall_in_the_plane_stops_the_tip_and_gives_its_energy_back(bench):
    arm, start = bench.two_link(rough=False), ((0.2, 1.0), (0.3, -0.5))
    still = lambda t: np.zeros((len(t), 2))  # noqa: E731
    plane = {"stiffness": 20000.0, "direction": 0.7, "position": 0.62, "exponent": 1.5}

    def energy(trace):
        stand = np.zeros_like(trace.link)
        units = [rigid_torque(arm, trace.link, stand, stand + unit) for unit in np.eye(2)]
        mass = np.stack(units, axis=2)
        return 0.5 * np.einsum("ti,tij,tj->t", trace.link_rate, mass, trace.link_rate)

    lost = []
    for damping in (0.0, 0.6):
        hidden = (Injection("contact", "A", {**plane, "damping": damping}),)
        _, trace = bench.open_loop(arm, still, 2.0, hidden, start)
        angle = np.cumsum(trace.link, axis=1)
        depth = 0.35 * np.cos(angle[:, 0] - 0.7) + 0.30 * np.cos(angle[:, 1] - 0.7) - 0.62
        moving = energy(trace)
        lost.append(moving[-1] / moving[0])
        assert depth[0] < 0.0
        assert 1e-3 < depth.max() < 0.02
        assert depth[-1] < 0.0
        if damping == 0.0:
            pressed = np.maximum(depth, 0.0) ** 2.5 * 20000.0 / 2.5
            assert moving + pressed == pytest.approx(moving[0], rel=2e-3)
    assert lost[0] == pytest.approx(1.0, abs=2e-3)
    assert 0.5 < lost[1] < 0.98


def test_a_wall_stands_where_it_does_on_a_firm_base_and_on_one_that_hardly_tilts(bench):
    arm, start = bench.two_link(rough=False), ((0.2, 1.0), (0.3, -0.5))
    still = lambda t: np.zeros((len(t), 2))  # noqa: E731
    wall = Injection("contact", "A", {"stiffness": 20000.0, "direction": 0.7, "position": 0.62, "exponent": 1.5})
    stiff = {"stiffness": 1e7, "damping": 1e3, "inertia": 1.0, "foot_x": 0.1, "foot_y": -0.4}
    ways = ((), (wall,), (wall, Injection("base_flexibility", "A", stiff)))
    free, firm, tilting = (bench.open_loop(arm, still, 1.0, hidden, start)[1].link for hidden in ways)
    assert np.abs(free - firm).max() > 0.1
    np.testing.assert_allclose(tilting, firm, rtol=0, atol=2e-3)


def test_disturbance_has_its_size_and_colour():
    from stribeck.withheld.special import Disturbance

    t = np.arange(150000) * 1e-3
    params = {"noise": 0.7, "bandwidth": 10.0, "amplitude": 0.0, "frequency": 3.0, "phase": 0.0, "duty": 0.0}
    x = Disturbance("torque", params).signal(t, np.random.default_rng(0))
    assert x.std() == pytest.approx(0.7, rel=0.05)
    lag = 16
    assert np.mean(x[lag:] * x[:-lag]) / x.var() == pytest.approx(math.exp(-2 * math.pi * 10.0 * 0.016), abs=0.05)
    pure = Disturbance("torque", {**params, "noise": 0.0, "amplitude": 2.0}).signal(t, np.random.default_rng(0))
    np.testing.assert_allclose(pure, 2.0 * np.sin(2 * math.pi * 3.0 * t), rtol=1e-6, atol=1e-12)
    pulses = {**params, "noise": 0.0, "amplitude": 2.0, "duty": 0.25}
    x = Disturbance("torque", pulses).signal(t[:90000], np.random.default_rng(0))  # whole periods
    assert sorted(set(x)) == pytest.approx([-0.5, 1.5])
    assert x.mean() == pytest.approx(0.0, abs=2e-3)


def test_tendon_pulls_on_both_joints_and_keeps_the_energy(bench):
    arm = bench.two_link(rough=False)
    hidden = (Injection("tendon_coupling", "A", {"stiffness": 20.0, "ratio": 0.7, "slack": 0.1}),)
    start = ((0.4, 0.0), (-0.5, 0.0))
    _, trace = bench.open_loop(arm, lambda t: np.zeros((len(t), 2)), 3.0, hidden, start)
    stretch = np.maximum(0.0, trace.link[:, 0] - 0.7 * trace.link[:, 1] - 0.1)
    kinetic = 0.5 * np.sum(rigid_torque(arm, trace.link, 0 * trace.link, trace.link_rate) * trace.link_rate, axis=1)
    energy = kinetic + 0.5 * 20.0 * stretch**2
    assert energy == pytest.approx(energy[0], rel=1e-4)
    assert stretch.min() == 0.0  # it goes slack
    assert kinetic.max() > 0.5 * energy[0]


def test_sloshing_mass_on_a_stiff_spring_is_the_link_it_was_taken_from(bench):
    arm = bench.two_link((9.81, 0.0), rough=False)
    start = ((0.5, 0.3), (0.9, -0.4))
    still = lambda t: np.zeros((len(t), 2))  # noqa: E731
    _, plain = bench.open_loop(arm, still, 1.0, start=start)
    stiff = {"mass": 0.8, "stiffness": 3e4, "damping": 3.0}
    _, frozen = bench.open_loop(arm, still, 1.0, (Injection("sloshing_mass", "B", stiff),), start)
    _, loose = bench.open_loop(arm, still, 1.0, (Injection("sloshing_mass", "B", {"mass": 0.8}),), start)
    assert np.abs(frozen.link - plain.link).max() < 2e-3
    assert np.abs(loose.link - plain.link).max() > 2e-2


def test_drives_velocity_is_the_slope_of_its_encoder(bench):
    arm = bench.one_link(inertia=5.0)
    hidden = (Injection("encoder_eccentricity", "A", {"amplitude": 0.05, "harmonic": 2.0}),)
    t, trace = bench.open_loop(arm, lambda t: np.sin(9 * t)[:, None], 2.0, hidden, ((0.2, 2.0),))
    assert trace.dq[1:-1, 0] == pytest.approx(np.gradient(trace.q[:, 0], t)[1:-1], abs=1e-4)
