"""Parameters that the recording plant and the library mean alike, although neither knows the other."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TypeAlias

from stribeck.effects.registry import laws, registry
from stribeck.model.effect import Effect

Values: TypeAlias = Mapping[str, float]
Converted: TypeAlias = dict[str, float]


def _named(**names: str) -> Callable[[Values], Converted]:
    """Take the plant's values under the library's names (library=plant)."""
    return lambda p: {ours: p[theirs] for ours, theirs in names.items() if theirs in p}


def _wave(size: str) -> Callable[[Values], Converted]:
    """Turn ``size sin(N q + phase)`` into a sine and a cosine."""

    def convert(p: Values) -> Converted:
        a, phase = p[size], p["phase"]
        return {"sine": a * math.cos(phase), "cosine": a * math.sin(phase), "harmonic": p["harmonic"]}

    return convert


def _halves(p: Values) -> Converted:
    """Turn differences of the two directions into halves of them, where the library has no third constant."""
    return {"coulomb": 0.5 * p["C0"], "viscous": 0.5 * p["C2"]} if p.get("C1", 0.0) == 0.0 else {}


def _wall(p: Values) -> Converted:
    if "direction" in p:
        return {"distance": p["position"]}
    return {"position": p["position"]}  # its stiffness is in the unit of a law


# Left out: history (another charge), dwell-time constants, damping that the plant draws for itself, and phases that
# count from another moment.
CONVERT: Mapping[str, Callable[[Values], Converted]] = {
    "asymmetric_friction": _halves,
    "negative_damping": _named(amount="amount", velocity="velocity"),
    "presliding": _named(stiffness="stiffness"),
    "frictional_lag": _named(time="time"),
    "load_dependent_friction": _named(ratio="ratio"),
    "position_dependent_friction": _named(harmonic="harmonic"),
    "quadratic_damping": _named(coefficient="coefficient"),
    "actuator_lag": lambda p: {"time_constant": p["time"] + p.get("again", 0.0)},
    "delay": _named(time="time"),
    "torque_gain": _named(gain="gain"),
    "torque_offset": _named(offset="offset"),
    "torque_saturation": _named(limit="limit", fade="fade"),
    "torque_dead_zone": _named(width="width"),
    "cogging": _wave("amplitude"),
    "torque_ripple": _wave("ratio"),
    "joint_flexibility": _named(stiffness="stiffness"),
    "backlash": _named(gap="gap"),
    "encoder_eccentricity": _wave("amplitude"),
    "encoder_offset": _named(offset="offset"),
    "encoder_quantisation": _named(resolution="resolution"),
    "velocity_filter": _named(time="time"),
    "time_shift": _named(time="time"),
    "payload": _named(mass="mass"),
    "gravity_tilt": _named(x="x", y="y"),
    "base_flexibility": _named(stiffness="stiffness"),
    "cable_spring": _named(stiffness="stiffness", rest="rest", cubic="cubic"),
    "contact": _wall,
    "input_disturbance": _named(frequency="frequency"),
}


# The plant has another law under the same name (Iwan's elements, another contact, another lag): the parameters mean
# nearly the same, but an interval around the one need not hold the other
RELATED = frozenset({"presliding", "backlash", "frictional_lag", "negative_damping", "contact"})
# The plant's parameter that makes it a further law of a family, and that law; of several, it is the law's number
FURTHER = {
    "load_dependent_friction": ("input", ("directional", "motor", "weight", "net")),
    "position_dependent_friction": ("overtone", ("harmonics",)),
    "torque_saturation": ("fade", ("back_emf",)),
    "cable_spring": ("cubic", ("hardening",)),
    "torque_dead_zone": ("jump", ("threshold",)),
    "base_flexibility": ("direction", ("sliding",)),
}


def same_law(effect: str, parameters: Values, law: str | None) -> bool:
    """Return whether the plant's law of an effect is the library's one: an interval is then to hold the parameter."""
    if effect == "actuator_lag":
        return law == _lag(parameters)
    if effect in FURTHER:
        parameter, further = FURTHER[effect]
        if not _has(parameters, parameter):
            return law not in further
        return law == further[int(parameters[parameter]) - 1 if len(further) > 1 else 0]
    return effect not in RELATED


def _lag(parameters: Values) -> str:
    if _has(parameters, "damping"):
        return "magnitude_optimum"
    return "two_poles" if _has(parameters, "again") else "one_pole"


def _has(parameters: Values, name: str) -> bool:
    """Return whether the plant was given a parameter that makes another law; a direction of 0 is one."""
    return name in parameters and (name == "direction" or parameters[name] != 0.0)


def law_for(effect: str, parameters: Values) -> Effect | None:
    """Return the library's law whose parameters the plant's values are; None of what no library has."""
    values, turned = set(true_values(effect, parameters)), _has(parameters, "direction")
    for law in laws().values():
        names = {parameter.name for parameter in law.parameters}
        if law.name == effect and values <= names and turned == ("direction" in names):
            return law
    return registry().get(effect)


def true_values(effect: str, parameters: Values) -> Converted:
    """Return the plant's parameters of an effect as the library would have them; empty where they do not compare."""
    return CONVERT[effect](parameters) if effect in CONVERT else {}
