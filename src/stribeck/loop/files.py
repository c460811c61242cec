"""The file of a limit-cycle analysis: ``limit_cycle.json`` (``stribeck.limit_cycle/1``)."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from stribeck.arm import unit_at
from stribeck.loop.answers import Analysis, Branch, JointAnswer, Method
from stribeck.loop.linear import Margins
from stribeck.rounding import rounded
from stribeck.version import package_version

SCHEMA = "stribeck.limit_cycle/1"
DIGITS = 8
MOTION = {  # at a revolute joint
    "amplitude": "rad", "peak_velocity": "rad/s", "steady_error": "rad", "kp_max": "N m/rad", "kp": "N m/rad",
    "kv": "N m s/rad", "inertia": "kg m^2", "fold_velocity": "rad/s", "velocity": "rad/s",
}  # fmt: skip
UNITS = {  # at any: rad is here of a frequency or a phase
    "period": "s", "stick_fraction": "1", "multipliers": "1", "k_critical": "1", "phase_margin": "rad",
    "delay_margin": "s", "gain_margin": "1", "sensitivity_peak": "1", "bandwidth": "rad/s", "damping": "1",
    "amplitude_error": "relative", "period_error": "relative", "omega": "rad/s",
}  # fmt: skip


def limit_cycle_json(analysis: Analysis) -> dict[str, Any]:
    """Return the content of ``limit_cycle.json``: plain values, null where there is none."""
    kind = analysis.joints[0].kind  # a prismatic axis is the only joint of its arm
    content = {
        "schema": SCHEMA,
        "version": package_version(),
        "arm": analysis.arm,
        "sample_time": analysis.sample_time,
        "seed": analysis.seed,
        "units": {name: unit_at(unit, kind) for name, unit in MOTION.items()} | UNITS,
        "joints": {answer.joint: _joint(answer) for answer in analysis.joints},
    }
    plain: dict[str, Any] = _plain(content)
    return plain


def write_limit_cycle(analysis: Analysis, folder: Path) -> None:
    """Write ``limit_cycle.json`` into an existing folder."""
    text = json.dumps(limit_cycle_json(analysis), indent=2, ensure_ascii=False, allow_nan=False)
    (folder / "limit_cycle.json").write_text(text + "\n", encoding="utf-8")


def _joint(answer: JointAnswer) -> dict[str, Any]:
    cycle = answer.cycle
    return {
        "kind": answer.kind,
        "verdict": cycle.verdict,
        "status": cycle.status,
        "forced_by": None if answer.forced is None else answer.forced.cause,
        "amplitude": cycle.amplitude,
        "period": cycle.period,
        "peak_velocity": cycle.peak_velocity,
        "stick_fraction": cycle.stick_fraction,
        "multipliers": list(cycle.multipliers),
        "stable": cycle.stable,
        "steady_error": cycle.steady_error,
        "basin": dict(cycle.basin),
        "k_critical": answer.k_critical,
        "fold_velocity": answer.fold_velocity,
        "kp_max": {"stability": answer.kp_max.stability, "ms2": answer.kp_max.ms2, "why": answer.kp_max.why},
        "gains": {"kp": answer.kp, "kv": answer.kv, "ratio": answer.ratio, "inertia": answer.inertia},
        "margins": _margins(answer.margins),
        "methods": {name: _method(method) for name, method in answer.methods.items()},
        "describing_function_roots": [
            {"velocity": root.velocity, "omega": root.omega, "stable": root.stable}
            for root in (answer.nyquist.roots if answer.nyquist else ())
        ],
        "branch": None if answer.branch is None else _branch(answer.branch),
        "notes": list(answer.notes),
    }


def _method(method: Method) -> dict[str, Any]:
    return {
        "status": method.status,
        "cycle": method.cycle,
        "trusted": method.trusted,
        "why": method.why,
        "amplitude": method.amplitude,
        "period": method.period,
        "stable": method.stable,
        "amplitude_error": method.amplitude_error,
        "period_error": method.period_error,
    }


def _margins(margins: Margins) -> dict[str, Any]:
    return {
        "stable": margins.stable,
        "gain_margin": margins.gain_margin,
        "phase_margin": margins.phase_margin,
        "delay_margin": margins.delay_margin,
        "sensitivity_peak": margins.sensitivity_peak,
        "bandwidth": margins.bandwidth,
        "damping": margins.damping,
    }


def _branch(branch: Branch) -> dict[str, Any]:
    return {
        "setting": branch.setting,
        "values": list(branch.values),
        "verdicts": [cycle.verdict for cycle in branch.cycles],
        "amplitude": [cycle.amplitude for cycle in branch.cycles],
        "period": [cycle.period for cycle in branch.cycles],
        "describing_function_amplitude": list(branch.predicted),
    }


def _plain(value: Any) -> Any:
    """Return a value as JSON has it: complex numbers as [real, imaginary], what is not finite as null."""
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, complex):
        return [_plain(value.real), _plain(value.imag)]
    if isinstance(value, (str, bool, int)) or value is None:
        return value
    return rounded(value, DIGITS)
