"""The text of an arm file: laid out as a person would write it, with units, and exact when read back."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping

from stribeck.arm.units import unit_at
from stribeck.arm.values import Arm, EffectEntry, Friction, Joint

SCHEMA = "stribeck.arm/1"

_REVOLUTE = {
    "length": "m",
    "mass": "kg",
    "com_x": "m",
    "com_y": "m",
    "com": "m, in the link frame",
    "inertia": "kg m^2, about the centre of mass",
    "rotor_inertia": "kg m^2, reflected to the joint",
    "torque_limit": "N m",
    "encoder_resolution": "rad",
    "C0": "N m",
    "C1": "N m",
    "C2": "N m s/rad",
    "alpha": "rad/s",
}
_PRISMATIC = {key: unit_at(text, "prismatic") for key, text in _REVOLUTE.items()} | {
    "inertia": "kg",
    "rotor_inertia": "kg, reflected to the axis",
}


def write_arm(arm: Arm) -> str:
    """Return the TOML text of an arm that has been checked."""
    lines = [f"schema = {_text(SCHEMA)}", f"name = {_text(arm.name)}"]
    lines.append(_entry("gravity", arm.gravity, "m/s^2 in the arm's plane, base frame"))
    if arm.sample_time is not None:
        lines.append(_entry("sample_time", arm.sample_time, "s, of the controller"))
    lines += ["", "[tolerance]", _entry("inertial", arm.tolerance.inertial, "relative, one standard deviation")]
    lines.append(_entry("friction", arm.tolerance.friction, ""))
    for joint in arm.joints:
        lines += ["", *_joint(joint)]
    for entry in arm.effects:
        lines += ["", *_effect(entry)]
    return "\n".join(lines) + "\n"


def _joint(joint: Joint) -> Iterator[str]:
    units = _PRISMATIC if joint.kind == "prismatic" else _REVOLUTE
    yield "[[joints]]"
    yield f"name = {_text(joint.name)}"
    yield f"kind = {_text(joint.kind)}"
    for key in ("length", "mass", "com", "inertia", "rotor_inertia", "torque_limit", "encoder_resolution"):
        value = getattr(joint, key)
        if value is not None:
            yield _entry(key, value, units[key])
    yield from _friction("[joints.friction]", joint.friction, units)
    if joint.backward != joint.friction:
        yield from _friction("[joints.friction.backward]", joint.backward, units)
    if joint.tolerance:
        yield "[joints.tolerance]  # one standard deviation, absolute"
        yield from (_entry(key, value, units[key]) for key, value in joint.tolerance.items())


def _friction(header: str, friction: Friction, units: Mapping[str, str]) -> Iterator[str]:
    yield header
    for key in ("C0", "C1", "C2", "alpha"):
        yield _entry(key, getattr(friction, key), units[key])


def _effect(entry: EffectEntry) -> Iterator[str]:
    yield "[[effects]]"
    yield f"effect = {_text(entry.effect)}"
    if entry.law is not None:
        yield f"law = {_text(entry.law)}"
    yield f"joints = [{', '.join(_text(name) for name in entry.joints)}]"
    for joint, values in entry.parameters.items():
        yield f"[effects.parameters.{_key(joint)}]"
        yield from (f"{_key(key)} = {_number(value)}" for key, value in values.items())


def _entry(key: str, value: float | tuple[float, ...], unit: str) -> str:
    text = f"[{', '.join(map(_number, value))}]" if isinstance(value, tuple) else _number(value)
    return f"{key} = {text}" + (f"  # {unit}" if unit else "")


def _number(value: float) -> str:
    return repr(float(value))  # float() strips numpy's scalar type from the text


def _text(value: str) -> str:
    # JSON's escapes are TOML's, except that TOML wants DEL escaped as well.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def _key(value: str) -> str:
    return value if re.fullmatch(r"[A-Za-z0-9_-]+", value) else _text(value)
