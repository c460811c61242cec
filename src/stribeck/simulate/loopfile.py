"""Read a loop file (``stribeck.loop/1``) and check it against the arm that it controls."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from stribeck.arm import Arm, unit_at
from stribeck.effects.placing import placed_effects
from stribeck.errors import InputError
from stribeck.model.layout import Placed
from stribeck.run import Run, load_run
from stribeck.run.reading import as_read
from stribeck.simulate.loop import JointLoop, Loop, Reference
from stribeck.textfile import check_schema, load_toml, structure

SCHEMA = "stribeck.loop/1"
MOST_SAMPLES = 20_000_000
_FARTHEST = 1000.0  # rad, and rad/s; no reference of an arm lies beyond
_MOST_LEVELS = 1e9  # encoder steps a radian


@cache
def _adapter() -> TypeAdapter[Loop]:
    return TypeAdapter(Loop)


def load_loop(path: Path | str, arm: Arm) -> Loop:
    """Read a loop file for an arm; what it says of the runs that it follows is :func:`read_loop`'s.

    Parameters
    ----------
    path : path
        A TOML file of at most 1 MiB.
    arm : Arm
        The arm that the loop controls.

    Raises
    ------
    InputError
        One line: the file, the key, what was found there and what to do.
    """
    return read_loop(path, arm)[0]


def read_loop(path: Path | str, arm: Arm) -> tuple[Loop, tuple[str, ...], tuple[str, ...]]:
    """Read a loop file for an arm as :func:`load_loop` does.

    Returns
    -------
    loop : Loop
    notes : tuple of str
        What was done to the runs that it follows.
    warnings : tuple of str
        What there is to doubt of them.
    """
    path = Path(path)
    source = str(path)
    table = check_schema(load_toml(path), SCHEMA, source)
    joints = table.get("joints")
    if isinstance(joints, list):
        table["joints"] = [_lift_critical(joint, f"{source}: joints[{k}]") for k, joint in enumerate(joints)]
    loop = structure(table, _adapter(), source)
    check_loop(loop, arm, source)
    names = dict.fromkeys(entry.reference.file for entry in loop.joints if entry.reference.kind == "file")
    recorded = {name: load_run(path.parent / name, arm.n, arm.kinds) for name in names}
    read = {name: as_read(run) for name, run in recorded.items()}
    runs = {name: run for name, (run, _) in read.items()}
    joints = tuple(_follow_file(entry, arm, runs, loop.duration) for entry in loop.joints)
    warnings = tuple(f"{run.name}: {text}" for run in recorded.values() for text in run.warnings)
    return replace(loop, joints=joints), tuple(note for _, notes in read.values() for note in notes), warnings


def _lift_critical(joint: Any, where: str) -> Any:
    """Turn ``kv = "critical"`` into None, which TOML cannot write."""
    if not isinstance(joint, dict):
        return joint
    if "kv" not in joint:
        raise InputError(f"{where}.kv is missing", "", 'add it: a number, or "critical"')
    if not isinstance(joint["kv"], str):
        return joint
    if joint["kv"] != "critical":
        raise InputError(f"{where}.kv must be a number or 'critical'", repr(joint["kv"]), "correct the value")
    return {**joint, "kv": None}


def check_loop(loop: Loop, arm: Arm, source: str = "loop") -> None:
    """Check what the types alone cannot say; raise `InputError`."""
    known = f"the arm's joints are {', '.join(arm.names)}"
    if loop.duration / loop.step > MOST_SAMPLES:
        what = f"{source}: duration is more than {MOST_SAMPLES:g} samples"
        raise InputError(what, f"{loop.duration / loop.step:g}", "shorten it, or sample less often")
    if loop.duration < 2.0 * loop.step:
        raise InputError(f"{source}: duration is under two samples", f"{loop.duration:g} s", "lengthen it")
    seen: set[str] = set()
    for k, entry in enumerate(loop.joints):
        where = f"{source}: joints[{k}]"
        if entry.joint not in arm.names:
            raise InputError(f"{where}.joint is not a joint of this arm", repr(entry.joint), known)
        if entry.joint in seen:
            raise InputError(f"{where}.joint is controlled twice", repr(entry.joint), "give each joint one entry")
        seen.add(entry.joint)
        _check_joint(entry, loop, where, arm.kinds[arm.names.index(entry.joint)])
    for name, position in loop.clamp.items():
        if name not in arm.names or name in seen:
            raise InputError(f"{source}: clamp names a joint that is not clamped", repr(name), known)
        if abs(position) > _FARTHEST:
            unit = unit_at("rad", arm.kinds[arm.names.index(name)])
            what = f"{source}: clamp.{name} lies beyond {_FARTHEST:g} {unit}"
            raise InputError(what, f"{position:g}", f"give it in {unit}, and SI units")
    for place in placed_effects(arm):
        _check_delay(place, loop, arm, source)


def _check_delay(place: Placed, loop: Loop, arm: Arm, source: str) -> None:
    """Raise `InputError` for a delay that the loop cannot have; a late record of the position is one in a loop."""
    late = place.values.get("time", 0.0) if place.effect.delays else 0.0
    if late < 0.0:
        what = f"{source}: an arm with {place.effect.name} at {arm.names[place.joint]} looks ahead in time"
        raise InputError(what, f"{late:g} s", "a controller sees no future: give the arm 0 or more")
    if late > 0.0 and loop.sample_time == 0.0:
        what = f"{source}: a continuous controller cannot drive an arm with the effect {place.effect.name}"
        raise InputError(what, "", "give a sample_time above 0")


def _check_joint(entry: JointLoop, loop: Loop, where: str, kind: str) -> None:
    if loop.sample_time == 0.0:
        for key in ("delay_samples", "encoder_resolution", "encoder_noise"):
            if getattr(entry, key) > 0:
                what = f"{where}.{key} needs a sampled controller"
                raise InputError(what, "sample_time = 0", "give a sample_time above 0, or leave it out")
    if 0.0 < entry.encoder_resolution < 1.0 / _MOST_LEVELS:
        raise InputError(f"{where}.encoder_resolution is too fine", f"{entry.encoder_resolution:g}", "give 0 for none")
    if entry.compensation.kind == "dither" and entry.compensation.frequency == 0.0:
        raise InputError(f"{where}.compensation.frequency is missing", "", "give the dither's frequency in Hz")
    _check_reach(entry, loop, f"{where}.reference", unit_at("rad", kind))
    _check_reference(entry.reference, f"{where}.reference")


def _check_reach(entry: JointLoop, loop: Loop, where: str, unit: str) -> None:
    """Raise `InputError` for a reference that goes further, or faster, than any arm; in ``unit``."""
    reference = entry.reference
    reach = {
        "ramp": abs(reference.velocity) * loop.duration,
        "regulate": abs(reference.initial_error),
        "sine": abs(reference.amplitude),
        "steps": max((abs(value) for value in reference.values), default=0.0),
    }.get(reference.kind, 0.0) + abs(entry.start)
    if reach > _FARTHEST:
        raise InputError(f"{where} goes beyond {_FARTHEST:g} {unit}", f"{reach:g}", f"give it in {unit}, and SI units")
    speed = max(abs(reference.velocity), 6.283 * reference.frequency * abs(reference.amplitude))
    if speed > _FARTHEST:
        raise InputError(f"{where} is faster than {_FARTHEST:g} {unit}/s", f"{speed:g}", "give a slower one")


def _check_reference(reference: Reference, where: str) -> None:
    if reference.kind == "sine" and reference.frequency == 0.0:
        raise InputError(f"{where}.frequency is missing", "", "give it in Hz")
    if reference.kind == "steps":
        pairs = zip(reference.times, reference.times[1:], strict=False)
        if len(reference.times) != len(reference.values) or not reference.times:
            found = f"{len(reference.times)} and {len(reference.values)}"
            raise InputError(f"{where}: times and values must be as many", found, "give a value for each time")
        if any(later <= earlier for earlier, later in pairs):
            raise InputError(f"{where}.times must increase", "", "sort them and drop repeated ones")
    if reference.kind == "file" and not reference.file:
        raise InputError(f"{where}.file is missing", "", "give the name of a run")


def _follow_file(entry: JointLoop, arm: Arm, runs: Mapping[str, Run], duration: float) -> JointLoop:
    """Replace a reference that names a run by the run's own samples."""
    if entry.reference.kind != "file":
        return entry
    run = runs[entry.reference.file]
    j = arm.names.index(entry.joint)
    position = run.q[:, j] if run.q_ref is None else run.q_ref[:, j]
    times = run.t - run.t[0]
    kept = int(np.searchsorted(times, duration)) + 1  # the row at the end, or the first one behind it
    reference = replace(entry.reference, times=tuple(times[:kept].tolist()), values=tuple(position[:kept].tolist()))
    return replace(entry, reference=reference)
