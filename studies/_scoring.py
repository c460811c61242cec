"""What a diagnosis of a blind case got right, and the table of many of them."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure

from stribeck.gap import Diagnosis, diagnose
from stribeck.report.style import drawn, heading, new_figure
from stribeck.withheld.cases import make_case

# Parameters that plant and library mean alike: the plant's name to the library's
SAME: Mapping[str, Mapping[str, str]] = {
    "presliding": {"stiffness": "stiffness"},
    "load_dependent_friction": {"ratio": "ratio"},
    "position_dependent_friction": {"harmonic": "harmonic"},
    "actuator_lag": {"time": "time_constant"},
    "delay": {"time": "time"},
    "torque_gain": {"gain": "gain"},
    "joint_flexibility": {"stiffness": "stiffness"},
    "backlash": {"gap": "gap"},
    "encoder_eccentricity": {"harmonic": "harmonic"},
    "payload": {"mass": "mass"},
    "gravity_tilt": {"x": "x", "y": "y"},
    "cable_spring": {"stiffness": "stiffness", "rest": "rest"},
}
OUTCOMES = {  # in the order of the figure's colours
    "right": "#009e73",
    "right in a class": "#56b4e9",
    "right, and more": "#f0e442",
    "missed": "#999999",
    "wrong": "#d55e00",
    "failed": "#1f2328",
}


def run_case(label: str, effect: str | None, seed: int, known: bool) -> dict[str, Any]:
    """Record and diagnose one case; a failure is an outcome like others, not the end of the batch."""
    started = time.perf_counter()
    row: dict[str, Any] = {"label": label, "seed": seed}
    try:
        case = make_case(seed, effect, "clear")
        found = diagnose(case.arm_nominal, case.runs, seed=0, jobs=1)
        row |= score(found, case.truth["effects"], known)
        row |= {"worth": case.truth["worth"], "rate": case.truth["laboratory"]["rate"]}
        row["vertical"] = any(case.arm_true.gravity)
    except Exception as error:
        row |= {"outcome": "failed", "error": f"{type(error).__name__}: {error}", "extra": [], "parameters": []}
    return row | {"seconds": time.perf_counter() - started}


def score(found: Diagnosis, truth: Sequence[Mapping[str, Any]], known: bool = True) -> dict[str, Any]:
    """Return outcome, extra names, joints and parameters' intervals of one diagnosis.

    Parameters
    ----------
    found : Diagnosis
    truth : sequence of mapping
        ``effect``, ``joint``, ``parameters``: one hidden effect, or none.
    known : bool
        Whether the library holds the effect; if not, or without one, naming nothing is right.
    """
    named = [cause for cause in found.causes if cause.effect in found.named]
    true = truth[0] if truth and known else {"effect": None, "joint": None, "parameters": {}}
    hits = [c for c in named if true["effect"] in (c.effect, *c.equivalent)]
    extra = [c.effect for c in named if c not in hits]
    return {
        "truth": [dict(item) for item in truth],
        "outcome": _outcome(true["effect"], [c.effect for c in hits], extra),
        "named": {c.effect: {"joints": c.joints, "equivalent": c.equivalent, "presence": c.presence} for c in named},
        "extra": extra,
        "joint_right": any(true["joint"] in c.joints for c in hits) if true["effect"] else None,
        "verdict": found.verdict,
        "closed": None if found.closed is None else found.closed.value,
        "parameters": [row for c in hits if c.effect == true["effect"] for row in _parameters(c.parameters, true)],
    }


def _outcome(true: str | None, hits: Sequence[str], extra: Sequence[str]) -> str:
    if true is None:
        return "wrong" if extra else "right"
    if not hits:
        return "wrong" if extra else "missed"
    if extra:
        return "right, and more"
    return "right" if true in hits else "right in a class"


def _parameters(estimates: Mapping[str, Mapping[str, Any]], true: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return truth and interval of every parameter of the right joint that plant and library mean alike."""
    rows, own = [], estimates.get(true["joint"], {})
    for theirs, ours in SAME.get(true["effect"], {}).items():
        if theirs in true["parameters"] and ours in own:
            value, e = float(true["parameters"][theirs]), own[ours]
            inside = e.low <= value <= e.high
            rows.append({"name": ours, "true": value, "value": e.value, "low": e.low, "high": e.high, "inside": inside})
    return rows


def is_right(row: Mapping[str, Any]) -> bool:
    """Whether the true effect is among those named or listed as equivalent (or rightly none is)."""
    return str(row["outcome"]).startswith("right")


@drawn
def matrix(rows: Sequence[Mapping[str, Any]]) -> Figure:
    """Draw the outcome of every case: one line an effect, one column a case."""
    labels = list(dict.fromkeys(str(row["label"]) for row in rows))
    columns = [[row for row in rows if row["label"] == label] for label in labels]
    width, kinds = max(map(len, columns)), list(OUTCOMES)
    blank = [float("nan")] * width
    codes = [[*(float(kinds.index(row["outcome"])) for row in line), *blank][:width] for line in columns]
    figure = new_figure(1.6 + 0.34 * len(labels))
    ax = figure.add_subplot()
    norm = BoundaryNorm([k - 0.5 for k in range(len(kinds) + 1)], len(kinds))
    image = ax.imshow(codes, cmap=ListedColormap(list(OUTCOMES.values())), norm=norm, aspect="auto")
    for i, line in enumerate(columns):
        for j, row in enumerate(line):
            light = row["outcome"] in ("failed", "wrong")
            text = "\n".join(row["extra"]) or f"seed {row['seed']}"
            ax.text(j, i, text, ha="center", va="center", fontsize=7, color="white" if light else "black")
    ax.set_yticks(range(len(labels)), labels)
    ax.set_xticks(range(width), [f"case {j + 1}" for j in range(width)])
    figure.colorbar(image, ax=ax, ticks=range(len(kinds))).ax.set_yticklabels(kinds)
    right = sum(map(is_right, rows))
    heading(figure, f"{right} of {len(rows)} blind cases named right; names in a cell are those that are not there")
    return figure
