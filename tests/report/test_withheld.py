"""The pages of withheld check and power analysis, from scores made by hand."""

import re

import numpy as np
import pytest

from stribeck.report.figures.confusion import confusion_figure
from stribeck.report.figures.power import clearest, draw_power, power_figure
from stribeck.report.figures.withheld import limits_figure, shrinkage_figure, strength_figure, strength_left_figure
from stribeck.report.power import write_power_report
from stribeck.report.style import finding_of, new_figure
from stribeck.report.withheld import write_score_report
from stribeck.report.withheld_tables import several, share


def rate(k, n):
    return {"k": k, "n": n, "value": k / n if n else None, "ci95": [0.5 * k / n, 1.0] if n else None}


def measures(k, n):
    keys = ("top1", "class", "named", "clean", "joint", "channel")
    return {
        "class_size": 1.5 if n else None,
        **{key: rate(k, n) for key in keys},
        "wrong_name": rate(1, n) if n else rate(0, 0),
        "abstained": rate(0, n),
    }


def limit(strength, ci95, outside):
    return {"strength": strength, "ci95": ci95, "outside": outside, "n": 4}


def row(case, effect, strength, found, extra=(), level="clear"):
    return {
        "case": case, "effects": [effect], "strength": strength, "found": [effect] if found else [], "level": level,
        "extra": list(extra), "error": None, "claimed": 0.9, "true": 0.85 if found else -2.0,
    }  # fmt: skip


@pytest.fixture
def score():
    empty = measures(0, 0)
    return {
        "version": "0", "digest": "d" * 64, "code": "c" * 64, "sources": 1, "cases": 3, "library": ["delay", "payload"],
        "single": {"all": measures(2, 4), "strong": measures(2, 3), "fair": measures(0, 1), "faint": empty},
        "single_left": {"all": measures(2, 4), "strong": measures(2, 2), "fair": empty, "faint": measures(0, 2)},
        "single_levels": {"clear": measures(2, 4), "medium": empty, "weak": empty},
        "pairs": {name: {key: rate(n // 2, n) for key in ("both", "at_least_one", "wrong_name")}
                  for name, n in (("all", 4), ("strong", 4), ("fair", 0), ("faint", 0))},
        "several": {"found": rate(5, 9), "strong": rate(4, 5), "fair": rate(1, 2), "faint": rate(0, 2),
                    "wrong": rate(1, 6), "wrong_name": rate(1, 3), "none_named": rate(0, 3)},
        "none": {"false_alarms": rate(0, 2)},
        "outside": {"abstained": rate(1, 2), "effects": {"friction_jumps": rate(1, 2)}},
        "calibration": {"likeliest": {"n": 3, "ece": 0.1, "ece_by_chance": 0.02, "ci95": [0.0, 0.2],
                                      "bins": [{"stated": 0.9, "held": rate(2, 3)}]}},
        "intervals": {"coverage": rate(9, 10), "parameters": [
            {"effect": "delay", "parameter": "time", "same_law": True, **rate(9, 10)},
            {"effect": "presliding", "parameter": "stiffness", "same_law": False, **rate(1, 10)}]},
        "shrinkage": {"within_5_points": rate(1, 2), "median_true": 0.85, "median_error": 0.05},
        "effects": {
            "delay": {**measures(2, 2), "detection_limit": limit(2.0, [1.0, 4.0], None)},
            "payload": {**measures(0, 2), "detection_limit": limit(8.0, [5.0, 8.0], "above")},
        },
        "confusion": {"hidden": ["delay", "none"], "said": ["delay", "none"], "counts": [[2, 1], [0, 2]]},
        "time": {"median": 30.0, "longest": 60.0, "processor_median": 25.0},
        "targets": [
            {"what": "named, strength 3 and more", "have": 0.67, "want": 0.9, "at_least": True, "holds": False},
            {"what": "calibration error", "have": 0.02, "want": 0.05, "at_least": False, "holds": True},
            {"what": "both of a pair named", "have": None, "want": 0.75, "at_least": True, "holds": None},
        ],
        "rows": [row("case_0001", "delay", 4.0, True), row("case_0002", "payload", 2.0, False, ["delay"])],
    }  # fmt: skip


@pytest.mark.long
def test_the_page_says_what_holds_and_what_does_not(score, tmp_path):
    write_score_report(score, tmp_path)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "1 of 2 hold" in page
    assert "does not hold" in page
    assert "not tried" in page
    assert "case_0002" in page  # it went wrong
    made = {path.name for path in tmp_path.glob("*.png")}
    names = ("strength", "strength_left", "confusion", "reliability", "limits", "shrinkage")
    assert made == {f"{name}.png" for name in names}
    assert all(name in page for name in made)
    assert "stage of the path right" in page
    assert "Two effects by strength" in page
    assert "By the strength that re-tuning within tolerance leaves: 100" in page
    assert not re.search(r"(src|href)=.https?:", page)


def test_an_older_key_is_said_to_lack_what_re_tuning_leaves(score, tmp_path, monkeypatch):
    monkeypatch.setattr("stribeck.report.withheld.png_and_svg", lambda figure: (b"", b""))
    write_score_report({**score, "single_left": None}, tmp_path)
    assert "leaves of the strength is not recorded in this key" in (tmp_path / "report.html").read_text()
    assert not (tmp_path / "strength_left.png").exists()


def test_the_confusion_matrix_goes_by_the_path(score):
    table = {"hidden": ["cogging", "friction_jumps", "presliding", "none"], "said": ["cogging", "presliding", "none"]}
    counts = [[1, 2, 3], [4, 5, 6], [7, 8, 9], [0, 0, 1]]
    ax = confusion_figure({"confusion": {**table, "counts": counts}}).axes[0]
    assert [text.get_text() for text in ax.get_yticklabels()] == ["presliding", "cogging", "friction jumps", "nothing"]
    assert ax.texts[0].get_text() == "8"  # presliding, said to be presliding


def test_figures_say_the_finding(score):
    assert finding_of(strength_figure(score)).startswith("50 % of 4 hidden effects are named")
    figure = strength_figure(score)
    figure.draw_without_rendering()
    (ax,) = figure.axes
    assert not ax.get_ylabel()  # which in a low figure would run into the heading
    assert ax.get_title(loc="left") == "by effect torque / noise floor"
    assert not ax._left_title.get_window_extent().overlaps(figure._suptitle.get_window_extent())
    assert finding_of(strength_left_figure(score)) == "Where re-tuning leaves 3 and more, 2 of 2 cases are named"
    assert finding_of(limits_figure(score)) == "1 of 2 effects are named half of the time at 3 noise floors or less"
    assert finding_of(confusion_figure(score)) == "A wrong name in place of what was hidden: 0 of 5 cases"


def test_a_shrinkage_far_below_nothing_stays_in_the_picture(score):
    ax = shrinkage_figure(score).axes[0]
    low, high = ax.get_ylim()
    shown = np.concatenate([line.get_ydata() for line in ax.lines])
    assert np.all((shown > low) & (shown < high))


def test_several_effects_are_counted_one_by_one(score):
    table = several(score)
    assert [row.cells[0] for row in table.rows][:2] == ["effects named", "effects named, strength 3 and more"]
    assert table.rows[0].cells[1].startswith("5 of 9")
    assert {row.cells[0]: row.cells[1][:6] for row in table.rows}["names that are wrong"] == "1 of 6"
    assert several(score | {"several": dict.fromkeys(score["several"], rate(0, 0))}) is None


def test_nothing_to_show_is_left_out(score, tmp_path):
    none = measures(0, 0)
    score |= {"single": dict.fromkeys(("all", "strong", "fair", "faint"), none), "effects": {}, "rows": []}
    score |= {"single_left": score["single"], "single_levels": dict.fromkeys(("clear", "medium", "weak"), none)}
    score["calibration"] = {"likeliest": {"ece": None, "bins": []}}
    score["confusion"] = {"hidden": [], "said": [], "counts": []}
    score["pairs"] = {"all": dict.fromkeys(("both", "at_least_one", "wrong_name"), rate(0, 0))}
    score["several"] = dict.fromkeys(score["several"], rate(0, 0))
    score["outside"] = {"abstained": rate(0, 0), "effects": {}}
    score["intervals"] = {"coverage": rate(0, 0), "parameters": []}
    write_score_report(score, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["report.html"]


def test_a_share_has_its_interval_and_its_counts():
    assert share(rate(0, 0)) == "–"
    assert share({"k": 9, "n": 10, "value": 0.9, "ci95": [0.6, 0.98]}) == "90\u00a0% (60 to 98\u00a0%), 9 of 10"


@pytest.fixture
def power(score):
    level = {"named": rate(1, 1), "strength": 4.0, "worth": 0.5}
    case = {
        "strength": 4.0,
        "worth": 0.32,
        "level": "clear",
        "joint": "A",
        "parameters": {"time": {"value": 0.01, "unit": "s"}},
    }
    blank = {"named": rate(0, 0), "strength": None, "worth": None}
    seen, unseen = {"clear": level, "weak": blank}, {"clear": blank, "weak": blank}
    return {
        "version": "0", "arm": "bench", "runs": ["run.csv"], "cases": 3, "false_alarms": rate(0, 1),
        "wrong_names": rate(0, 2),
        "effects": {
            "delay": {"revealed_from": "clear", "levels": seen, "found": case, "missed": None},
            "payload": {"revealed_from": None, "levels": unseen, "found": None, "missed": case},
        },
        "not_recorded": ["base_flexibility"],
    }  # fmt: skip


def test_the_power_page_names_what_is_revealed_and_what_is_not(score, power, tmp_path):
    write_power_report(power, score, tmp_path)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "1 of 2 revealed" in page
    assert "Blind to?" in page
    assert "base flexibility: could not be recorded." in page
    assert "1 of 1 (4.0; 50\u00a0%)" in page
    assert "time 0.0100" in page
    assert "joint A (4.0; 32\u00a0%)" in page
    assert (tmp_path / "power.png").exists()


def test_every_case_is_marked_by_what_was_said(score, power):
    assert power_figure({**score, "power": {**power, "effects": {}}}) is None
    ax = draw_power(new_figure(3.0).subplots(), ["delay", "payload"], score["rows"])
    marks = [(line.get_marker(), float(line.get_xdata()[0])) for line in ax.lines if line.get_marker() != "None"]
    assert marks == [("o", 4.0), ("X", 2.0)]


@pytest.mark.parametrize(
    ("levels", "told"), [(("clear", "weak"), "clear"), (("weak",), "weak"), (("weak", "medium"), "medium")]
)
def test_a_power_analysis_speaks_of_the_clearest_level_that_it_recorded(levels, told):
    assert clearest({"effects": {"delay": {"levels": dict.fromkeys(levels)}}}) == told
