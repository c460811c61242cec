"""The figures at the edges: nothing to draw, values that are not finite, sizes from one joint to seven."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from itertools import pairwise

import matplotlib
import numpy as np
import pytest
from matplotlib.text import Text

from stribeck.gap.result import Estimate, Place, Stage
from stribeck.report import sentences
from stribeck.report.figures.candidates import MOST, _trouble, candidates_figure, partners, ranking
from stribeck.report.figures.measured import measured_figure
from stribeck.report.figures.residual import residual_figure
from stribeck.report.figures.waterfall import waterfall_figure
from stribeck.report.figures.where import map_rows, where_figure
from stribeck.report.style import INK, finding_of, key, new_figure, png
from stribeck.report.tables import stage_table

DRAW = (measured_figure, residual_figure, waterfall_figure, candidates_figure, where_figure)


def labels(figure):
    return figure.findobj(Text)


def words_of(figure):
    return "\n".join(label.get_text() for label in labels(figure))


@pytest.mark.parametrize("draw", DRAW)
def test_nothing_to_draw_is_no_figure(diagnosis, draw):
    empty = replace(diagnosis("unexplained"), traces=(), stages=(), regions=(), candidates=(), where=())
    assert draw(empty) is None


SIZES = [pytest.param(draw, n, marks=pytest.mark.slow if n == 7 and draw not in DRAW[::2] else [])
         for n in (1, 7) for draw in DRAW]  # fmt: skip


@pytest.mark.parametrize(("draw", "n"), SIZES)
def test_every_size_of_arm_is_drawn(diagnosis, draw, n):
    figure = draw(diagnosis(joints=tuple(f"axis {k}" for k in range(n)), duration=3.0, candidates=40))
    assert "axis 0" in words_of(figure) + finding_of(figure)


@pytest.mark.parametrize("draw", [pytest.param(d, marks=[] if d in DRAW[1::2] else pytest.mark.slow) for d in DRAW])
def test_values_that_are_not_finite_are_drawn_around(diagnosis, draw):
    made = diagnosis("explained", duration=3.0)
    nan = Estimate(0.2, -math.inf, math.inf)
    rows = (replace(made.candidates[0], gain=Estimate(-40.0, -80.0, 0.0)),)
    rows += tuple(replace(row, gain=nan) for row in made.candidates[1:4])
    stages = (*made.stages[:2], Stage("presliding", {"A": math.nan}, {"A": math.inf}), made.stages[-1])
    hole = tuple(replace(x, retuned=np.where(x.time[:, None] > 1, np.nan, x.retuned)) for x in made.traces)
    assert len(png(draw(replace(made, candidates=rows, stages=stages, traces=hole)))) > 5_000


def test_titles_state_the_finding(diagnosis):
    made = diagnosis(duration=3.0)
    findings = [finding_of(draw(made)).replace("\u00a0", " ") for draw in DRAW]
    assert findings[2] == "Presliding closes 91 % (88 to 93 %) of the torque gap above the noise floor"
    assert re.fullmatch(r"B holds \d+ % of the gap; \d+ % of that lies at velocity reversals", findings[4])


def test_the_joint_of_a_title_is_the_one_that_holds_most_of_the_gap(diagnosis):
    """Not the one of the largest single place; and a region is none that holds no more than its part of the time."""
    made = diagnosis(duration=3.0)
    parts = (("B", "unknown", 0.4), ("A", "unknown", 0.3), ("A", "friction", 0.25))
    places = tuple(Place(joint, stage, "medium velocity", Estimate(s, s, s)) for joint, stage, s in parts)
    found = finding_of(where_figure(replace(made, where=places))).replace("\u00a0", " ")
    assert found == "A holds 55 % of the gap, spread over its motion"
    assert "A: 55 % of the gap" in words_of(where_figure(replace(made, where=places))).replace("\u00a0", " ")
    said = sentences.where(replace(made, where=places)).replace("\u00a0", " ")
    assert (
        "25 % (25 to 25 %) at joint A, in the friction stage" in said
    )  # where what is named acts, though two others hold more


def test_where_most_of_the_gap_stays_the_residual_tells_of_the_joint_that_is_relieved(diagnosis):
    made = diagnosis(duration=3.0)
    top = max(made.where, key=lambda place: place.share.value)
    stays = tuple(
        replace(r, rms_corrected=r.rms) if (r.joint, r.region) == (top.joint, top.region) else r for r in made.regions
    )
    k = made.joints.index(top.joint)
    kept, gone = (
        tuple(
            replace(x, corrected=np.where(np.arange(2) == k if one else [True] * 2, x.retuned, x.corrected))
            for x in made.traces
        )
        for one in (True, False)
    )

    def found(traces):
        return finding_of(residual_figure(replace(made, regions=stays, traces=traces))).replace("\u00a0", " ")

    (other,) = set(made.joints) - {top.joint}
    plain = r"Presliding: [\d.]+ % of the squared residual of [AB] is gone"
    assert re.fullmatch(plain, found(made.traces))
    assert re.fullmatch(
        rf"Presliding: [\d.]+ % of the squared residual of {other} is gone, little of that of {top.joint}", found(kept)
    )
    more = tuple(
        replace(x, corrected=np.where(np.arange(2) == k, x.measured - 1.5 * (x.measured - x.retuned), x.corrected))
        for x in made.traces
    )
    assert found(more).endswith(f"of {other} is gone; that of {top.joint} has grown")
    assert found(gone) == sentences.finding(made).replace("\u00a0", " ")  # nor anywhere


def test_a_cell_is_as_dark_as_what_it_holds_of_the_whole_gap(diagnosis):
    made = diagnosis(duration=3.0)
    places = tuple(
        Place(joint, "unknown", "low velocity", Estimate(s, s, s)) for joint, s in (("A", 0.98), ("B", 0.02))
    )
    cells = where_figure(replace(made, where=places)).axes[0].patches
    first, second = (min(sum(p.get_facecolor()[:3]) for p in cells if (p.get_x() > 0.0) == right) for right in (0, 1))
    assert first < 2.9 < second  # of three channels, white


def test_what_the_records_show_alone_is_no_bar_of_the_torque(diagnosis):
    name = "encoder_quantisation"
    made = diagnosis(named=(name,), equivalent=(name,), duration=3.0)
    made = replace(
        made, stages=tuple(s for s in made.stages if s.stage != name), where=(), closed=None,
        candidates=tuple(replace(row, chosen=False) for row in made.candidates),
    )  # fmt: skip
    assert finding_of(waterfall_figure(made)).startswith(
        "Re-tuning alone reaches the noise floor; encoder quantisation"
    )
    assert finding_of(candidates_figure(made)).endswith("encoder quantisation shows in the records")
    assert finding_of(measured_figure(made)).endswith("down to the noise")
    assert not any(row.mark == "strong" for row in stage_table(made).rows)
    assert "shows in the records themselves" in sentences.how_far(made)


def test_the_motions_floor_is_the_encoders_and_no_line(diagnosis):
    torque, motion = waterfall_figure(diagnosis(joints=("A",))).axes
    assert "the encoder's alone" in "".join(text.get_text() for text in motion.texts)
    assert len(torque.lines) == len(motion.lines) + 1


def test_title_of_the_first_figure_says_what_is_left_in_it(diagnosis):
    """Whatever the verdict: what is drawn decides."""
    made = diagnosis("partly_explained", duration=3.0)
    follows = "With presliding, the model follows run_0"
    assert finding_of(measured_figure(made)).startswith(follows)
    assert finding_of(measured_figure(made)).endswith("here; what is left lies elsewhere")
    worse = tuple(
        replace(x, corrected=x.measured - np.array([0.1, 0.7]) * (x.measured - x.retuned)) for x in made.traces
    )
    found = finding_of(measured_figure(replace(made, traces=worse))).replace("\u00a0", " ")
    assert re.fullmatch(r"With presliding, the model still misses .* by [\d.]+ N m rms at B where re-tuning .*", found)
    far = tuple(replace(x, retuned=x.measured + 40.0, corrected=x.measured + 2.0) for x in made.traces)
    assert finding_of(measured_figure(replace(made, traces=far))).startswith(follows)  # next to all is closed
    off = tuple(replace(x, retuned=x.measured + 80.0, corrected=x.measured + 5.0) for x in made.traces)
    assert "still misses" in finding_of(measured_figure(replace(made, traces=off)))  # by as much as there is


def test_held_out_runs_are_not_said_to_have_decided(diagnosis):
    """What was added for the gain of all runs together may gain nothing on them."""
    made = diagnosis(named=("presliding", "cable_spring"), duration=3.0)
    lost = [replace(row, gain=Estimate(-0.1, -0.2, 0.0)) if row.chosen else row for row in made.candidates]
    assert "all runs together decided" in finding_of(candidates_figure(replace(made, candidates=tuple(lost))))
    for verdict in ("explained", "unexplained"):
        found = finding_of(candidates_figure(diagnosis(verdict, duration=3.0)))
        assert "enough on held-out" not in found
        assert "added for" not in found


def test_what_was_named_after_a_first_choice_that_was_not(diagnosis):
    made = diagnosis(named=("cable_spring",), equivalent=("cable_spring",), duration=3.0)
    later = replace(made.candidates[0], step=2, effect="cable_spring", joint="B", gain=Estimate(0.3, 0.2, 0.4))
    figure = candidates_figure(replace(made, candidates=(*made.candidates, later)))
    assert (
        finding_of(figure).replace("\u00a0", " ") == "Cable spring at B closes 91 % (88 to 93 %) of the gap, held-out"
    )


def test_a_stage_that_leaves_something_does_not_read_as_all_gone(diagnosis):
    made = diagnosis(joints=("A",))
    left = {"as_given": 2.0, "retuned": 1.0, "presliding": 0.003, "noise_floor": 0.001}
    made = replace(made, stages=tuple(replace(s, torque={"A": left[s.stage]}) for s in made.stages))
    shown = words_of(waterfall_figure(made)).replace("\u00a0", " ")
    assert "(−50 %)" in shown
    assert "(−99.7 %)" in shown


@pytest.mark.parametrize("draw", DRAW)
@pytest.mark.parametrize("verdict", ["no_gap", "unexplained"])
def test_titles_of_abstentions_name_no_effect(diagnosis, draw, verdict):
    figure = draw(diagnosis(verdict, duration=3.0))
    assert (figure is None) == (draw is candidates_figure and verdict == "no_gap")  # nothing was tried
    if figure is not None:
        assert "resliding" not in finding_of(figure)
        assert "corrected" not in words_of(figure)


def test_ranking_keeps_the_chosen_and_its_partners_however_low(diagnosis):
    made = diagnosis(candidates=40, joints=("A", "B", "C", "D"), equivalent=("presliding", "cable_spring"))
    low = Estimate(-0.9, -1.0, -0.8)
    spring = next(row for row in made.candidates if row.effect == "presliding" and row.joint == "B")
    rows = [replace(spring, effect="cable_spring", joint="A", gain=low), *made.candidates[:40]]
    rows += [replace(spring, effect=f"other_{k}", gain=Estimate(0.5, 0.4, 0.6)) for k in range(MOST)]
    made = replace(made, candidates=tuple(rows))
    shown = ranking(made, 1)
    assert len(shown) == MOST
    assert ("cable_spring", "A") in {(row.effect, row.joint) for row in shown}
    assert partners(made, 1) == {("cable_spring", "A")}
    assert sum(row.chosen for row in shown) == 1
    assert "cannot be told apart" in words_of(candidates_figure(made))


def test_map_lines_up_regions_that_each_joint_splits_in_its_own_way(diagnosis):
    rows = map_rows(diagnosis(joints=("A", "B", "C")))
    position = [row for row in rows if row.family == "position"]
    assert [row.label for row in position] == [""] * 4
    assert all(len(row.cells) == 3 for row in rows)
    assert len({row.y for row in rows}) == len(rows)


def test_map_shows_the_same_samples_once(diagnosis):
    made = diagnosis()
    cells = [replace(made.regions[0], family=f, region=r) for f, r in (("motion", "stuck"), ("direction", "at rest"))]
    made = replace(made, regions=(*made.regions, *cells))
    shown = [(row.family, row.label) for row in map_rows(made)]
    assert ("motion", "stuck") in shown
    assert ("direction", "at rest") not in shown
    assert "beyond noise" in words_of(where_figure(made))


def test_a_users_matplotlib_settings_neither_leak_in_nor_out(diagnosis):
    with matplotlib.rc_context({"text.usetex": True, "font.size": 31.0}):
        figure = waterfall_figure(diagnosis(duration=3.0))
        assert len(png(figure)) > 5_000
        assert matplotlib.rcParams["font.size"] == 31.0
    assert max(label.get_fontsize() for label in labels(figure)) < 14


@pytest.mark.parametrize("draw", DRAW)
def test_nothing_is_set_below_eight_points(diagnosis, draw):
    sizes = [label.get_fontsize() for label in labels(draw(diagnosis(duration=3.0))) if label.get_text()]
    assert min(sizes) >= 8.0


@pytest.mark.parametrize("n", [1, 3])
def test_labels_at_the_end_of_lines_do_not_overlap(diagnosis, n):
    figure = measured_figure(diagnosis(joints=tuple("ABC"[:n]), duration=3.0))
    figure.draw_without_rendering()
    for ax in figure.axes:
        boxes = sorted((Text.get_window_extent(text) for text in ax.texts), key=lambda box: box.y0)
        assert len(boxes) == 3
        assert all(below.y1 <= above.y0 + 1.0 for below, above in pairwise(boxes))


def test_names_of_colours_do_not_overlap_however_long():
    figure = new_figure(4.0, 8.0)
    ax = figure.add_subplot()
    key(ax, [("this loop", INK), ("unstable on the right", INK), ("crosses: largest stable Kp", INK)])
    figure.draw_without_rendering()
    boxes = [Text.get_window_extent(text) for text in reversed(ax.texts)]
    assert len(boxes) == 3
    assert all(left.x1 < right.x0 and left.y0 == pytest.approx(right.y0) for left, right in pairwise(boxes))


@pytest.mark.parametrize(("status", "said"), [
    ("Solve_Succeeded", ""), ("Solved_To_Acceptable_Level", ""), ("ok", ""), ("User_Requested_Stop", "not converged"),
    ("No_Further_Descent", ""), ("Maximum_Iterations_Exceeded", "maximum iterations exceeded"),
])  # fmt: skip
def test_how_a_fit_ended_is_said_in_the_readers_words(status: str, said: str) -> None:
    assert _trouble(status) == said


def test_titles_of_candidates_end_within_the_figure(diagnosis):
    """Of a short-named step below a long-named one too: their panels begin at one place."""
    made = diagnosis(duration=3.0, candidates=40)
    first = tuple(replace(row, joint="the joint of a long name") for row in made.candidates)
    other = tuple(replace(row, step=2, effect="load_dependent_friction", joint="A") for row in made.candidates)
    figure = candidates_figure(replace(made, candidates=first + other))
    figure.draw_without_rendering()
    panels = [label for label in labels(figure) if label.get_text().startswith("Step")]
    assert len(panels) == 2
    assert all(label.get_window_extent().x1 < figure.bbox.x1 for label in panels)


def test_a_family_of_one_region_is_no_part_of_the_map(diagnosis):
    """Where the last third of a run is held out, all of the gap lies there."""
    made = diagnosis(duration=3.0)
    (last,) = {r.region for r in made.regions if r.family == "time" and r.region.startswith("last")}
    regions = tuple(r for r in made.regions if r.family != "time" or r.region == last)
    assert {r.family for r in regions} == {r.family for r in made.regions}
    shown = {row.family for row in map_rows(replace(made, regions=regions))}
    assert shown == {r.family for r in regions} - {"time"}
    alone = tuple(r for r in regions if r.family == "time")
    assert {row.family for row in map_rows(replace(made, regions=alone))} == {"time"}
