"""For each effect: one number that makes it stronger, with the bounds of what can be built."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from stribeck.withheld.arms import GRAVITY
from stribeck.withheld.stage import Stage

Params: TypeAlias = Callable[[float], dict[str, float]]
Build: TypeAlias = Callable[[Stage], Params]


@dataclass(frozen=True)
class Scale:
    """How the strength of an effect is varied: from a drawn stage to parameters as a function of one number.

    `range` bounds the number where it is measured; `levels` gives its range directly where it is not. Angles are those
    of joints that turn; on an axis that slides, `Stage.radian` stands for a radian.
    """

    build: Build
    range: tuple[float, float] = (0.0, math.inf)
    levels: Mapping[str, tuple[float, float]] | None = None


def _periodic(amplitude: Callable[[Stage], float], *harmonics: float, name: str = "amplitude") -> Build:
    def build(st: Stage) -> Params:
        harmonic, phase, unit = st.one_of(*harmonics) / st.radian, st.phase(), amplitude(st)
        return lambda s: {name: s * unit, "harmonic": harmonic, "phase": phase}

    return build


def _overtones(amplitude: Callable[[Stage], float], *harmonics: float, name: str = "amplitude") -> Build:
    """Draw a wave, in every other case with an overtone."""

    def build(st: Stage) -> Params:
        share = st.one_of(0.0, 1.0) * st.between(0.1, 0.4)
        again, wave = st.phase(), _periodic(amplitude, *harmonics, name=name)(st)
        return lambda s: {**wave(s), "overtone": share * wave(s)[name], "overtone_phase": again}

    return build


def _simple(name: str, unit: Callable[[Stage], float] = lambda st: 1.0) -> Build:
    def build(st: Stage) -> Params:
        size = unit(st)
        return lambda s: {name: s * size}

    return build


def _asymmetric(st: Stage) -> Params:
    sign, f = st.one_of(-1.0, 1.0), st.joint.friction
    viscous = st.between(0.0, 0.5)
    return lambda s: {"C0": sign * s * f.C0, "C1": sign * 0.5 * s * f.C1, "C2": sign * viscous * s * f.C2}


def _negative(st: Stage) -> Params:
    velocity, squared = st.between(0.05, 0.2) * st.radian, st.one_of(0.0, 1.0)
    return lambda s: {"amount": s * st.joint.friction.C0, "velocity": velocity, "squared": squared}


def _presliding(st: Stage) -> Params:
    inertia = st.inertia + st.joint.rotor_inertia

    def params(s: float) -> dict[str, float]:
        stiffness = st.break_away / (s * st.radian)
        return {"stiffness": stiffness, "damping": 0.4 * math.sqrt(stiffness * inertia)}

    return params


def _dwell(st: Stage) -> Params:
    time, distance = st.between(0.3, 2.0), st.between(0.005, 0.03) * st.radian
    renewed = st.one_of(distance, distance, 0.0)  # by a slide, or by the next rest alone
    return lambda s: {"rise": s * st.break_away, "time": time, "distance": renewed}


def _trailing(st: Stage) -> Params:
    part = st.one_of(0.0, 1.0)  # all friction, or what falls with the speed alone
    return lambda s: {"time": s, "drop": part}


def _load(st: Stage) -> Params:
    # what leaves the gear, what enters it, what the motor gives, what dry friction leaves of it, what holds the link
    of = st.one_of(0.0, 1.0, 2.0, 4.0, *([3.0] if st.vertical else []))
    return lambda s: {"ratio": s, "input": of}


def _history(st: Stage) -> Params:
    time, sign, wears = st.between(8.0, 30.0), st.one_of(-1.0, -1.0, 1.0), st.one_of(False, False, True)
    if wears:
        lost = st.one_of(0.0, 1.0)
        return lambda s: {"change": s, "work": time * st.power * (1.0 - 0.7 * lost), "lost": lost}
    power = st.one_of(0.0, 1.0) * st.power  # without: by time alone
    return lambda s: {"change": sign * s, "time": time, "power": power}


def _lag(st: Stage) -> Params:
    kind = st.one_of(1, 2, 3)  # a pole, a pole twice, two that swing
    again, damping = 0.5 if kind == 2 else 0.0, math.sqrt(0.5) if kind == 3 else 0.0
    return lambda s: {"time": (1.0 - again) * s, "again": again * s, "damping": damping}


def _gain(st: Stage) -> Params:
    sign = st.one_of(-1.0, 1.0)
    return lambda s: {"gain": 1.0 + sign * s}


def _offset(st: Stage) -> Params:
    sign = st.one_of(-1.0, 1.0)
    return lambda s: {"offset": sign * s * st.torque}


def _encoder_offset(st: Stage) -> Params:
    sign = st.one_of(-1.0, 1.0)
    return lambda s: {"offset": sign * s * st.radian}


def _saturation(st: Stage) -> Params:
    fade = st.one_of(0.0, 1.0) * st.between(0.1, 0.3) / st.speed
    return lambda s: {"limit": max(st.peak / s, 1.1 * st.holding), "fade": fade}


def _dead_zone(st: Stage) -> Params:
    jump = st.one_of(0.0, 1.0)
    return lambda s: {"width": s * st.torque, "jump": jump}


def _shift(st: Stage) -> Params:
    sign = st.one_of(1.0, 1.0, -1.0)
    return lambda s: {"time": sign * s}


def _tilt(st: Stage) -> Params:
    side = st.phase()
    if st.vertical:
        sign = math.copysign(1.0, side)
        return lambda s: {"x": GRAVITY * (math.cos(s) - 1.0), "y": sign * GRAVITY * math.sin(s)}
    return lambda s: {"x": GRAVITY * math.sin(s) * math.cos(side), "y": GRAVITY * math.sin(s) * math.sin(side)}


def _cable(st: Stage) -> Params:
    rest = float(st.rng.choice(st.angles)) + st.between(-0.3, 0.3) * st.radian
    cubic = st.one_of(0.0, 1.0) * st.between(1.0, 4.0) / st.radian**2
    return lambda s: {"stiffness": s * st.torque / st.radian, "rest": rest, "cubic": cubic * s * st.torque / st.radian}


def _base(st: Stage) -> Params:
    if not st.one_of(False, True) or not st.joint.length:
        return lambda s: {"stiffness": st.stiffest(s, 4.0)}
    way, reach = st.phase(), st.joint.length
    return lambda s: {"stiffness": st.stiffest(s, 4.0) / reach**2, "direction": way}


def _contact(st: Stage) -> Params:
    exponent, in_plane = st.one_of(1.5, 1.0), st.one_of(False, True)
    if in_plane and st.tips is not None:
        way, length = st.phase(), float(np.abs(st.tips).max())
        place = float(np.quantile((st.tips * np.exp(-1j * way)).real, 0.85))
        plane = {"position": place, "direction": way, "damping": 0.4, "exponent": exponent}
        return lambda s: {"stiffness": s * st.torque / length / (0.1 * length) ** exponent, **plane}
    side = st.one_of(-1.0, 1.0)
    place = float(np.quantile(st.angles, 0.85 if side > 0 else 0.15))
    shared = {"position": place, "side": side, "exponent": exponent}
    size = st.torque / (0.1 * st.radian) ** exponent
    if exponent > 1.0:
        return lambda s: {"stiffness": s * size, "damping": 0.4 / st.radian, **shared}
    lag = st.one_of(0.0, 1.0) * st.between(0.01, 0.05)  # s, of the damper beside a spring
    return lambda s: {"stiffness": s * size, "damping": 0.0, "damper": s * size * lag, **shared}


def _disturbance(st: Stage) -> Params:
    """Draw a wave or pulses: coloured noise is no effect of an arm, and is hidden in cases without one (``hide``)."""
    shared = {"noise": 0.0, "bandwidth": 10.0, "frequency": st.between(1.5, 8.0), "phase": st.phase()}
    duty = st.one_of(0.0, 0.0, 1.0) * st.between(0.2, 0.5)
    per_rms = 1.0 / math.sqrt(duty * (1.0 - duty)) if duty else math.sqrt(2.0)
    return lambda s: {"amplitude": s * st.torque * per_rms, "duty": duty, **shared}


def _supply(st: Stage) -> Params:
    frequency, speed = st.between(4.0, 11.0), st.between(0.08, 0.25) * st.speed
    return lambda s: {"torque": s * st.torque, "frequency": frequency, "speed": speed}


def _sticky(st: Stage) -> Params:
    centre, width = float(st.rng.choice(st.angles)), st.between(0.1, 0.25) * st.radian
    return lambda s: {"torque": s * st.torque, "centre": centre, "width": width, "load": 0.25 * st.torque}


def _jumps(st: Stage) -> Params:
    rate = st.between(1.0, 4.0)
    return lambda s: {"change": s, "rate": rate}


def _tendon(st: Stage) -> Params:
    ratio, slack = st.between(0.5, 1.5), st.between(-0.2, 0.2)
    return lambda s: {"stiffness": s * st.torque, "ratio": ratio, "slack": slack}


_rms_torque: Callable[[Stage], float] = lambda st: st.torque  # noqa: E731
_radian: Callable[[Stage], float] = lambda st: st.radian  # noqa: E731

SCALES: dict[str, Scale] = {
    "asymmetric_friction": Scale(_asymmetric, (0.02, 1.2)),
    "negative_damping": Scale(_negative, (0.05, 1.2)),
    "presliding": Scale(
        _presliding, levels={"clear": (3e-3, 1.2e-2), "medium": (1e-3, 3e-3), "weak": (3e-4, 1e-3)}
    ),  # rad to give way
    "frictional_lag": Scale(
        _trailing, levels={"clear": (0.04, 0.1), "medium": (0.015, 0.04), "weak": (0.004, 0.015)}
    ),
    "dwell_time": Scale(_dwell, levels={"clear": (0.5, 1.0), "medium": (0.25, 0.5), "weak": (0.1, 0.25)}),
    "history": Scale(_history, (0.03, 0.7)),
    "position_dependent_friction": Scale(_overtones(lambda st: st.joint.friction.C0, 1.0, 2.0, 3.0), (0.03, 0.7)),
    "load_dependent_friction": Scale(_load, (0.005, 0.5)),
    "quadratic_damping": Scale(_simple("coefficient", lambda st: st.torque / st.speed**2), (0.05, 6.0)),
    "actuator_lag": Scale(_lag, (5e-4, 0.04)),
    "delay": Scale(_simple("time"), (5e-4, 0.03)),
    "torque_gain": Scale(_gain, (0.01, 0.5)),
    "torque_offset": Scale(_offset, (0.01, 0.8)),
    "torque_saturation": Scale(
        _saturation,
        levels={"clear": (1.3, 1.7), "medium": (1.15, 1.3), "weak": (1.05, 1.15)},
    ),
    "torque_dead_zone": Scale(_dead_zone, (0.01, 0.8)),
    "cogging": Scale(_overtones(_rms_torque, 4.0, 6.0, 8.0, 12.0, 24.0), (0.02, 1.0)),
    "torque_ripple": Scale(_overtones(lambda st: 1.0, 4.0, 6.0, 8.0, 12.0, name="ratio"), (0.02, 0.6)),
    "joint_flexibility": Scale(lambda st: lambda s: {"stiffness": st.stiffest(s, 5.0)}, (1e-4, 0.3)),
    "backlash": Scale(
        _simple("gap", _radian), levels={"clear": (1.5e-2, 4e-2), "medium": (5e-3, 1.5e-2), "weak": (1e-3, 5e-3)}
    ),
    "encoder_eccentricity": Scale(_overtones(_radian, 1.0, 2.0), (1e-3, 0.04)),
    "encoder_offset": Scale(_encoder_offset, (3e-3, 0.4)),
    "encoder_quantisation": Scale(
        _simple("resolution", _radian), levels={"clear": (3e-3, 9e-3), "medium": (1e-3, 3e-3), "weak": (3e-4, 1e-3)}
    ),
    "velocity_filter": Scale(
        _simple("time"), levels={"clear": (0.03, 0.08), "medium": (0.01, 0.03), "weak": (0.003, 0.01)}
    ),
    "time_shift": Scale(_shift, (5e-4, 0.04)),
    "payload": Scale(_simple("mass", lambda st: st.joint.mass), (0.01, 1.5)),
    "gravity_tilt": Scale(_tilt, (0.003, 0.4)),
    "base_flexibility": Scale(_base, (1e-4, 0.3)),
    "cable_spring": Scale(_cable, (0.02, 3.0)),
    "contact": Scale(_contact, (0.02, 30.0)),
    "input_disturbance": Scale(_disturbance, (0.01, 0.8)),
    "supply_bang": Scale(_supply, (0.02, 1.0)),
    "loaded_sticky_spot": Scale(_sticky, (0.05, 2.0)),
    "friction_jumps": Scale(_jumps, (0.05, 0.8)),
    "tendon_coupling": Scale(_tendon, (0.02, 5.0)),
    "hardening_gain": Scale(
        lambda st: lambda s: {"change": s, "torque": st.peak}, (0.02, 1.5)
    ),
    "sloshing_mass": Scale(_simple("mass", lambda st: st.joint.mass), (0.02, 0.3)),
}  # fmt: skip
