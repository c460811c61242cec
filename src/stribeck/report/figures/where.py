"""The map of where: for each joint, how what the re-tuned model leaves beyond noise spreads over regions."""

from __future__ import annotations

from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from stribeck.gap.result import Diagnosis, Region
from stribeck.report import sentences, words
from stribeck.report.numbers import number, percent
from stribeck.report.style import INK, MUTED, RULE, WIDTH, drawn, heading, new_figure

SHADES = LinearSegmentedColormap.from_list("share", ["#ffffff", "#fde3b8", "#f3ae4a", "#b9560d", "#6b2700"])
ROOMY = 4  # joints up to which a cell has space for more than its share
TWICE = ("direction", "at rest")  # the samples that are "stuck" by motion


@dataclass(frozen=True)
class MapRow:
    """One row of the map: a region of a family, at height ``y``.

    ``label`` is empty where each joint splits the family in its own way (ranges of position, say);
    the cells then carry their names.
    """

    family: str
    label: str
    y: float
    cells: tuple[Region, ...]


@drawn
def where_figure(diagnosis: Diagnosis) -> Figure | None:
    """Draw joints across, regions down, families apart; None where the result has no regions."""
    rows = map_rows(diagnosis)
    if not rows:
        return None
    n = len(diagnosis.joints)
    width = max(WIDTH, 2.4 + (2.0 if n <= ROOMY else 1.0) * n)
    figure = new_figure(1.3 + (0.4 if n <= ROOMY else 0.28) * rows[-1].y, width)
    draw_map(figure.subplots(), diagnosis, rows)
    heading(figure, _finding(diagnosis), width)
    return figure


def map_rows(diagnosis: Diagnosis) -> list[MapRow]:
    """Return the rows from top to bottom, families in order of first mention.

    A family of one region says nothing of where: of a run whose last third is held out, say. Of nothing else it stays.
    """
    rows: list[MapRow] = []
    y = 0.0
    families = dict.fromkeys(region.family for region in diagnosis.regions)
    every = {family: _family_rows(diagnosis, family) for family in families}
    telling = {family: parts for family, parts in every.items() if len(parts) > 1} or every
    for family, parts in telling.items():
        y += 0.8
        for label, cells in parts:
            rows.append(MapRow(family, label, y, cells))
            y += 1.0
    return rows


def _family_rows(diagnosis: Diagnosis, family: str) -> list[tuple[str, tuple[Region, ...]]]:
    mine = [one for one in diagnosis.regions if one.family == family and (one.family, one.region) != TWICE]
    by_joint = [[region for region in mine if region.joint == joint] for joint in diagnosis.joints]
    names = list(dict.fromkeys(region.region for region in mine))
    most = max(len(regions) for regions in by_joint)
    if len(names) <= most or len(names) < len(mine):  # the joints share at least some names
        return [(name, tuple(region for region in mine if region.region == name)) for name in names]
    return [("", tuple(regions[k] for regions in by_joint if k < len(regions))) for k in range(most)]


def draw_map(ax: Axes, diagnosis: Diagnosis, rows: list[MapRow]) -> Axes:
    """Draw one cell per joint and region, its share as number and, of the whole gap, as shade; return ``ax``."""
    shares = sentences.share_of_joints(diagnosis)
    part = {joint: share / max(shares.values()) for joint, share in shares.items()}
    for row in rows:
        for region in row.cells:
            _draw_cell(ax, diagnosis, region, row, part.get(region.joint, 0.0))
    for family in dict.fromkeys(row.family for row in rows):
        top = min(row.y for row in rows if row.family == family)
        name = words.clean(family).replace("_", " ")
        ax.text(-0.51, top - 0.52, f"by {name}", ha="right", va="bottom", color=MUTED, fontsize=9, fontweight="bold")
    ax.set_yticks([row.y for row in rows], [words.short(row.label.replace("_", " "), 34) for row in rows])
    ax.set_xlim(-0.5, len(diagnosis.joints) - 0.5)
    ax.set_ylim(rows[-1].y + 0.5, 0.1)
    for column, joint in enumerate(diagnosis.joints):
        name = words.short(joint, 22)
        if len(diagnosis.joints) > 1 and joint in shares:
            name += (
                f": {percent(shares[joint])} of the gap"
                if len(diagnosis.joints) <= ROOMY
                else f"\n{percent(shares[joint])}"
            )
        ax.text(column, 0.05, name, ha="center", va="bottom", fontsize=10, fontweight="bold")
    ax.set_xticks([])
    ax.tick_params(length=0, labelcolor=INK, labelsize=9.5)
    for spine in ax.spines.values():
        spine.set_visible(False)
    ax.set_xlabel(_legend(diagnosis), fontsize=9)
    return ax


def _draw_cell(ax: Axes, diagnosis: Diagnosis, region: Region, row: MapRow, part: float) -> None:
    if region.joint not in diagnosis.joints:
        return
    column = diagnosis.joints.index(region.joint)
    share = part * min(max(region.share.value, 0.0), 1.0)
    ax.add_patch(
        Rectangle((column - 0.48, row.y - 0.47), 0.96, 0.94, facecolor=SHADES(share), edgecolor=RULE, linewidth=0.6)
    )
    colour = "white" if share > 0.68 else INK
    clear = diagnosis.verdict != "no_gap" and region.share.low > region.time_share > 0.0
    lines = _cell_lines(diagnosis, region, not row.label)
    for k, (text, dy, size) in enumerate(lines):
        weight = "bold" if clear and k == 0 else "normal"
        ax.text(column, row.y + dy, text, ha="center", va="center", color=colour, fontsize=size, fontweight=weight)


def _cell_lines(diagnosis: Diagnosis, region: Region, named: bool) -> list[tuple[str, float, float]]:
    """Return (text, offset, size) of the lines in a cell."""
    share = percent(region.share.value)
    if len(diagnosis.joints) > ROOMY:
        return [(share, 0.0, 9.0)]
    if 0.0 < region.time_share < 1.0:
        share = f"{share} in {percent(region.time_share)} of time"
    change = number(region.rms, 2)
    change = f"{change} → {number(region.rms_corrected, 2)}" if diagnosis.named else change
    detail = f"{words.short(words.span(region.region), 22)}: {change}" if named else change
    return [(share, -0.17, 9.0), (detail, 0.22, 8.0)]


def _legend(diagnosis: Diagnosis) -> str:
    unit = words.torque_unit(diagnosis)
    rms = f"below: rms, {unit}, re-tuned → corrected" if diagnosis.named else f"below: rms, {unit}"
    rms = "" if len(diagnosis.joints) > ROOMY else rms
    bold = "" if diagnosis.verdict == "no_gap" else "bold: clearly more than its share of the time"
    share = "share of the joint's squared residual beyond noise (re-tuned, held-out); shade: of the whole gap"
    noise = "by frequency: noise included" if any(one.family == "frequency" for one in diagnosis.regions) else ""
    return "\n".join(filter(None, (share, "; ".join(filter(None, (rms, noise, bold))))))


def _finding(diagnosis: Diagnosis) -> str:
    if diagnosis.verdict == "no_gap":
        return "No joint and no region stands out of the noise"
    if not diagnosis.where:
        return "Where the residual of the re-tuned model lies"
    return sentences.finding(diagnosis)
