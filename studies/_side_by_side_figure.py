"""All methods on the same cases: names, friction, time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from stribeck.report.style import COLOUR, drawn, grid, heading, new_figure, title

SHARES = {"right": ("right", COLOUR["corrected"]), "wrong": ("wrong", COLOUR["as_given"])}


@drawn
def side_by_side_figure(result: Mapping[str, Any]) -> Figure:
    """Draw per method the likeliest names right and wrong, the error of dry friction, and processor time."""
    rows = result["methods"]
    figure = new_figure(1.6 + 0.42 * len(rows), 11.0)
    names, off, cost = figure.subplots(1, 3, sharey=True, width_ratios=(1.6, 1.0, 1.0))
    at = np.arange(len(rows), dtype=float)
    for shift, (key, (label, colour)) in zip((-0.2, 0.2), SHARES.items(), strict=True):
        values = [100 * (row[key]["value"] or 0.0) for row in rows]
        names.barh(at + shift, values, 0.36, color=colour, label=f"{label}, of the cases with an effect")
    alarms = [100 * (1.0 - (1.0 if row["silent"]["value"] is None else row["silent"]["value"])) for row in rows]
    names.plot(
        alarms,
        at,
        "D",
        color=COLOUR["measured"],
        markersize=5,
        label="something named where nothing is hidden",
        clip_on=False,
    )
    names.set_yticks(at, [row["method"] for row in rows])
    names.set(xlim=(0.0, 100.0), xlabel="share of cases, %")
    title(names, "Likeliest name", 4.4)
    error = [np.nan if row["friction_error"]["C0"] is None else 100 * row["friction_error"]["C0"] for row in rows]
    off.barh(at, error, 0.6, color=COLOUR["noise_floor"])
    off.set_xlabel("error of C0, median, %")
    title(off, "Coulomb friction", 3.0)
    cost.barh(at, [row["seconds"] or np.nan for row in rows], 0.6, color=COLOUR["noise_floor"])
    cost.set_xlabel("processor time a case, s")
    title(cost, "Cost", 3.0)
    for k, value in enumerate(error):
        if np.isnan(value):
            off.text(0.0, k, " does not estimate it", va="center", fontsize=8.5)
    for ax in (off, cost):
        ax.tick_params(axis="y", length=0)
    names.invert_yaxis()
    figure.legend(loc="outside lower left", frameon=False, ncols=3, fontsize=9)
    for ax in (names, off, cost):
        grid(ax, "x")
    heading(figure, f"{result['cases']} sealed cases: what each method names, and what it costs", 11.0)
    return figure
