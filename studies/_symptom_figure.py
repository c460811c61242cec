"""The picture of a symptom: without the effect in grey, with it in colour, and its law in black on top."""

from __future__ import annotations

import io
import textwrap

import numpy as np
from _symptom_values import Points, Symptom
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image

from stribeck.model.effect import Effect
from stribeck.report import words
from stribeck.report.figures.log_ticks import plain_log
from stribeck.report.style import COLOUR, INK, MUTED, drawn, grid, key, new_figure, png

SIDES = {1: "#0072b2", -1: "#d55e00", 0: COLOUR["noise_floor"]}
BINS, LEAST = 40, 5  # of the line that goes through the law's points, and points in one
WIDEST = 3  # bins that the line passes without points
REACH = 99.3  # %, of the points that the axes hold
TELLING, BESIDE = 0.995, 0.5  # of the law's square that the axis holds, and how much of that stretch on either side
COLOURS = 64  # of a picture that is shipped
SPEEDS = (0.3, 1.0, 2.0, 4.0)  # labelled where the axis is a root
ACROSS = 3  # pictures in a row of the sheet


def _root(x: np.ndarray) -> np.ndarray:
    return np.sign(x) * np.sqrt(np.abs(x))


def _square(x: np.ndarray) -> np.ndarray:
    return np.sign(x) * np.square(x)


def _power_of_ten(x: np.ndarray) -> np.ndarray:
    return 10.0**x


SAME = (np.asarray, np.asarray)  # from the axis to where it is drawn, and back
SCALES = {"log x": (np.log10, _power_of_ten), "root x": (_root, _square)}


@drawn
def symptom_figure(effect: Effect, symptom: Symptom) -> Figure:
    """Draw one effect's symptom: two panels on the same axes."""
    figure = new_figure(2.6, 6.6)
    left, right = figure.subplots(1, 2, sharex=True, sharey=True)
    draw(left, symptom.without, symptom, plain=True)
    draw(right, symptom.with_it, symptom)
    _limits(right, symptom)
    left.set_ylabel("\n".join(textwrap.wrap(symptom.ylabel, 28)))
    for ax in (left, right):
        ax.set_xlabel(symptom.xlabel)
    left.set_title(words.effect(effect.name).capitalize())
    key(left, [("without", SIDES[0])])
    sides = zip(symptom.sides, (SIDES[1], SIDES[-1]), strict=True) if symptom.sides else [("with", SIDES[1])]
    key(right, [*sides, ("law", INK)])
    return figure


def draw(ax: Axes, points: Points, symptom: Symptom, *, plain: bool = False) -> None:
    """Draw the points of one recording by their side, and the law through them."""
    style = {"linewidth": 2.2} if symptom.joined else {"linestyle": "", "marker": ".", "markersize": 2.2}
    for side, colour in SIDES.items():
        some = points.side == side
        if some.any():
            ax.plot(points.x[some], points.y[some], color=SIDES[0] if plain else colour, alpha=0.7, **style)
    if points.law is not None:
        for x, y in _lines(points, symptom):
            if not symptom.joined:
                ax.plot(x, y, color="white", linewidth=2.6)
            ax.plot(x, y, color=INK, linewidth=0.8 if symptom.joined else 1.2)
    if symptom.axes != "log y":
        ax.axhline(0.0, color=MUTED, linewidth=0.5, zorder=0)
    grid(ax)


def _lines(points: Points, symptom: Symptom) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the law's line: as it is where points are joined, else the median of its points, for each side."""
    assert points.law is not None
    if symptom.joined:
        return [(points.x, points.law)]
    scale = SCALES.get(symptom.axes, SAME)[0](points.x)
    edges = np.linspace(*_telling(scale[np.isfinite(scale)], points.law[np.isfinite(scale)]), BINS + 1)
    lines = []
    for side in (1, -1):
        mine = points.side == side
        place = np.digitize(scale, edges)
        groups = [np.flatnonzero(mine & (place == k)) for k in range(1, BINS + 1)]
        full = np.array([k for k, some in enumerate(groups) if len(some) >= LEAST], dtype=int)
        x, y = (np.array([np.median(values[groups[k]]) for k in full]) for values in (points.x, points.law))
        gaps = np.flatnonzero(np.diff(full) > WIDEST) + 1
        lines.append((np.insert(x, gaps, np.nan), np.insert(y, gaps, np.nan)))
    return lines


def _limits(ax: Axes, symptom: Symptom) -> None:
    """Hold the stretch of the axis in which the law takes nearly all, and half as much beside it, and most points.

    The few beyond are spikes at reversals, which say nothing of the effect.
    """
    points = symptom.with_it
    assert points.law is not None
    if symptom.axes == "log y":
        ax.set_yscale("log")
        ax.set_xlim(0.0, points.x.max())
        ax.set_ylim(0.3 * float(np.median(symptom.without.y)), 2.0 * float(points.y.max()))
        plain_log(ax.yaxis)
        return
    there, back = SCALES.get(symptom.axes, SAME)
    seen = np.isfinite(points.x)
    x, y, law = there(points.x[seen]), points.y[seen], points.law[seen]
    low, high = (x.min(), x.max()) if symptom.whole else _telling(x, law)
    if symptom.axes == "log x":
        ax.set_xscale("log")
    elif symptom.axes == "root x":
        ax.set_xscale("function", functions=(there, back))
        ax.set_xticks([-speed for speed in reversed(SPEEDS)] + [0.0, *SPEEDS])
        ax.xaxis.set_major_formatter("{x:g}")
    ax.set_xlim(*back(np.array([low, high])))
    if symptom.axes == "log x":
        plain_log(ax.xaxis)
    bottom, top = np.percentile(y[(x >= low) & (x <= high)], [100 - REACH, REACH])
    ax.set_ylim(bottom - 0.15 * (top - bottom), top + 0.15 * (top - bottom))


def _telling(x: np.ndarray, law: np.ndarray) -> tuple[float, float]:
    order = np.argsort(x)
    share = np.cumsum(law[order] ** 2)
    low, high = np.interp(np.array([1.0 - TELLING, TELLING]) * share[-1], share, x[order])
    beside = BESIDE * (high - low)
    return max(low - beside, x.min()), min(high + beside, x.max())


def small_png(figure: Figure) -> bytes:
    """Return the figure as a PNG of few colours."""
    out = io.BytesIO()
    with Image.open(io.BytesIO(png(figure))) as image:
        image.convert("RGB").resize((image.width * 2 // 3, image.height * 2 // 3), Image.Resampling.LANCZOS).quantize(
            COLOURS
        ).save(out, "png", optimize=True)
    return out.getvalue()


def contact_sheet(pictures: list[bytes]) -> bytes:
    """Return all pictures on one sheet, row by row, as a PNG."""
    images = [Image.open(io.BytesIO(picture)).convert("RGB") for picture in pictures]
    wide, high = max(image.width for image in images), max(image.height for image in images)
    sheet = Image.new("RGB", (ACROSS * wide, -(-len(images) // ACROSS) * high), "white")
    for k, image in enumerate(images):
        sheet.paste(image, ((k % ACROSS) * wide, (k // ACROSS) * high))
    sheet = sheet.resize((sheet.width * 3 // 5, sheet.height * 3 // 5), Image.Resampling.LANCZOS)
    out = io.BytesIO()
    sheet.quantize(COLOURS).save(out, "png", optimize=True)
    return out.getvalue()
