"""The order in which candidates are listed and drawn."""

from __future__ import annotations

import math

from stribeck.gap.result import Candidate, Diagnosis

SCREENED_OUT = "screened out"


def ranked(diagnosis: Diagnosis, step: int) -> list[Candidate]:
    """Return the candidates of one step that were judged on held-out runs, best first."""
    rows = [row for row in diagnosis.candidates if row.step == step and judged(row)]
    return sorted(rows, key=lambda row: -row.gain.value)


def judged(row: Candidate) -> bool:
    """Return whether a candidate was fitted and judged on held-out runs, not screened out before."""
    return row.status != SCREENED_OUT and math.isfinite(row.gain.value)
