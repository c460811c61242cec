"""Read and write the arm file (``stribeck.arm/1``)."""

from __future__ import annotations

import tomllib
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from stribeck.arm.text import SCHEMA, write_arm
from stribeck.arm.units import unit_at
from stribeck.arm.values import Arm, EffectEntry, Joint
from stribeck.errors import InputError
from stribeck.outputs import whole_file
from stribeck.textfile import check_schema, load_toml, structure

# of a link that turns: nothing of a straight axis depends on them
LEVERS = {"length": 0.0, "com": [0.0, 0.0], "inertia": 0.0}
MOST_RESOLUTION = 0.5  # rad (m); 13 counts a turn
TOLERATED = ("mass", "com_x", "com_y", "inertia", "rotor_inertia", "C0", "C1", "C2", "alpha")


@cache
def _adapter() -> TypeAdapter[Arm]:
    return TypeAdapter(Arm)


def load_arm(path: Path | str) -> Arm:
    """Read an arm file.

    Parameters
    ----------
    path : path
        A TOML file of at most 1 MiB.

    Raises
    ------
    InputError
        One line: the file, the key, what was found there and what to do.
    """
    path = Path(path)
    return _from_table(load_toml(path), str(path))


def save_arm(arm: Arm, path: Path | str) -> None:
    """Write an arm file, whole or not at all; `load_arm` gives the same arm back."""
    text = arm_to_toml(arm)
    with whole_file(path) as part:
        part.write_text(text, encoding="utf-8")


def arm_to_toml(arm: Arm) -> str:
    """Return the text of the arm file; every number reads back exactly.

    Raises
    ------
    InputError
        When the arm holds a value that `load_arm` would refuse, so that no unreadable file is ever written.
    """
    text = write_arm(arm)
    _from_table(tomllib.loads(text), f"arm {arm.name!r}")
    return text


def _from_table(data: dict[str, Any], source: str) -> Arm:
    table = check_schema(data, SCHEMA, source)
    joints = table.get("joints")
    if isinstance(joints, list):
        table["joints"] = [_lift_backward(_with_levers(joint), k, source) for k, joint in enumerate(joints)]
    arm = structure(table, _adapter(), source, {"backward": "friction.backward"})
    _check(arm, source)
    return arm


def _with_levers(joint: Any) -> Any:
    """Fill in what a straight axis need not state."""
    straight = isinstance(joint, dict) and joint.get("kind") == "prismatic"
    return {**LEVERS, **joint} if straight else joint


def _lift_backward(joint: Any, k: int, source: str) -> Any:
    """Move ``friction.backward`` up to the joint, the constants it leaves out filled from the forward ones."""
    if not isinstance(joint, dict):
        return joint
    if "backward" in joint:
        raise InputError(f"{source}: joints[{k}].backward is not a known key", "", "write [joints.friction.backward]")
    if not isinstance(joint.get("friction"), dict):
        return joint
    forward = dict(joint["friction"])
    backward = forward.pop("backward", {})
    if isinstance(backward, dict):
        backward = {**forward, **backward}
    return {**joint, "friction": forward, "backward": backward}


def _check(arm: Arm, source: str) -> None:
    """Check what the types alone cannot say."""
    seen: set[str] = set()
    for k, joint in enumerate(arm.joints):
        _check_joint(joint, f"{source}: joints[{k}]", arm.n)
        if joint.name in seen:
            raise InputError(
                f"{source}: joints[{k}].name is used twice", repr(joint.name), "give each joint its own name"
            )
        seen.add(joint.name)
    for k, entry in enumerate(arm.effects):
        _check_effect(entry, f"{source}: effects[{k}]", arm.names)


def _check_joint(joint: Joint, where: str, n: int) -> None:
    if joint.kind == "prismatic" and n > 1:
        raise InputError(
            f"{where}.kind: a prismatic joint can only be a single axis",
            f"{n} joints",
            "use revolute joints, or one axis",
        )
    if joint.encoder_resolution is not None and joint.encoder_resolution > MOST_RESOLUTION:
        unit = unit_at("rad", joint.kind)
        what = f"{where}.encoder_resolution must not be greater than {MOST_RESOLUTION:g} {unit}"
        step = "2 pi / counts a turn" if joint.kind == "revolute" else "the way of one count"
        raise InputError(what, f"{joint.encoder_resolution:g}", f"give the step in {unit}, not counts: {step}")
    for key in joint.tolerance:
        if key not in TOLERATED:
            raise InputError(f"{where}.tolerance.{key} is not a known key", "", f"use one of: {', '.join(TOLERATED)}")
    if joint.kind == "revolute" and joint.inertia == joint.rotor_inertia == 0.0 and joint.com == (0.0, 0.0):
        raise InputError(f"{where} has no inertia about its axis", "", "give inertia, rotor_inertia or com")


def _check_effect(entry: EffectEntry, where: str, names: tuple[str, ...]) -> None:
    known = f"the arm's joints are {', '.join(names)}"
    for i, name in enumerate(entry.joints):
        if name not in names:
            raise InputError(f"{where}.joints[{i}] is not a joint of this arm", repr(name), known)
    if len(set(entry.joints)) < len(entry.joints):
        raise InputError(f"{where}.joints names a joint twice", ", ".join(entry.joints), "name each joint once")
    for name in entry.parameters:
        if name not in entry.joints:
            raise InputError(f"{where}.parameters has a joint that is not in joints", repr(name), known)
