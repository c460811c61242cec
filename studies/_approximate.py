"""Approximate methods against shooting: errors on one loop, and counts over many."""

from __future__ import annotations

from typing import Any

from _cycles import joint, loop

from stribeck.loop.approximate import approximate
from stribeck.loop.exact.shooting import shoot
from stribeck.simulate import Loop

METHODS = {"df": "describing_function", "hb": "harmonic_balance"}


def errors(zeta: float) -> dict[str, float | None]:
    """Return the relative errors of both methods on an over-compensated Coulomb joint of known damping."""
    given = loop(1.3, "error_sign", zeta=zeta)
    found = approximate(joint("Coulomb").arm, given, "A", shoot(joint("Coulomb"), given)["A"], zeta)
    first, many = found.describing_function, found.harmonic_balance
    return {"df_amplitude": first.amplitude_error, "df_period": first.period_error,
            "hb_amplitude": many.amplitude_error, "hb_period": many.period_error}  # fmt: skip


def compare(name: str, given: Loop) -> dict[str, Any]:
    """Return whether there is a cycle, and whether each method predicts one and is trusted."""
    entry = given.joints[0]
    exact, damping = shoot(joint(name), given)["A"], (entry.kv or 0.0) / (2.0 * entry.kp**0.5)
    found = approximate(joint(name).arm, given, "A", exact, damping)
    row: dict[str, Any] = {"damping": damping, "exact": exact.cycles, "verdict": exact.verdict}
    for key, method in METHODS.items():
        answer = getattr(found, method)
        row |= {f"{key}_cycle": answer.cycle, f"{key}_trusted": answer.trusted}
        row |= {f"{key}_amplitude_error": answer.amplitude_error}
    return row


def count(rows: list[dict[str, Any]]) -> dict[str, int]:
    """Return how many cycles there are, and how many each method finds and makes up; how far trust was deserved."""
    known = [row for row in rows if row["verdict"] != "undetermined"]
    out = {"cases": len(rows), "determined": len(known), "cycles": sum(row["exact"] for row in known)}
    for m in METHODS:
        out[f"{m}_found"] = sum(row[f"{m}_cycle"] is True and row["exact"] for row in known)
        out[f"{m}_made_up"] = sum(row[f"{m}_cycle"] is True and not row["exact"] for row in known)
        out[f"{m}_missed"] = sum(row[f"{m}_cycle"] is False and row["exact"] for row in known)
        out[f"{m}_no_answer"] = sum(row[f"{m}_cycle"] is None for row in known)
        out[f"{m}_trusted"] = sum(row[f"{m}_trusted"] for row in known)
    return out
