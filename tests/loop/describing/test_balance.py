"""Harmonic balance: against python-control where that is right, and against exact relay cycles."""

import math
import warnings

import control as ct
import numpy as np
import pytest

from stribeck.arm import Arm, EffectEntry, Friction, Joint
from stribeck.errors import InputError
from stribeck.loop.describing import (
    CompensatedResidual,
    Compensator,
    LinearPart,
    TustinFriction,
    balance,
    find_roots,
    harmonic_balance,
    linear_part,
)
from stribeck.simulate import JointLoop, Loop, Reference

A = Friction(5.0, 1.25, 0.5, 0.05)
COULOMB = Friction(5.0, 0.0, 0.0, 0.05)
NONE = Compensator(COULOMB, 0.0)
KP, STEP = 30.0, 0.0125


def arm(friction: Friction, *effects: EffectEntry) -> Arm:
    joint = Joint("A", "revolute", 0.3, 1.0, (0.0, 0.0), 0.5, 0.5, friction, friction)
    return Arm("one joint", (0.0, 0.0), (joint,), effects=effects)


def part(friction: Friction, step: float = 0.0, *effects: EffectEntry, **values: object) -> LinearPart:
    given = JointLoop("A", **{"kp": KP, **values}, reference=Reference("regulate"))  # type: ignore[arg-type]
    return linear_part(arm(friction, *effects), Loop(step, 20.0, (given,)), "A")


def over(friction: Friction, k: float) -> Friction:
    """What an ideal compensation of ratio k leaves."""
    return Friction((1 - k) * friction.C0, (1 - k) * friction.C1, (1 - k) * friction.C2, friction.alpha)


def exact_coulomb(k: float, zeta: float) -> tuple[float, float]:
    """Amplitude and period of the exact cycle of an over-compensated Coulomb joint, J = 1."""
    root = math.sqrt(1.0 - zeta**2)
    amplitude = (k - 1.0) * COULOMB.C0 / KP / math.tanh(math.pi * zeta / (2.0 * root))
    return amplitude, 2.0 * math.pi / (math.sqrt(KP) * root)


def test_a_root_at_a_resonance_that_is_hardly_damped_is_found() -> None:
    """W turns by half a turn between two frequencies of the grid; where it is real, -1/W is N at 10 rad/s."""
    loop = part(Friction(5.0, 1.25, 1.5, 0.05), STEP, kp=700.0, kv=2.0 * math.sqrt(700.0), delay_samples=1)
    (root,) = find_roots(loop, Friction(5.0, 1.25, 1.5, 0.05), NONE)
    assert (root.velocity, root.omega) == pytest.approx((10.02, 56.12), rel=1e-3)
    assert not root.stable


@pytest.mark.parametrize(("kv", "lag", "filtered"), [(4.0, 0.01, 0.0), (1.0, 0.0, 0.005), (9.0, 0.03, 0.0)])
@pytest.mark.parametrize("friction", [A, COULOMB])
def test_the_roots_are_those_of_python_control(friction: Friction, kv: float, lag: float, filtered: float) -> None:
    loop = part(friction, kv=kv, actuator_lag=lag, velocity_filter=filtered)
    s = ct.tf("s")
    law = (kv / (1 + filtered * s) + KP / s) / (1 + lag * s)
    linear = ct.ss(ct.minreal((1 / s) / (1 + law / s), verbose=False))
    omega, speed = np.geomspace(0.5, 100.0, 1000), np.geomspace(0.01, 20.0, 150)
    assert linear(1j * omega) == pytest.approx(loop.response(omega), rel=1e-6)
    theirs = ct.describing_function_response(linear, CompensatedResidual(Compensator(friction, 1.3)), speed, omega)
    ours = find_roots(loop, over(friction, 1.3), NONE)
    assert len(ours) == len(theirs.intersections) == 1
    assert (ours[0].velocity, ours[0].omega) == pytest.approx(theirs.intersections[0], rel=1e-4)


def test_python_control_with_a_discrete_loop_is_silently_wrong() -> None:
    loop = part(A, STEP, kv=4.0, delay_samples=2)
    z = ct.tf([1.0, 0.0], [1.0], STEP)
    law = (KP + 4.0 * (1 - 1 / z) / STEP) / z**2
    position, velocity = (ct.tf(ct.c2d(ct.ss(ct.tf([1.0], d)), STEP)) for d in ([1.0, 0.0, 0.0], [1.0, 0.0]))
    discrete = ct.ss(ct.minreal(velocity / (1 + position * law), verbose=False))
    speed, omega = np.geomspace(0.01, 5.0, 100), np.geomspace(0.5, 0.999 * math.pi / STEP, 700)
    nonlinearity = CompensatedResidual(Compensator(A, 1.3))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        wrong = ct.describing_function_response(discrete, nonlinearity, speed, omega).intersections
    (root,) = find_roots(loop, over(A, 1.3), NONE)
    assert all(abs(w / root.omega - 1.0) > 0.9 for _, w in wrong)
    # the same loop as frequency data, which python-control takes rightly, gives our root
    data = ct.frd(loop.response(omega), omega, smooth=True)
    right = ct.describing_function_response(data, nonlinearity, speed, omega).intersections
    assert (root.velocity, root.omega) == pytest.approx(right[0], rel=1e-4)
    # and an integration in time with the ideal compensation at the motor agrees as well as one harmonic can
    assert root.period == pytest.approx(period_of_ideal(A, 1.3, 4.0, 2), rel=0.05)


def period_of_ideal(friction: Friction, k: float, kv: float, delay: int) -> float:
    """Period of J dv = u - (1 - k) F(v) under the sampled law, by small steps."""
    q, v, last, queue = 0.0, 0.5, 0.0, [0.0] * (delay + 1)
    steps = 20
    h, crossings = STEP / steps, []
    for n in range(int(10.0 / STEP)):
        queue = [*queue[1:], -KP * q - kv * (q - last) / STEP]
        last = q
        for i in range(steps):
            size = friction.C0 + friction.C1 * math.exp(-abs(v) / friction.alpha) + friction.C2 * abs(v)
            before, v = v, v + h * (queue[0] - (1.0 - k) * math.copysign(size, v))
            q += h * v
            if before < 0.0 <= v:
                crossings.append(n * STEP + i * h)
    return float(np.mean(np.diff(crossings)[-4:]))


def test_python_control_returns_roots_above_the_nyquist_frequency_and_we_do_not() -> None:
    """The compensation acts through a delay: friction times 1 - k exp(-s T), for python-control by Padé."""
    step, k = 0.1, 1.3
    loop = part(COULOMB, step, kv=0.5, velocity="true")
    ours = find_roots(loop, COULOMB, Compensator(COULOMB, k))
    assert all(root.omega < math.pi / step for root in ours)
    delay = ct.tf(*ct.pade(0.5 * step, 8))
    s = ct.tf("s")
    linear = ct.ss((1 / s) / (1 + (0.5 + KP / s) / s * delay) * (1 - k * delay))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = ct.describing_function_response(
            linear, TustinFriction(COULOMB), np.geomspace(1e-3, 50.0, 200), np.geomspace(1.0, 1000.0, 2000)
        ).intersections
    assert any(omega > math.pi / step for _, omega in found)


@pytest.mark.parametrize(("zeta", "amplitude", "period"), [(0.1, -0.3, -0.5), (0.5, -8.4, -13.4), (0.9, -29.5, -56.4)])
def test_one_harmonic_is_off_as_the_damping_grows(zeta: float, amplitude: float, period: float) -> None:
    (root,) = find_roots(part(COULOMB, kv=2 * zeta * math.sqrt(KP)), COULOMB, Compensator(COULOMB, 1.3))
    exact = exact_coulomb(1.3, zeta)
    assert root.stable
    assert 100.0 * (root.amplitude / exact[0] - 1.0) == pytest.approx(amplitude, abs=0.1)
    assert 100.0 * (root.period / exact[1] - 1.0) == pytest.approx(period, abs=0.1)


@pytest.mark.parametrize(("zeta", "close"), [(0.1, 1e-5), (0.3, 1e-4), (0.5, 2e-4), (0.7, 3e-4)])
def test_many_harmonics_give_the_exact_cycle(zeta: float, close: float) -> None:
    loop, law = part(COULOMB, kv=2 * zeta * math.sqrt(KP)), Compensator(COULOMB, 1.3)
    found = harmonic_balance(loop, COULOMB, law, find_roots(loop, COULOMB, law)[0])
    assert found.status == "ok"
    assert (found.amplitude, found.period) == pytest.approx(exact_coulomb(1.3, zeta), rel=close)


def test_stiction_of_a_critically_damped_loop_is_said_to_stick() -> None:
    loop, law = part(A, STEP), Compensator(A, 1.3)
    roots = find_roots(loop, A, law)
    assert roots  # one harmonic predicts a cycle that does not exist
    assert {harmonic_balance(loop, A, law, root).status for root in roots} <= {"sticks", "not_converged"}


def test_one_harmonic_of_many_is_the_describing_function() -> None:
    loop, law = part(A, STEP, kv=1.5, delay_samples=1, actuator_lag=0.01), Compensator(A, 1.2)
    root = find_roots(loop, A, law)[0]
    found = harmonic_balance(loop, A, law, root, harmonics=1)
    assert (found.velocity[0].real, found.omega) == pytest.approx((root.velocity, root.omega), rel=1e-7)


def test_harmonics_stop_at_the_nyquist_frequency() -> None:
    loop, law = part(A, 0.1, kv=1.5, velocity="true"), Compensator(A, 1.2)
    for root in find_roots(loop, A, law):
        found = harmonic_balance(loop, A, law, root)
        assert found.order.max() * root.omega < math.pi / 0.1


def test_every_root_balances_and_a_sampled_loop_has_none_above_its_limit() -> None:
    loop, law = part(A, STEP, kv=3.0, delay_samples=1, velocity_filter=0.01), Compensator(A, 1.1, 0.01, "hold")
    roots = find_roots(loop, A, law)
    assert roots
    for root in roots:
        assert root.omega < loop.highest
        value = balance(loop, A, law, np.array([root.velocity]), np.array([root.omega]))
        assert abs(value[0]) < 1e-8


def test_without_over_compensation_there_is_no_root() -> None:
    for k in (0.0, 0.9, 1.0):
        assert find_roots(part(A, kv=2.0), A, Compensator(A, k)) == ()


def test_an_actuator_effect_delays_the_compensation_as_the_loops_own_lag_does() -> None:
    effect = EffectEntry("actuator_lag", ("A",), {"A": {"time_constant": 0.02}})
    ours, theirs = part(A, STEP, effect), part(A, STEP, actuator_lag=0.02)
    omega = np.geomspace(0.1, 200.0, 20)
    assert ours.passage(omega) == pytest.approx(theirs.passage(omega), rel=1e-9)
    assert ours.response(omega) == pytest.approx(theirs.response(omega), rel=1e-9)


def test_slots_are_the_spring_that_they_are_about_a_pose() -> None:
    slots = EffectEntry("cogging", ("A",), {"A": {"sine": -2.0, "cosine": 0.0, "harmonic": 5.0}})
    spring = EffectEntry("cable_spring", ("A",), {"A": {"stiffness": 10.0, "rest": 0.0}})
    omega = np.geomspace(0.1, 200.0, 20)
    ours, theirs, without = (part(A, STEP, *effect).response(omega) for effect in ((slots,), (spring,), ()))
    assert ours == pytest.approx(theirs, rel=1e-9)
    assert np.abs(without / theirs - 1.0).max() > 0.1


def test_what_it_does_not_take() -> None:
    with pytest.raises(InputError, match="does not control"):
        linear_part(arm(A), Loop(0.0, 1.0, (JointLoop("A", KP, Reference("regulate")),)), "B")
    loop, law = part(A, kv=2.0), Compensator(A, 1.2)
    with pytest.raises(InputError, match="dead-band"):
        harmonic_balance(loop, A, Compensator(A, 1.2, 0.01), find_roots(loop, A, law)[0])
