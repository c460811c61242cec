"""The page and the figure of an identification, from results made by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stribeck.arm import Arm, Friction, Joint
from stribeck.identify.confidence import Intervals
from stribeck.identify.curve import Point
from stribeck.identify.findings import Direction, Identification, JointFriction
from stribeck.identify.map_fit import Fit
from stribeck.identify.run_fit import RunFit
from stribeck.identify.section3 import section3
from stribeck.identify.tustin_fit import fit_curve, tustin
from stribeck.report.figures.friction_curve import friction_curve_figure
from stribeck.report.identification import summary, write_report
from stribeck.report.style import finding_of

TRUE = np.array([5.0, 1.25, 1.5, 0.05])
SPEED = np.concatenate([np.repeat([0.01, 0.03, 0.06, 0.14, 0.3, 1.0, 2.0], 2), np.zeros(3)])
NASTY = "<b onclick=x>$\\frac{</b>"


def direction(source: str = "curve", count: int = len(SPEED)) -> Direction:
    speed = SPEED[:count]
    torque = tustin(TRUE, speed) * (1.0 + 0.01 * np.sin(np.arange(count)))
    points = tuple(Point(0, 1, float(v), float(f), 50, "run.csv") for v, f in zip(speed, torque, strict=True))
    by_hand = section3(speed, torque) if count else None
    runs = np.stack([TRUE, 0.9 * TRUE, 1.1 * TRUE])
    return Direction(points, by_hand, fit_curve(speed, torque), runs, np.array([True, True, True, False]), source)


def identification(*joints: JointFriction, name: str = "arm", kind: str = "revolute") -> Identification:
    friction = Friction(*TRUE.tolist())
    own = tuple(Joint(one.name, kind, 0.3, 1.0, (0.1, 0.0), 0.1, 0.1, friction, friction) for one in joints)  # type: ignore[arg-type]
    arm = Arm(name, (0.0, 0.0), own)
    nothing = np.zeros(0)
    fit = Fit((), nothing, nothing, nothing, nothing, 0.0, 0.0, "Solve_Succeeded", ())
    whole = RunFit(arm, fit, Intervals(nothing, nothing, nothing), np.full(len(own), 0.1))
    return Identification(arm, arm, joints, whole, ("run.csv",), ("a note",), ("a warning",))


BOTH = {"forward": direction(), "backward": direction()}
FULL = JointFriction("A", BOTH, fit_curve(SPEED, tustin(TRUE, SPEED)), 0.2)


def page(found: Identification, tmp_path) -> str:
    write_report(found, tmp_path)
    return (tmp_path / "report.html").read_text(encoding="utf-8")


def test_the_page_says_what_was_found(tmp_path):
    text = page(identification(FULL), tmp_path)
    assert "Identified" in text
    assert "Break-away 6.25" in text
    assert "do not clearly differ" in text
    assert "a warning" in text
    assert "a note" in text
    assert "Section 3, step by step" in text
    assert "3.3: saddle, N m at rad/s" in text.replace("\u00a0", " ")
    assert (tmp_path / "friction_curve.png").read_bytes().startswith(b"\x89PNG")


def test_directions_that_differ_are_said_to(tmp_path):
    text = page(identification(replace(FULL, asymmetry=1e-5)), tmp_path)
    assert "The directions differ" in text


@pytest.mark.parametrize(
    ("joint", "badge"),
    [
        (JointFriction("A", {"forward": direction("runs", 0)}, None, None), "Partly identified"),
        (JointFriction("A", {"backward": direction("runs", 3)}, None, None), "Partly identified"),
        (JointFriction("A", {}, None, None), "Not identified"),
    ],
)
def test_what_is_missing_is_left_out(joint, badge, tmp_path):
    """No readings, readings too few for a curve, and a joint that never moved."""
    text = page(identification(joint), tmp_path)
    assert badge in text
    assert "nan" not in text
    assert (tmp_path / "friction_curve.png").exists() == bool(joint.directions)


def test_names_are_only_text(tmp_path):
    text = page(identification(replace(FULL, name=NASTY), name=NASTY), tmp_path)
    assert "<b onclick" not in text


def test_units_of_a_sliding_axis(tmp_path):
    figure = friction_curve_figure(identification(FULL, kind="prismatic"))
    assert figure is not None
    assert figure.axes[0].get_ylabel() == "friction, N"
    assert "m/s" in figure.axes[-1].get_xlabel()
    assert "N s/m" in page(identification(FULL, kind="prismatic"), tmp_path).replace("\u00a0", " ")


def test_panels_labels_and_ranges():
    figure = friction_curve_figure(identification(FULL, replace(FULL, name="B")))
    assert figure is not None
    assert len(figure.axes) == 2
    for ax in figure.axes:
        assert ax.get_ylabel() == "friction, N m"
        low, high = ax.get_ylim()
        assert low < tustin(TRUE, np.array([0.14]))[0] < 6.25 < high
        assert ax.get_xlim()[0] < -2.0
        assert ax.get_xlim()[1] > 2.0
    assert "left: backward" in figure.axes[-1].get_xlabel()


def test_the_terminal_s_table_has_a_row_a_direction():
    assert summary(identification(FULL, replace(FULL, name="B"))).row_count == 4


@pytest.mark.parametrize(
    ("source", "line"),
    [("runs", "IPOPT, whole runs"), ("nominal", "as the arm file"), ("other direction", "as the other direction")],
)
def test_what_is_taken_is_drawn_and_the_legend_lists_what_is(source, line, tmp_path):
    """One reading bounds no axis: the bend is shown."""
    one = replace(direction(source, 1), section3=None)
    found = identification(JointFriction("A", {"forward": one}, None, None))
    figure = friction_curve_figure(found)
    assert figure is not None
    (ax,) = figure.axes
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["readings", line]
    low, high = ax.get_xlim()
    assert low < 0.0 < 0.05 < high < 3.0
    (shown,) = (curve for curve in ax.get_lines() if curve.get_label() == line)
    speed = np.asarray(shown.get_xdata())
    assert np.allclose(shown.get_ydata(), tustin(TRUE, speed))
    text = page(found, tmp_path)
    assert ("Dashed: the paper" in text, "Dotted: IPOPT" in text) == (False, source == "runs")


@pytest.mark.parametrize(("source", "says"), [("runs", "from whole recordings"), ("nominal", "as the arm file")])
def test_the_heading_says_where_constants_come_from(source, says):
    figure = friction_curve_figure(identification(JointFriction("A", {"forward": direction(source, 3)}, None, None)))
    assert figure is not None
    assert finding_of(figure) == f"A, forward: {says}"
