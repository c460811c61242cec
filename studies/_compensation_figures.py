"""Figures 8 to 10: position error with and without compensation."""

from __future__ import annotations

from collections.abc import Mapping

from matplotlib.figure import Figure

from stribeck.report.style import COLOUR, MUTED, drawn, grid, heading, new_figure, title
from stribeck.simulate import Closed

STYLES = {
    "none": {"color": COLOUR["as_given"], "linestyle": ":", "linewidth": 1.6, "label": "no compensation"},
    "90 %": {"color": COLOUR["corrected"], "linestyle": "-", "linewidth": 1.2, "label": "compensated, model 10 % low"},
    "exact": {"color": COLOUR["partner"], "linestyle": "-", "linewidth": 1.0, "label": "compensated, exact model"},
}


@drawn
def error_figure(runs: Mapping[tuple[float, str], Closed], joint: int, what: str) -> Figure:
    """Draw the error over time, one panel a gain."""
    gains = list(dict.fromkeys(kp for kp, _ in runs))
    figure = new_figure(3.8)
    axes = figure.subplots(1, len(gains), sharey=True)
    for ax, kp in zip(axes, gains, strict=True):
        left = {}
        for label, style in STYLES.items():
            found = runs[kp, label]
            error = 1e3 * found.error[:, joint]
            ax.plot(found.motion.t, error, **style)
            left[label] = error[len(error) // 2 :].mean()
        ax.axhline(0.0, color=MUTED, linewidth=0.5)
        title(ax, f"Kp {kp:g}: {left['none']:.3g}, {left['90 %']:.1f} and {abs(left['exact']):.1f} mrad are left", 4.4)
        ax.set_xlabel("time, s")
        grid(ax)
    axes[0].set_ylabel("position error, mrad")
    axes[0].legend(frameon=False, fontsize=9, loc="upper left")
    heading(figure, f"{what}: a model 10 % low leaves 10 % of the error, at either gain")
    return figure
