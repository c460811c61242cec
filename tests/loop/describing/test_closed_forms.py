"""Describing functions in closed form, against quadrature and against python-control's own."""

import itertools
import math

import control as ct
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from stribeck.arm import Friction
from stribeck.loop.describing import CompensatedResidual, Compensator, TustinFriction, describing_function, symmetric
from stribeck.loop.describing.tustin import exponential_part

A = Friction(5.0, 1.25, 1.5, 0.05)
FADING = Friction(0.0, 1.0, 0.0, 1.0)


def fundamental(wave, amplitude: float, breaks: list[float]) -> complex:
    """The complex gain from the first Fourier coefficients of a wave (of the angle), by adaptive quadrature."""

    def integral(weight) -> float:
        ends = [0.0, *sorted(b for b in breaks if 0.0 < b < 2.0 * math.pi), 2.0 * math.pi]
        pieces = [
            quad(lambda t: float(wave(np.array(t))) * weight(t), low, high, epsabs=1e-13, epsrel=1e-12, limit=400)[0]
            for low, high in itertools.pairwise(ends)
        ]
        return sum(pieces) / (math.pi * amplitude)

    return complex(integral(math.sin), integral(math.cos))


@pytest.mark.parametrize("friction", [A, FADING, Friction(2.0, 0.0, 0.0, 0.1), Friction(1.0, 30.0, 0.2, 0.004)])
@pytest.mark.parametrize("ratio", [1e-3, 0.1, 3.0, 7.9, 8.1, 15.0, 20.0, 39.9, 40.1, 300.0])
def test_closed_form_against_quadrature(friction: Friction, ratio: float) -> None:
    v = ratio * friction.alpha
    law = TustinFriction(friction)
    half = (
        2.0
        * quad(lambda t: law(v * math.sin(t)) * math.sin(t), 0.0, math.pi / 2.0, epsabs=0.0, epsrel=1e-12, limit=500)[0]
    )
    exact = 2.0 * half / (math.pi * v)
    assert law.describing_function(v) == pytest.approx(exact, rel=1e-10)
    assert float(describing_function(np.array(v), friction)) == law.describing_function(v)


@settings(max_examples=60)
@given(st.floats(0.0, 500.0))
def test_the_fading_part_falls_from_two_and_has_its_limits(x: float) -> None:
    value, further = (float(exponential_part(np.array(v))) for v in (x, 1.01 * x + 1e-6))
    assert 0.0 < further < value <= 2.0
    assert value <= 2.0 / max(x, 1e-9) ** 2 * (1.0 + 40.0 / max(x, 1e-9) ** 2) or x < 3.0


def test_the_struve_form_alone_cancels_where_the_series_takes_over() -> None:
    from scipy.special import iv, modstruve

    plain = 2.0 + math.pi * (modstruve(1, 20.0) - iv(1, 20.0))
    assert abs(plain / float(exponential_part(np.array(20.0))) - 1.0) > 1e-8


@pytest.mark.parametrize("rule", ["zero", "hold", "error_sign", "set_valued"])
@pytest.mark.parametrize("lead", [0.0, 0.4, -1.2, 1.5])
@pytest.mark.parametrize("amplitude", [0.05, 0.031, 0.3])
def test_a_dead_band_against_quadrature(rule: str, lead: float, amplitude: float) -> None:
    band = 0.03
    law = Compensator(A, 1.2, band, rule)
    edge = math.asin(band / amplitude)
    breaks = [k * math.pi + side * edge for k in range(3) for side in (-1.0, 1.0)]
    breaks += [k * math.pi / 2.0 - turn for k in range(1, 6) for turn in (0.0, lead)]
    exact = fundamental(lambda t: law.wave(t, amplitude, lead), amplitude, breaks)
    assert complex(law.describing_function(np.array(amplitude), lead)) == pytest.approx(exact, abs=1e-8 * abs(exact))


def test_within_the_dead_band_the_rule_alone_acts() -> None:
    v = np.array([0.01, 0.029])
    assert np.abs(Compensator(A, 1.0, 0.03, "zero").describing_function(v)).max() < 1e-12
    assert np.abs(Compensator(A, 1.0, 0.03, "hold").describing_function(v)).max() < 1e-12  # it never had a sign to hold
    by_error = Compensator(A, 1.0, 0.03, "error_sign").describing_function(v)
    assert by_error == pytest.approx(4j * (A.C0 + A.C1) / (math.pi * v), rel=1e-12)


def test_without_a_dead_band_every_rule_is_the_friction_times_the_ratio() -> None:
    v = np.geomspace(1e-3, 10.0, 20)
    for rule in ("zero", "hold", "error_sign", "set_valued"):
        assert Compensator(A, 0.7, 0.0, rule).describing_function(v) == pytest.approx(0.7 * describing_function(v, A))
    residual = CompensatedResidual(Compensator(A, 1.3))
    assert residual.describing_function(0.4).real == pytest.approx(-0.3 * float(describing_function(np.array(0.4), A)))


def test_the_residual_as_a_function_of_velocity() -> None:
    residual = CompensatedResidual(Compensator(A, 1.3, 0.02))
    whole = TustinFriction(A)
    assert residual(0.0) == 0.0
    assert residual(0.1) == pytest.approx(-0.3 * whole(0.1))
    assert residual(-0.01) == whole(-0.01)
    with pytest.raises(NotImplementedError):
        CompensatedResidual(Compensator(A, 1.3, 0.02, "hold"))(0.01)


def test_python_control_takes_the_closed_form_and_is_wrong_without_it() -> None:
    relay = TustinFriction(Friction(5.0, 0.0, 0.0, 0.05))
    v = np.array([0.1, 1.0, 10.0])
    exact = 20.0 / (math.pi * v)
    assert ct.describing_function(relay, v).real == pytest.approx(exact, rel=1e-14)
    own = ct.describing_function(relay, v, try_method=False).real
    assert np.all(np.abs(own / exact - 1.0) < 0.02)
    whole = ct.describing_function(TustinFriction(A), v, try_method=False).real
    off = np.abs(whole / describing_function(v, A) - 1.0)
    assert off.max() > 1e-4


def test_python_controls_quadrature_is_off_by_a_per_cent_where_the_jump_falls_between_its_points() -> None:
    """A relay with a dead zone jumps where the sampled angles do not: 100 points are 1.6 % off, 1.5 degrees each."""
    c = Compensator(Friction(5.0, 0.0, 0.0, 0.05), 1.0, 0.03)
    law = CompensatedResidual(Compensator(c.friction, 2.0, 0.03))
    v = np.linspace(0.031, 0.3, 60)
    exact = np.array([law.describing_function(x).real for x in v])
    own = ct.describing_function(law, v, try_method=False).real
    assert np.abs(own / exact - 1.0).max() > 0.01


def test_asymmetric_friction_has_the_mean_describing_function() -> None:
    forward, backward = Friction(5.0, 1.0, 1.5, 0.05), Friction(4.0, 0.5, 1.0, 0.05)
    v = np.geomspace(1e-3, 10.0, 9)
    mean = 0.5 * (describing_function(v, forward) + describing_function(v, backward))
    assert describing_function(v, symmetric(forward, backward)) == pytest.approx(mean, rel=1e-12)
