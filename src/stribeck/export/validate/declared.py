"""What an FMU of an arm must declare: the variables of the contract, their units and the arm's own values."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from stribeck.arm import Arm
from stribeck.arm.values import Joint
from stribeck.export.validate.opened import Opened
from stribeck.simulate.engine import simulated

Dimension = dict[str, int]  # exponents of the SI base units; that of rad is not looked at

# of a revolute joint and of a prismatic one
_DIMENSIONS: dict[str, tuple[Dimension, Dimension]] = {
    "position": ({}, {"m": 1}),
    "velocity": ({"s": -1}, {"m": 1, "s": -1}),
    "torque": ({"kg": 1, "m": 2, "s": -2}, {"kg": 1, "m": 1, "s": -2}),
    "inertia": ({"kg": 1, "m": 2}, {"kg": 1}),
    "damping": ({"kg": 1, "m": 2, "s": -1}, {"kg": 1, "s": -1}),
    "mass": ({"kg": 1}, {"kg": 1}),
    "number": ({}, {}),
}
# name less its index -> causality, dimension
_SIGNALS = {
    "tau": ("input", "torque"),
    "q": ("output", "position"),
    "dq": ("output", "velocity"),
    "tau_friction": ("output", "torque"),
    "sliding": ("output", "number"),
    "q_start": ("parameter", "position"),
    "dq_start": ("parameter", "velocity"),
}
_JOINT = {"mass": "mass", "inertia": "inertia", "rotor_inertia": "inertia"}
_FRICTION = {"C0": "torque", "C1": "torque", "C2": "damping", "alpha": "velocity"}


def declaration_problems(fmu: Opened, arm: Arm) -> list[str]:
    """Return what an FMU that holds an arm declares otherwise than that arm's FMU must."""
    variables = {variable.name: variable for variable in fmu.description.modelVariables}
    units = {unit.name: unit.baseUnit for unit in fmu.description.unitDefinitions}
    problems = []
    for name, causality, dimension, value in _expected(arm):
        variable = variables.get(name)
        if variable is None:
            problems.append(f"variable {name} is missing")
            continue
        if variable.causality != causality:
            problems.append(f"variable {name} must have causality {causality}: found {variable.causality}")
        if dimension is not None:
            problems += _unit_problems(variable, dimension, units)
        if value is not None and _number(variable.start) != value:
            problems.append(f"variable {name} starts at {variable.start}; {value!r} stands in resources/arm.toml")
        tuned = ("tunable", "fixed") if name.startswith("effect") else ("tunable",)  # some say how an effect starts
        if causality == "parameter" and name.startswith(("joint", "effect")) and variable.variability not in tuned:
            problems.append(f"parameter {name} must be tunable: found {variable.variability}")
    return problems


def unitless(fmu: Opened) -> list[str]:
    """Return the real variables without a unit, local ones apart: an event indicator is no one quantity."""
    real = ("Real", "Float32", "Float64")
    return [
        v.name for v in fmu.description.modelVariables if v.type in real and v.causality != "local" and _unit(v) is None
    ]


def _expected(arm: Arm) -> Iterator[tuple[str, str, Dimension | None, float | None]]:
    """Give name, causality, dimension and start value; None is not looked at."""
    for k, joint in enumerate(arm.joints, start=1):
        straight = int(joint.kind == "prismatic")
        for name, (causality, dimension) in _SIGNALS.items():
            yield f"{name}[{k}]", causality, _DIMENSIONS[dimension][straight], None
        for name, value, dimension in _values(joint):
            yield f"joint[{k}].{name}", "parameter", _DIMENSIONS[dimension][straight], value
    for place in simulated(arm):
        for key, value in place.values.items():
            yield f"effect.{place.effect.name}[{place.joint + 1}].{key}", "parameter", None, value


def _values(joint: Joint) -> Iterator[tuple[str, float, str]]:
    for name, dimension in _JOINT.items():
        yield name, getattr(joint, name), dimension
    for name, dimension in _FRICTION.items():
        yield f"friction.{name}", getattr(joint.friction, name), dimension


def _unit_problems(variable: Any, dimension: Dimension, units: dict[str, Any]) -> list[str]:
    unit = _unit(variable)
    if unit is None:
        return [f"variable {variable.name} has no unit"]
    base = units.get(unit)
    if base is None:
        return []  # fmpy says so
    found = {key: int(getattr(base, key)) for key in ("kg", "m", "s", "A", "K", "mol", "cd")}
    wanted = {key: dimension.get(key, 0) for key in found}
    if found != wanted or float(base.factor) != 1.0 or float(base.offset) != 0.0:
        return [f"variable {variable.name} has the unit {unit}, which is not that of the contract in SI"]
    return []


def _number(text: object) -> float | None:
    try:
        return float(str(text))
    except ValueError:
        return None


def _unit(variable: Any) -> str | None:
    unit = variable.unit or getattr(variable.declaredType, "unit", None)
    return None if unit is None else str(unit)
