"""The candidates of each search step, ranked by what they gain on held-out runs, with intervals."""

from __future__ import annotations

import math

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stribeck.gap.result import Candidate, Diagnosis
from stribeck.report import words
from stribeck.report.candidates_order import judged, ranked
from stribeck.report.numbers import percent, percent_interval
from stribeck.report.style import COLOUR, INK, MUTED, WIDTH, drawn, grid, heading, new_figure, title

MOST = 14  # rows of one step; the rest is counted, and listed in diagnosis.json
LABELS = 0.075  # inches that a letter of a row's label takes from its panel
LOWEST = -0.25  # gains below are drawn at the edge, with an arrow


@drawn
def candidates_figure(diagnosis: Diagnosis) -> Figure | None:
    """Draw one panel per search step; None where nothing was searched."""
    steps = sorted({row.step for row in diagnosis.candidates})
    if not steps:
        return None
    shown = {step: ranking(diagnosis, step) for step in steps}
    heights = [0.9 + 0.25 * len(rows) for rows in shown.values()]
    figure = new_figure(0.7 + sum(heights))
    axes = figure.subplots(len(steps), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    every = [_label(row) for rows in shown.values() for row in rows]  # the panels' left ends agree
    labels = max(map(len, every), default=0)
    for step, ax in zip(steps, axes, strict=True):
        draw_ranking(ax, shown[step], partners(diagnosis, step), diagnosis.named)
        title(ax, _panel(diagnosis, step, shown[step]), WIDTH - LABELS * labels - 0.5)
    ends = [x for rows in shown.values() for row in rows for x in (row.gain.low, row.gain.high) if math.isfinite(x)]
    axes[-1].set_xlim(max(min(ends, default=0.0), LOWEST) - 0.02, min(max(ends, default=1.0), 1.5) + 0.05)
    axes[-1].xaxis.set_major_formatter(lambda x, _: percent(round(x, 3)))
    axes[-1].set_xlabel(
        f"part of the squared residual{_over(diagnosis)} that the candidate removes, held-out (95 % interval)"
    )
    heading(figure, _finding(diagnosis))
    return figure


def ranking(diagnosis: Diagnosis, step: int) -> list[Candidate]:
    """Return the rows of one step to draw, best first: the leading ones, the chosen one and its partners."""
    rows = ranked(diagnosis, step)
    same = partners(diagnosis, step)
    extra = [row for row in rows[MOST:] if row.chosen or _key(row) in same]
    return sorted([*rows[: MOST - len(extra)], *extra], key=lambda row: -row.gain.value)


def partners(diagnosis: Diagnosis, step: int) -> frozenset[tuple[str, str]]:
    """Return (effect, joint) of the candidates that these data cannot tell from the one chosen in that step."""
    rows = [row for row in diagnosis.candidates if row.step == step]
    found = set()
    for chosen in (row for row in rows if row.chosen):
        for effect in words.cause_of(diagnosis, chosen.effect).equivalent:
            same = [row for row in rows if row.effect == effect and not row.chosen and judged(row)]
            here = [row for row in same if row.joint == chosen.joint] or same
            if here and effect != chosen.effect:
                found.add(_key(max(here, key=lambda row: row.gain.value)))
    return frozenset(found)


def draw_ranking(
    ax: Axes, rows: list[Candidate], same: frozenset[tuple[str, str]], named: tuple[str, ...] = ()
) -> Axes:
    """Draw candidates from top to bottom, the chosen one filled, its partners as diamonds; return ``ax``."""
    for place, row in enumerate(rows):
        _draw_row(ax, place, row, _key(row) in same, row.effect in named)
    ax.axvline(0.0, color=MUTED, linewidth=0.8)
    ax.set_yticks(range(len(rows)), [_label(row) for row in rows])
    for tick, row in zip(ax.get_yticklabels(), rows, strict=True):
        tick.set_fontweight("bold" if row.chosen else "normal")
    ax.set_ylim(max(len(rows), 1) - 0.4, -0.6)
    ax.tick_params(axis="y", length=0, labelcolor=INK)
    grid(ax, "x")
    return ax


def _draw_row(ax: Axes, place: int, row: Candidate, partner: bool, named: bool) -> None:
    colour = COLOUR["corrected"] if row.chosen else COLOUR["partner"] if partner else COLOUR["noise_floor"]
    marker = "o" if row.chosen else "D" if partner else "o"
    low, high = (x if math.isfinite(x) else row.gain.value for x in (row.gain.low, row.gain.high))
    if row.gain.value < LOWEST:
        ax.plot(LOWEST, place, marker="<", color=colour, markersize=6)
        note, at = f"{percent(row.gain.value)}", LOWEST
    else:
        ax.plot([max(low, LOWEST), high], [place, place], color=colour, linewidth=1.8, solid_capstyle="butt")
        face = colour if row.chosen else "white"
        ax.plot(
            row.gain.value, place, marker=marker, color=colour, markerfacecolor=face, markersize=7 if row.chosen else 6
        )
        note, at = "", high
    notes = [
        note,
        ("chosen" if named else "best, not named") if row.chosen else "",
        "cannot be told apart" if partner else "",
        _trouble(row.status),
    ]
    text = ", ".join(part for part in notes if part)
    ax.annotate(
        text, (at, place), xytext=(8, 0), textcoords="offset points", va="center", fontsize=9,
        color=colour if row.chosen or partner else MUTED, fontweight="bold" if row.chosen else "normal",
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.0} if text else None,
    )  # fmt: skip


def _trouble(status: str) -> str:
    # a fit by secants ends where its steps are lost among the wrinkles of the cost, unless it is stopped
    fine = status in ("", "ok") or status.lower().startswith(("solve_succeeded", "solved", "no_further_descent"))
    # the solver's word for an end that its caller set: nobody asked the reader
    plain = "not converged" if status == "User_Requested_Stop" else status.replace("_", " ").lower()
    return "" if fine else words.short(plain, 40)


def _key(row: Candidate) -> tuple[str, str]:
    return row.effect, row.joint


def _label(row: Candidate) -> str:
    name = words.effect(row.effect)
    return f"{name} · {words.short(row.joint, 20)}" if row.joint else name


def _panel(diagnosis: Diagnosis, step: int, shown: list[Candidate]) -> str:
    total = sum(row.step == step for row in diagnosis.candidates)
    screened = sum(row.step == step and not judged(row) for row in diagnosis.candidates)
    rest = total - screened - len(shown)
    counts = [f"{total} candidate{'s' * (total != 1)}"]
    counts += [f"{screened} screened out"] if screened else []
    counts += [f"{rest} lower not shown"] if rest else []
    chosen = [row for row in shown if row.chosen]
    done = [f"{_label(row)} {words.chosen(diagnosis, row.effect)}" for row in chosen]
    what = words.listing(done) or "nothing added"
    return f"Step {step}: {what} ({', '.join(counts)})"


def _over(diagnosis: Diagnosis) -> str:
    return ", multiplied over the joints," if len(diagnosis.joints) > 1 else ""


def _finding(diagnosis: Diagnosis) -> str:
    chosen = [row for row in diagnosis.candidates if row.chosen]
    if not chosen and diagnosis.named:
        return f"No candidate shows enough to be added; {words.named(diagnosis).lower()} shows in the records"
    if not chosen:
        return "No candidate shows enough to be added"
    first = next((row for row in chosen if row.effect in diagnosis.named), None)
    if first is None:
        return "What was tried is not sure enough to be named"
    cause = words.cause_of(diagnosis, first.effect)
    names = [words.effect(name) for name in (cause.equivalent or (first.effect,))]
    closes = f" closes {percent_interval(cause.closes)} of the gap" if cause.closes else ""
    if len(names) > 1:
        either = words.listing(names, "or")
        return f"{either[0].upper()}{either[1:]}: these data cannot tell{'; the first' * bool(closes)}{closes}"
    if len(diagnosis.named) > 1:
        return f"{words.named(diagnosis)}: all runs together decided; here, what each removes on held-out ones"
    return f"{words.named(diagnosis)} at {words.short(first.joint)}{closes or ' is added'}, held-out"
