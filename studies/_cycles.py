"""One joint of 1 kg m^2 under loops whose cycles are asked for; figures of branches."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np
from _paper import joint_of_one
from _single import coulomb
from matplotlib.figure import Figure

from stribeck.loop.exact.engine import RoundsEngine
from stribeck.report.style import COLOUR, MUTED, drawn, end_labels, grid, heading, new_figure, title
from stribeck.simulate import Compensation, JointLoop, Loop, Reference

LINES = (COLOUR["corrected"], COLOUR["as_given"], COLOUR["partner"], COLOUR["retuned"])


@cache
def joint(name: str) -> RoundsEngine:
    """Return the engine of joint ``A`` or ``B``, or of one with ``Coulomb`` friction alone."""
    return RoundsEngine(coulomb().path.arm if name == "Coulomb" else joint_of_one(name).path.arm)


def loop(
    ratio: float | None = None, at_zero: str = "set_valued", *, zeta: float = 1.0, kind: str = "feedback",
    kp: float = 30.0, reference: Reference | None = None, sample_time: float = 0.0, **settings: Any,
) -> Loop:  # fmt: skip
    """Return a loop at a damping ratio (of the rigid joint of 1 kg m^2), in regulation from 0.5 rad unless told."""
    law = Compensation() if ratio is None else Compensation(kind, ratio, at_zero)  # type: ignore[arg-type]
    to = reference or Reference("regulate", initial_error=0.5)
    entry = JointLoop("A", kp, to, kv=2.0 * zeta * math.sqrt(kp), compensation=law, **settings)
    return Loop(sample_time, 60.0, (entry,))


def rho(zeta: float) -> float:
    """Return by how much half a swing shrinks."""
    return math.exp(-math.pi * zeta / math.sqrt(1.0 - zeta**2))


Branch = tuple[Sequence[float], Sequence[float | None]]


@drawn
def branches_figure(
    panels: Mapping[str, tuple[str, str, Mapping[str, Branch], Mapping[str, Branch]]], finding: str
) -> Figure:
    """Draw a panel for each title: x and y label, branches as dots, and laws of the same names as lines."""
    figure = new_figure(3.9)
    for ax, (name, (x, y, dots, laws)) in zip(np.ravel(figure.subplots(1, len(panels))), panels.items(), strict=True):
        ends = []
        for colour, (label, (at, values)) in zip(LINES, dots.items(), strict=False):
            shown = [np.nan if value is None else value for value in values]
            ax.plot(at, shown, "o" if label in laws else "o-", color=colour, markersize=4, linewidth=1.0)
            if label in laws:
                ax.plot(*laws[label], color=colour, linewidth=1.0)
            finite = [value for value in shown if np.isfinite(value)]
            ends.append((finite[-1] if finite else 0.0, label, colour))
        ax.set(xlabel=x, ylabel=y)
        ax.set_ylim(bottom=min(0.0, ax.get_ylim()[0]) if "ratio" not in y else None)
        end_labels(ax, ends)
        ax.axhline(0.0 if "ratio" not in y else 1.0, color=MUTED, linewidth=0.5)
        grid(ax)
        title(ax, name, 7.2 / len(panels))
    heading(figure, finding)
    return figure
