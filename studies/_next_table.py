"""The next experiment's cases in words and in counts, per method."""

from __future__ import annotations

from typing import Any

import numpy as np
from _next_answers import METHODS

from stribeck.blind.rates import rate


def counts(row: dict[str, Any]) -> bool:
    """Whether a case is open, and a motion might settle it."""
    return bool(row["open"] and not row["exact"])


def in_words(row: dict[str, Any]) -> str:
    start = f"{row['seed']} {row['effect']}: "
    if not row["open"]:
        return start + (row.get("error") or f"not open, {row['before']['verdict']} {row['before']['named']}")
    if row["experiment"] is None:
        return start + "open, no experiment within the torque"
    after = ", ".join(f"{name} {'yes' if one['right'] else one.get('named')}" for name, one in row["after"].items())
    return start + f"open, {row['experiment']['kind']}: {after}"


def summary(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Return counts per method, those of changes proposed for what no motion tells apart, times, and all rows."""
    counted = [row for row in rows if counts(row)]
    exact = [row for row in rows if row["open"] and row["exact"] and row["experiment"] is not None]
    tried = [row for row in counted if row["experiment"] is not None]
    kinds = [row["experiment"]["kind"] for row in tried]
    return {
        "schema": "stribeck.study.next_experiment/1",
        "units": {"seconds": "s of processor time"},
        "recorded": len(rows),
        "open": len(counted),
        "resolved": {name: rate(_settled(row, name) for row in counted) for name in METHODS},
        "wrong": {name: rate(bool(row["after"][name].get("wrong")) for row in tried) for name in METHODS},
        "proposed": {kind: kinds.count(kind) for kind in ("motion", "change")},
        "no_motion_tells": rate(row["after"]["proposed"]["right"] for row in exact),
        "seconds": {"design": _middle([row["seconds"]["design"] for row in counted]),
                    "diagnosis": _middle([row["seconds"]["diagnosis"] for row in rows if "seconds" in row])},
        "rows": rows,
    }  # fmt: skip


def _settled(row: dict[str, Any], method: str) -> bool:
    return bool(row["experiment"] is not None and row["after"][method]["right"])


def _middle(values: list[float]) -> float | None:
    return float(np.median(values)) if values else None
