"""The files of a diagnosis that other tools read: ``diagnosis.json`` (``stribeck.diagnosis/1``), ``corrected.toml``."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from stribeck.arm import save_arm, unit_at
from stribeck.gap.result import (
    Candidate,
    Cause,
    Delivered,
    Diagnosis,
    Estimate,
    Place,
    RandomTorque,
    Region,
    Stage,
    Tuned,
)
from stribeck.rounding import rounded
from stribeck.run import save_run
from stribeck.version import package_version

SCHEMA = "stribeck.diagnosis/1"
NEXT_REFERENCE = "next_reference.csv"
DIGITS = 6  # significant; more would be noise, fewer would show in a parameter that is read back


def diagnosis_json(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the content of ``diagnosis.json``: plain values, stable order, six significant digits.

    Parameters
    ----------
    diagnosis : Diagnosis
        Numbers may be infinite or not a number; they become null, so that the file is JSON for every reader.
    """
    return {
        "schema": SCHEMA,
        "version": package_version(),
        "arm": diagnosis.arm,
        "runs": {"fit": list(diagnosis.fit_runs), "held_out": list(diagnosis.held_out_runs)},
        "verdict": diagnosis.verdict,
        "named": list(diagnosis.named),
        "gap": _gap(diagnosis),
        "where": [_place(place) for place in diagnosis.where],
        "causes": [_cause(cause) for cause in diagnosis.causes],
        "next_experiment": None if diagnosis.next_experiment is None else _plain(diagnosis.next_experiment),
        "warnings": list(diagnosis.warnings),
        "retuned": [_tuned(value) for value in diagnosis.tuned],
        **({"corrected": [_tuned(value) for value in diagnosis.corrected]} if diagnosis.corrected else {}),
        "regions": [_region(region) for region in diagnosis.regions],
        "recordings": [_plain(asdict(row)) for row in diagnosis.recordings],
        "candidates": [_candidate(row) for row in diagnosis.candidates],
        **({"delivered": {row.joint: _delivered(row) for row in diagnosis.delivered}} if diagnosis.delivered else {}),
        **({"random_torque": {row.joint: _random(row) for row in diagnosis.random}} if diagnosis.random else {}),
        "notes": list(diagnosis.notes),
        "settings": _plain(diagnosis.settings),
    }


def write_diagnosis(diagnosis: Diagnosis, folder: Path | str) -> None:
    """Write ``diagnosis.json`` and ``corrected.toml`` into an existing folder, and the next reference if there is one.

    Parameters
    ----------
    diagnosis : Diagnosis
        Its ``models["corrected"]`` becomes the arm file, its ``next_reference`` the run ``next_reference.csv``.
    folder : path
        Made whole by the caller (:func:`stribeck.outputs.whole_folder`).
    """
    folder = Path(folder)
    text = json.dumps(diagnosis_json(diagnosis), indent=2, ensure_ascii=False, allow_nan=False)
    # a file name that is not UTF-8 holds lone surrogates: written as JSON escapes, not refused
    (folder / "diagnosis.json").write_bytes((text + "\n").encode("utf-8", "backslashreplace"))
    save_arm(diagnosis.models["corrected"], folder / "corrected.toml")
    if diagnosis.next_reference is not None:
        save_run(diagnosis.next_reference, folder / NEXT_REFERENCE)


def _gap(diagnosis: Diagnosis) -> dict[str, Any]:
    torque, motion = _units(diagnosis)
    return {
        "metrics": {
            "torque": f"{torque}, rms per joint along the recorded motion",
            "motion": f"{motion}, rms per joint over the horizon",
        },
        "horizon": _number(diagnosis.horizon),
        "stages": [_stage(stage) for stage in diagnosis.stages],
        "closed": _estimate(diagnosis.closed),
        **({"before_measurement": _estimate(before)} if (before := diagnosis.before_measurement) else {}),
    }


def _units(diagnosis: Diagnosis) -> tuple[str, str]:
    arm = diagnosis.models.get("as_given")
    kind = "revolute" if arm is None else arm.joints[0].kind
    return unit_at("N m", kind), unit_at("rad", kind)


def _stage(stage: Stage) -> dict[str, Any]:
    return {"stage": stage.stage, "torque": _plain(stage.torque), "motion": _plain(stage.motion)}


def _place(place: Place) -> dict[str, Any]:
    named = {"joint": place.joint, "channel": place.channel, "region": place.region}
    share = {"share": _number(place.share.value), "ci95": _interval(place.share)}
    return {**named, **share, "channels": list(place.channels or (place.channel,))}


def _region(region: Region) -> dict[str, Any]:
    return {
        "joint": region.joint,
        "family": region.family,
        "region": region.region,
        "share": _number(region.share.value),
        "ci95": _interval(region.share),
        "time_share": _number(region.time_share),
        "rms": _number(region.rms),
        "rms_corrected": _number(region.rms_corrected),
    }


def _cause(cause: Cause) -> dict[str, Any]:
    if cause.effect in ("none", "unknown"):
        return {"effect": cause.effect, "probability": _number(cause.probability)}
    return {
        "effect": cause.effect,
        "joints": list(cause.joints),
        "probability": _number(cause.probability),
        "equivalent": list(cause.equivalent),
        "parameters": {
            joint: {name: _parameter(value) for name, value in values.items()}
            for joint, values in cause.parameters.items()
        },
        "closes": _estimate(cause.closes),
        **({"law": dict(cause.law)} if cause.law else {}),
        **({} if cause.presence is None else {"presence": _number(cause.presence)}),
        **({"anywhere": True} if cause.anywhere else {}),
    }


def _candidate(row: Candidate) -> dict[str, Any]:
    return {
        "step": row.step,
        "effect": row.effect,
        "joint": row.joint,
        "gain": _estimate(row.gain),
        "t": _number(row.t),
        "status": row.status,
        "chosen": row.chosen,
    }


def _delivered(row: Delivered) -> dict[str, Any]:
    return {
        "gain": _parameter(row.gain),
        "offset": _parameter(row.offset),
        "delay": _parameter(row.delay),
        "left": {"value": _number(row.left), "unit": row.offset.unit},
        "share": _estimate(row.share),
    }


def _random(row: RandomTorque) -> dict[str, Any]:
    return {
        "rms": {"value": _number(row.rms), "unit": row.unit},
        "bandwidth": {"value": _number(row.bandwidth), "unit": "Hz"},
    }


def _tuned(value: Tuned) -> dict[str, Any]:
    return {
        "key": value.key,
        "unit": value.unit,
        "nominal": _number(value.nominal),
        "tolerance": _number(value.tolerance),
        "value": _number(value.tuned.value),
        "ci95": _interval(value.tuned),
        "at_limit": value.at_limit,
        "identified": value.identified,
        "moved": value.moved,
    }


def _parameter(estimate: Estimate) -> dict[str, Any]:
    return {"value": _number(estimate.value), "unit": estimate.unit, "ci95": _interval(estimate)}


def _estimate(estimate: Estimate | None) -> dict[str, Any] | None:
    if estimate is None:
        return None
    return {"value": _number(estimate.value), "ci95": _interval(estimate)}


def _interval(estimate: Estimate) -> list[float | None]:
    return [_number(estimate.low), _number(estimate.high)]


def _number(value: float) -> float | None:
    """Return ``value`` at six significant digits, null where it is not finite."""
    return rounded(value, DIGITS)


def _plain(value: Any) -> Any:
    """Return mappings, sequences, numbers and text as JSON has them; anything else as text."""
    if value is None or isinstance(value, (str, bool, int)):
        return value
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (np.ndarray, np.generic)):
        return _plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    return _number(value) if isinstance(value, float) else str(value)
