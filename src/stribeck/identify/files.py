"""The files of an identification: ``identification.json`` (``stribeck.identification/1``) and ``fitted.toml``."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from stribeck.arm import save_arm, unit_at
from stribeck.identify.findings import Direction, Identification, JointFriction
from stribeck.identify.section3 import Section3
from stribeck.identify.tustin_fit import NAMES, CurveFit
from stribeck.rounding import rounded
from stribeck.version import package_version

SCHEMA = "stribeck.identification/1"
UNITS = {"C0": "N m", "C1": "N m", "C2": "N m s/rad", "alpha": "rad/s", "velocity": "rad/s", "torque": "N m"}
DIGITS = 6


def identification_json(found: Identification) -> dict[str, Any]:
    """Return the content of ``identification.json``: plain values, null where one is not finite."""
    kind = found.nominal.joints[0].kind
    return {
        "schema": SCHEMA,
        "version": package_version(),
        "arm": found.nominal.name,
        "runs": list(found.runs),
        "units": {name: unit_at(unit, kind) for name, unit in UNITS.items()},
        "joints": {joint.name: _joint(joint) for joint in found.joints},
        "whole_runs": {
            "status": found.whole.fit.status,
            "ok": found.whole.fit.ok,
            "rms": {name: _number(value) for name, value in zip(found.nominal.names, found.whole.rms, strict=True)},
        },
        "notes": list(found.notes),
        "warnings": list(found.warnings),
    }


def write_identification(found: Identification, folder: Path | str) -> None:
    """Write ``identification.json`` and ``fitted.toml`` into an existing folder.

    Parameters
    ----------
    found : Identification
    folder : path
        Made whole by the caller (:func:`stribeck.outputs.whole_folder`).
    """
    folder = Path(folder)
    text = json.dumps(identification_json(found), indent=2, ensure_ascii=False, allow_nan=False)
    # a file name that is not UTF-8 holds lone surrogates: written as JSON escapes, not refused
    (folder / "identification.json").write_bytes((text + "\n").encode("utf-8", "backslashreplace"))
    save_arm(found.arm, folder / "fitted.toml")


def _joint(joint: JointFriction) -> dict[str, Any]:
    return {
        "asymmetry": {
            "probability_of_none": None if joint.asymmetry is None else _number(joint.asymmetry),
            "clear": joint.asymmetric,
        },
        "both": None if joint.common is None else _curve(joint.common),
        "directions": {way: _direction(one) for way, one in joint.directions.items()},
    }


def _direction(one: Direction) -> dict[str, Any]:
    return {
        "readings": {
            "velocity": [_number(point.speed) for point in one.points],
            "torque": [_number(point.torque) for point in one.points],
            "run": [point.run for point in one.points],
        },
        "source": one.source,
        "slides_steadily": one.sliding > 0,
        "section3": None if one.section3 is None else _section3(one.section3),
        "curve": _curve(one.curve),
        "runs": _constants(list(one.runs), one.runs_identified),
    }


def _section3(one: Section3) -> dict[str, Any]:
    line, saddle = one.line, one.saddle
    return {
        "ok": one.ok,
        "constants": {name: _number(value) for name, value in zip(NAMES, one.constants, strict=True)},
        "large_velocities": None if line is None else [_number(line.first), _number(line.second)],
        "break_away": None if one.break_away is None else _number(one.break_away),
        "saddle": None if saddle is None else {"velocity": _number(saddle.velocity), "torque": _number(saddle.torque)},
        "condition_2": _number(one.condition),
        "alpha_by_equation_3": [_number(value) for value in one.alphas_by_velocity],
        "amplification": _number(one.amplification),
        "remarks": list(one.remarks),
    }


def _curve(one: CurveFit) -> dict[str, Any]:
    return {
        "status": one.status,
        "ok": one.ok,
        "readings": one.points,
        "scatter": _number(one.scatter),
        "constants": _constants((one.constants, one.low, one.high), one.identified),
    }


def _constants(values: Sequence[np.ndarray], identified: np.ndarray) -> dict[str, Any]:
    """Return each constant with its interval; ``values`` are the values, the lower and the upper ends."""
    rows = zip(NAMES, *values, identified, strict=True)
    return {
        name: {"value": _number(value), "ci95": [_number(low), _number(high)], "identified": bool(sure)}
        for name, value, low, high, sure in rows
    }


def _number(value: float) -> float | None:
    return rounded(value, DIGITS)
