"""The map: what the loop does over Kp and k (or what stands in for it), cycles coloured by their amplitude."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import ListedColormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from stribeck.loop.answers import JointAnswer
from stribeck.loop.cycle import CYCLES, VERDICTS
from stribeck.loop.maps import Map
from stribeck.loop.ripple import DITHER
from stribeck.report import words
from stribeck.report.cycle_words import at_rest, gain_unit, on_a_ramp, small_unit, when_forced
from stribeck.report.figures.log_ticks import plain_log
from stribeck.report.numbers import percent
from stribeck.report.style import COLOUR, INK, RULE, drawn, heading, new_figure

LABEL = {
    "k": "k, compensation over true friction",
    "zeta": "damping ratio Kv / (2 √(Kp J))",
    "ki": "Ki, N m/(rad s)",
    "velocity": "speed of the ramp, rad/s",
}
SPREAD = 30.0  # of the median amplitude, up to which colours differ
MOSTLY = {"stick_slip": "in stick-slip", "hunting": "hunting", "sliding_cycle": "without sticking",
          "chatter": "in chatter"}  # fmt: skip
PLAIN = {"rest": ("#eef2f5", "rest"), "unbounded": (COLOUR["measured"], "unbounded"),
         "undetermined": (COLOUR["retuned"], "undetermined")}  # fmt: skip
FORCED = "#b3dfd0"


@drawn
def map_figure(answer: JointAnswer) -> Figure | None:
    """Draw one joint's map; None where there is none."""
    if answer.map is None:
        return None
    figure = new_figure(5.0, 8.0)
    ax = figure.add_subplot()
    shades = draw_map(ax, answer.map, answer)
    if shades is not None:
        over = "max" if np.nanmax(np.ma.asarray(shades.get_array())) > shades.norm.vmax else "neither"
        label = f"amplitude of the cycle, {small_unit(answer)}"
        bar = figure.colorbar(shades, ax=ax, label=label, pad=0.02, extend=over)
        plain_log(bar.ax.yaxis)
    heading(figure, _finding(answer), 8.0)
    return figure


def draw_map(ax: Axes, found: Map, answer: JointAnswer) -> QuadMesh | None:
    """Draw verdicts as plain colours and cycles by amplitude; return what a colour bar needs, None without cycles."""
    gains, across = found.axes.values
    name = found.axes.names[1]
    label = LABEL[name] if answer.kind == "revolute" else LABEL[name].replace("rad", "m").replace("N m", "N")
    ax.set(xlabel=label, ylabel=f"Kp, {gain_unit(answer)}", yscale="log")
    plain_log(ax.yaxis)
    if name in ("ki", "velocity"):
        across = np.abs(across)  # a ramp may go backward
        ax.set_xscale("log")
        plain_log(ax.xaxis)
    patches, forced = [], _forced(answer)
    named = {**PLAIN, "rest": (PLAIN["rest"][0], at_rest(answer)), "forced": (FORCED, when_forced(answer))}
    for verdict, (colour, text) in named.items():
        here = forced if verdict == "forced" else found.codes == VERDICTS.index(verdict)
        if here.any():
            layer = np.where(here, 1.0, np.nan)
            ax.pcolormesh(across, gains, layer, cmap=ListedColormap([colour]), shading="nearest", rasterized=True)
            patches.append(Patch(facecolor=colour, edgecolor=RULE, label=text))
    ax.legend(handles=patches, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncol=4, frameon=False, fontsize=9)
    ax.plot([_own(answer, name)], [answer.kp], "o", color=INK, markerfacecolor="white", markersize=8, zorder=5)
    ax.annotate(
        "this loop", (_own(answer, name), answer.kp), xytext=(8, 5), textcoords="offset points", fontsize=9, color=INK,
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.0, "alpha": 0.8},
    )  # fmt: skip
    own = np.isfinite(found.amplitude) & (found.amplitude > 0.0) & ~_forced(answer)
    amplitude = np.where(own, 1e3 * found.amplitude, np.nan)
    if not np.isfinite(amplitude).any():
        return None
    low, high = float(np.nanmin(amplitude)), float(np.nanmax(amplitude))
    high = min(high, SPREAD * float(np.nanmedian(amplitude)))  # a few cells near instability must not take all colours
    norm = LogNorm(min(max(low, 1e-4 * high), high), 1.0001 * high)
    return ax.pcolormesh(across, gains, amplitude, cmap="viridis_r", norm=norm, shading="nearest", rasterized=True)


def _forced(answer: JointAnswer) -> NDArray[np.bool_]:
    """Return the cells whose motion a dither or the arm's waves force, at the ramp of each."""
    found = answer.map
    assert found is not None
    speed = abs(answer.entry.reference.velocity)
    faster = np.abs(found.axes.values[1]) / speed if found.axes.names[1] == "velocity" else 1.0
    forced = np.zeros(found.codes.shape, dtype=bool)
    for each in answer.passes:
        codes = [code for code, verdict in enumerate(VERDICTS) if each.explains(verdict)]
        period = found.period * (1.0 if each.cause == DITHER else faster)  # at the loop's own ramp
        forced |= np.isin(found.codes, codes) & each.keeps(period)
    return forced


def _own(answer: JointAnswer, name: str) -> float:
    entry = answer.entry
    if name == "k":
        return answer.ratio
    if name == "ki":
        return entry.ki
    if name == "velocity":
        return abs(entry.reference.velocity)
    return answer.kv / (2.0 * float(np.sqrt(answer.kp * answer.inertia)))


def _finding(answer: JointAnswer) -> str:
    assert answer.map is not None
    name, codes = words.short(answer.joint), answer.map.codes
    forced = _forced(answer)
    shares = {label: float(np.mean((codes == k) & ~forced)) for k, label in enumerate(VERDICTS) if label in CYCLES}
    cycling = sum(shares.values())
    others = _others(answer, codes, forced)
    if cycling > 0.0:
        most = MOSTLY[max(shares, key=lambda verdict: shares[verdict])]
        return "; ".join((f"{name}: {percent(cycling)} of the map cycles, mostly {most}", *others))
    known = not (codes == VERDICTS.index("undetermined")).any()
    none = f"{name}: no cycle {'anywhere' if known else 'found'} on the map"
    return none if (codes == VERDICTS.index("rest")).all() else f"{none}: {'; '.join(others)}"


def _others(answer: JointAnswer, codes: NDArray[np.int8], forced: NDArray[np.bool_]) -> list[str]:
    """Return the shares of the map that do not cycle, in words."""
    rests = "slides steadily" if on_a_ramp(answer) else "comes to rest"
    told = {"rest": rests, "unbounded": "grows without bound", "undetermined": "is undetermined"}
    shares = {f"is a {when_forced(answer)}": float(np.mean(forced))}
    shares |= {text: float(np.mean(codes == VERDICTS.index(verdict))) for verdict, text in told.items()}
    return [f"{percent(share)} {text}" for text, share in shares.items() if share > 0.0]
