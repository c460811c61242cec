"""The page, the figures and the command of a limit-cycle analysis."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from stribeck.arm import Arm, Friction, Joint, save_arm
from stribeck.cli import main
from stribeck.loop.analyse import analyse_loop
from stribeck.loop.answers import Analysis, Branch, Locus
from stribeck.loop.cycle import VERDICTS, Cycle
from stribeck.loop.exact.engine import RoundsEngine
from stribeck.loop.files import limit_cycle_json
from stribeck.loop.linear import KpMax
from stribeck.loop.maps import Axes, Map
from stribeck.loop.ripple import Passage
from stribeck.loop.surroundings import Grid, map_of
from stribeck.report.cycle_tables import gain_facts, method_facts, method_table, verdict_table
from stribeck.report.cycle_words import answer_sentences, headline
from stribeck.report.figures.cycle_branch import branch_figure
from stribeck.report.figures.cycle_map import map_figure
from stribeck.report.figures.cycle_trace import trace_figure
from stribeck.report.figures.nyquist import nyquist_figure
from stribeck.report.figures.portrait import MOST, portrait_figure
from stribeck.report.figures.root_locus import crossing_poles, locus_figure
from stribeck.report.limit_cycle import PLOTS, _answer, write_report
from stribeck.report.style import finding_of, png_and_svg
from stribeck.simulate import Compensation, JointLoop, Loop, Reference

A = Friction(5.0, 1.25, 1.5, 0.05)
LOOP = """\
schema = "stribeck.loop/1"
sample_time = 0.0125
duration = 5.0
[[joints]]
joint = "A"
kp = 30.0
kv = 5.0
[joints.compensation]
kind = "feedback"
ratio = 0.8
[joints.reference]
kind = "regulate"
initial_error = 0.1
"""


def arm(kind: str = "revolute", name: str = "A") -> Arm:
    joint = Joint(name, kind, 0.3, 1.0, (0.0, 0.0), 0.0, 0.0, A, A)  # type: ignore[arg-type]
    return Arm("<b>bench</b>", (0.0, 0.0), (replace(joint, inertia=0.5, rotor_inertia=0.5),))


@pytest.fixture(scope="module")
def cycling(_own_cache: None) -> Analysis:
    law = Compensation("feedback", 1.3, at_zero="error_sign")
    entry = JointLoop("A", 30.0, Reference("regulate", initial_error=0.2), kv=5.0, compensation=law)
    return analyse_loop(arm(), Loop(0.0, 10.0, (entry,)), grid=Grid(7, 6))


@pytest.mark.usefixtures("_own_cache")
def test_a_motion_that_is_unbounded_at_once_is_drawn() -> None:
    entry = JointLoop("A", 1e9, Reference("regulate", initial_error=0.2), kv=5.0)
    found = analyse_loop(arm(), Loop(0.0125, 10.0, (entry,)), grid=Grid(wanted=False))
    assert found.motion.motion.filled == 1
    assert "unbounded after" in finding_of(trace_figure(found, 0))


@pytest.mark.parametrize("drawn", [pytest.param("", marks=pytest.mark.slow), "swings"])
def test_the_page_is_whole_and_escapes_names(
    cycling: Analysis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, drawn: str
) -> None:
    """All figures as images, or the one whose finding says so."""
    draw = lambda figure: png_and_svg(figure) if drawn in finding_of(figure) else (b"\x89PNG", b"")  # noqa: E731
    monkeypatch.setattr("stribeck.report.limit_cycle.png_and_svg", draw)
    write_report(cycling, tmp_path)
    page = (tmp_path / "report.html").read_text(encoding="utf-8").replace("\u00a0", " ")
    assert "<b>bench</b>" not in page
    assert "&lt;b&gt;bench" in page
    assert "sliding cycle of ±82.1" in page
    assert "cannot be trusted here: damping ratio 0.46" in page
    assert "://" not in re.sub(r"data:image[^\"]*", "", page)
    names = {f"{plot.file}_1.png" for plot in PLOTS}
    assert {path.name for path in tmp_path.iterdir()} == {"report.html", *names}
    assert all((tmp_path / name).read_bytes().startswith(b"\x89PNG") for name in names)


def test_every_figure_states_its_finding(cycling: Analysis) -> None:
    answer = cycling.joints[0]
    findings = [
        finding_of(figure)
        for figure in (
            portrait_figure(cycling, 0), trace_figure(cycling, 0), branch_figure(answer), map_figure(answer),
            nyquist_figure(answer),
        )
        if figure is not None
    ]  # fmt: skip
    texts = "\n".join(findings).replace("\u00a0", " ")
    assert "sliding cycle of ±82.1 mrad every 1.30 s" in texts
    assert re.search(r"the error swings ±82.* in the second half of 15.5 s, the first 10.0 s shown", texts)
    assert "cycles begin at k = 1.00" in texts
    assert re.search(r"A: \d+ % of the map cycles, mostly without sticking; \d+ % comes to rest", texts)
    assert "6.4 % off in amplitude and 11 % in period" in texts


def test_the_nyquist_curves_meet_where_the_root_is(cycling: Analysis) -> None:
    curves = cycling.joints[0].nyquist
    assert curves is not None
    (root,) = curves.roots
    here = np.interp(math.log(root.omega), np.log(curves.omega), curves.response.real)
    there = np.interp(math.log(root.velocity), np.log(curves.speed), curves.inverse.real)
    assert here == pytest.approx(there, rel=1e-3)
    assert np.interp(math.log(root.omega), np.log(curves.omega), curves.response.imag) == pytest.approx(0.0, abs=1e-4)


@pytest.mark.parametrize(
    ("cycle", "says"),
    [
        (Cycle("rest", steady_error=-0.05), "comes to rest 50.0 mrad from its reference"),
        (Cycle("rest", steady_error=-1.9e-31), "comes to rest at its reference"),
        (Cycle("rest", steady_error=-1.4e-11), "comes to rest at its reference"),
        (Cycle("unbounded", stable=False), "unbounded"),
        (Cycle("undetermined", status="not settled"), "undetermined (not settled)"),
        (Cycle("hunting", 0.01, 6.0, 0.1, 0.75, (), True), "hunting of ±10.0 mrad every 6.00 s, stuck 75 % of"),
        (Cycle("stick_slip", 0.01, 6.0, 0.1, 0.5, (0.2 + 0.1j, 0.2 - 0.1j), True), "stick-slip of ±10.0 mrad"),
    ],
)
def test_every_verdict_has_words_tables_and_figures(cycling: Analysis, cycle: Cycle, says: str) -> None:
    answer = replace(cycling.joints[0], cycle=cycle, nyquist=None, branch=None, map=None)
    changed = replace(cycling, joints=(answer,))
    assert says in headline(answer).replace("\u00a0", " ")
    assert len(answer_sentences(answer, several=True)) == 3
    assert "10⁻" not in "".join(str(cell) for cell in verdict_table(changed).rows[0].cells)
    assert len(verdict_table(changed).rows[0].cells) == len(verdict_table(changed).columns)
    assert all(len(row.cells) == len(method_table(answer).columns) for row in method_table(answer).rows)
    assert [figure(answer) for figure in (nyquist_figure, branch_figure, map_figure)] == [None, None, None]
    assert finding_of(portrait_figure(changed, 0))
    assert finding_of(trace_figure(changed, 0))


def test_the_way_of_a_joint_that_mostly_rests_is_drawn_as_finely(cycling: Analysis) -> None:
    rows, motion = 10 * MOST, cycling.motion.motion
    q, dq = np.zeros((rows, 1)), np.zeros((rows, 1))
    q[500:600, 0], dq[500:600, 0] = np.linspace(0.0, 1.0, 100), 2.0
    q[600:, 0] = 1.0
    still = replace(motion, t=np.arange(float(rows)), q=q, dq=dq, modes=np.zeros((rows, 1)), filled=rows)
    closed = replace(cycling.motion, motion=still, reference=np.zeros((rows, 1)))
    (axes,) = portrait_figure(replace(cycling, motion=closed), 0).axes
    assert (np.asarray(axes.lines[0].get_ydata()) == 2.0).sum() == 100


@pytest.mark.parametrize(("velocity", "error", "side"), [(0.05, 0.018, "behind"), (0.05, -0.018, "ahead of"),
                                                         (-0.05, -0.018, "behind")])  # fmt: skip
def test_what_keeps_up_with_a_ramp_does_not_come_to_rest(
    cycling: Analysis, velocity: float, error: float, side: str
) -> None:
    entry = replace(cycling.joints[0].entry, reference=Reference("ramp", velocity=velocity))
    answer = replace(cycling.joints[0], entry=entry, cycle=Cycle("rest", steady_error=error))
    assert f"slides steadily along its ramp, 18.0 mrad {side} it" in headline(answer).replace("\u00a0", " ")
    (axes,) = portrait_figure(replace(cycling, joints=(answer,)), 0).axes
    assert axes.lines[1].get_xydata().tolist() == [pytest.approx([-1e3 * error, velocity])]
    analysis = replace(cycling, joints=(replace(answer, cycle=replace(answer.cycle, basin={"own": "rest"})),))
    assert verdict_table(analysis).rows[0].cells[1] == "slides steadily"
    assert dict(gain_facts(analysis.joints[0]).pairs)["basin"] == "the loop's own start: slides steadily"
    assert _answer(analysis).badge == "Slides steadily"
    assert "slides along its ramp" in finding_of(trace_figure(analysis, 0))
    assert answer.map is not None
    resting = replace(answer.map, codes=np.where(answer.map.codes == VERDICTS.index("rest"), 0, 6).astype(np.int8))
    figure = map_figure(replace(answer, map=resting))
    assert figure is not None
    assert "slides steadily; " in finding_of(figure)
    assert [text.get_text() for text in figure.axes[0].get_legend().get_texts()] == ["steady sliding", "undetermined"]


def told_in_words(analysis: Analysis) -> list[str]:
    """What the headline, the badge, the tables and the facts say of the first joint."""
    (answer,) = analysis.joints
    said, facts = headline(answer).replace("\u00a0", " "), dict(gain_facts(answer).pairs)
    cells = [table.rows[row].cells[1] for table, row in ((verdict_table(analysis), 0), (method_table(answer), 2))]
    return [said, _answer(analysis).badge, *cells, facts["basin"]]


def test_what_a_dither_forces_is_no_hunting(cycling: Analysis) -> None:
    hunting = Cycle("hunting", 0.05, 0.5, stick_fraction=0.34, basin={"own": "hunting"})
    branch = Branch("kp", np.array([10.0, 20.0]), (replace(hunting, period=0.7), hunting), np.full(2, np.nan))
    shaken = Passage("dither", "A", 0.5)
    codes = np.full((2, 2), VERDICTS.index("hunting"), np.int8)
    codes[1, 1] = VERDICTS.index("rest")
    period = np.array([[0.5, 0.7], [1.5, np.nan]], np.float32)
    axes = Axes(("kp", "zeta"), (np.array([20.0, 40.0]), np.array([0.5, 1.0])))
    chart = Map(axes, codes, period, period, 0.0 * period, "events")
    answer = replace(cycling.joints[0], cycle=hunting, branch=branch, map=chart, passages=(shaken,))
    analysis = replace(cycling, joints=(answer,))
    said = "A: forced motion of ±50.0 mrad every 0.500 s, stuck 34 % of the time, forced by its dither"
    assert told_in_words(analysis) == [
        said,
        "Forced motion",
        "forced motion",
        "forced",
        "the loop's own start: forced motion",
    ]
    told = limit_cycle_json(analysis)["joints"]["A"]
    assert (told["verdict"], told["forced_by"]) == ("hunting", "dither")
    for figure, finding in (
        (branch_figure(answer), "A: cycles at Kp 10.0 N m/rad, a forced motion at Kp 20.0 N m/rad"),
        (map_figure(answer), "A: 25 % of the map cycles, mostly hunting; 50 % is a forced motion; 25 % comes to rest"),
    ):
        assert figure is not None
        assert finding_of(figure).replace("\u00a0", " ") == finding


def test_a_ripple_that_waves_force_is_no_cycle(cycling: Analysis) -> None:
    """In words and figures; on a map over speeds, each cell passes the waves at its own."""
    wave = Passage("position_dependent_friction", "A", 40.0)
    ripple, slip = Cycle("sliding_cycle", 0.05, 40.0, basin={"own": "sliding_cycle"}), Cycle("stick_slip", 0.1, 40.0)
    entry = replace(cycling.joints[0].entry, reference=Reference("ramp", velocity=0.05))
    branch = Branch("kp", np.array([10.0, 20.0, 40.0]), (slip, ripple, ripple), np.full(3, np.nan))
    codes = np.array([[VERDICTS.index("sliding_cycle"), VERDICTS.index("stick_slip")]] * 2, np.int8)
    period = np.array([[40.0, 40.0], [39.0, 40.0]], np.float32)
    axes = Axes(("kp", "velocity"), (np.array([20.0, 40.0]), np.array([0.05, 0.1])))
    chart = Map(axes, codes, period / 400.0, period, 0.0 * period, "events")
    answer = replace(cycling.joints[0], entry=entry, cycle=ripple, branch=branch, map=chart, passages=(wave,))
    analysis = replace(cycling, joints=(answer,))
    said = "A: forced ripple of ±50.0 mrad every 40.0 s, in which its ramp passes a wave of position-dependent friction"
    assert told_in_words(analysis) == [
        said,
        "Forced ripple",
        "forced ripple",
        "ripple",
        "the loop's own start: forced ripple",
    ]
    for figure, finding in (
        (branch_figure(answer), "A: cycles at Kp 10.0 N m/rad, a forced ripple at Kp from 20.0 to 40.0"),
        (
            branch_figure(replace(answer, branch=replace(branch, cycles=(ripple,) * 3))),
            "A: a forced ripple at Kp from ",
        ),
        (map_figure(answer), "A: 75 % of the map cycles, mostly in stick-slip; 25 % is a forced ripple"),
    ):
        assert figure is not None
        assert finding_of(figure).replace("\u00a0", " ").startswith(finding)
    other = replace(answer, joint="B", map=None)
    assert "in which A's ramp passes a wave" in headline(other)


def test_the_map_of_a_backward_ramp_is_over_backward_ramps(cycling: Analysis) -> None:
    loop = Loop(0.0, 10.0, (JointLoop("A", 30.0, Reference("ramp", velocity=-0.02), kv=1.0),))
    found = map_of(RoundsEngine(arm()), loop, "A", Grid(3, 2), None)
    assert found.axes.values[1] == pytest.approx([-0.002, -0.02, -0.2])
    figure = map_figure(replace(cycling.joints[0], entry=loop.joints[0], map=found))
    assert figure is not None
    assert figure.axes[0].get_xlabel() == "speed of the ramp, rad/s"
    assert figure.axes[0].get_xlim()[0] > 0.0


def test_the_critical_ratio_is_told_to_be_none_only_where_it_was_sought(cycling: Analysis) -> None:
    told = "not sought: it is of a compensation of kind feedback"
    for answer, expected in (
        (replace(cycling.joints[0], k_critical=None, k_why=told), told),
        (replace(cycling.joints[0], k_critical=0.0), "0: it cycles without compensation"),
    ):
        assert dict(gain_facts(answer).pairs)["critical k"] == expected


def test_the_simulation_of_a_sampled_loop_is_a_plain_record() -> None:
    continuous, sampled = (dict(method_facts(step).pairs)["simulation"] for step in (0.0, 0.0125))
    assert continuous.endswith("until the averages stand still")
    assert sampled == "run from the loop's own start; read off the second half of the record"


def test_a_loop_that_cycles_without_compensation_may_rest_with_it(cycling: Analysis) -> None:
    answer = replace(cycling.joints[0], k_critical=0.0)
    assert answer.branch is not None
    assert "; it cycles without compensation too." in answer_sentences(answer, several=False)[1][1]
    rest = replace(answer, cycle=Cycle("rest", steady_error=0.0))
    assert answer_sentences(rest, several=False)[1][1].endswith("; it cycles without compensation.")
    ends = [Cycle("rest", steady_error=0.0)] * 2 + [replace(answer.cycle)]
    branch = replace(answer.branch, values=np.array([0.6, 0.9, 1.2]), cycles=tuple(ends), predicted=np.full(3, np.nan))
    figure = branch_figure(replace(rest, branch=branch))
    assert figure is not None
    assert finding_of(figure) == "A: cycles without compensation, rests at k from 0.600 to 0.900"
    figure = branch_figure(replace(answer, branch=replace(branch, cycles=(answer.cycle,) * 3)))
    assert figure is not None
    assert finding_of(figure) == "A: cycles without compensation too"


def test_the_poles_are_shown_up_to_where_they_cross(cycling: Analysis) -> None:
    """Two slow poles, and a pair of fast ones that cross at 100 1/s between the second and the third gain."""
    pair = np.array([[-20.0 + 90.0j], [-2.0 + 99.0j], [1.0 + 101.0j], [3.0 + 103.0j]])
    poles = np.hstack([np.full((4, 2), -3.0 + 0.0j), pair, pair.conj()])
    locus = Locus(np.array([10.0, 20.0, 30.0, 40.0]), poles, poles[0], 0.0)
    assert crossing_poles(locus, 25.0) == pytest.approx([101.0j, -101.0j])
    assert not len(crossing_poles(locus, None))
    figure = locus_figure(replace(cycling.joints[0], locus=locus, kp_max=KpMax(25.0, None)))
    assert figure is not None
    near, far = figure.axes[:2]
    assert near.get_ylim()[1] < 101.0 < far.get_ylim()[1]
    slow = replace(locus, poles=0.1 * np.hstack([pair, pair.conj()]), own=0.1 * pair[0])
    figure = locus_figure(replace(cycling.joints[0], locus=slow, kp_max=KpMax(25.0, None)))
    assert figure is not None
    assert len(figure.axes) == 2  # one panel, and the colours of the gains


def test_a_prismatic_axis_is_in_metres(cycling: Analysis) -> None:
    answer = replace(cycling.joints[0], kind="prismatic")
    figure = map_figure(answer)
    assert figure is not None
    labels = [ax.get_ylabel() for ax in figure.axes]
    assert labels == ["Kp, N/m", "amplitude of the cycle, mm"]
    assert "mm" in headline(answer)


# --- the command ----------------------------------------------------------------------------------------------------


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    save_arm(arm(), "arm.toml")
    Path("loop.toml").write_text(LOOP)
    return tmp_path


@pytest.mark.long
@pytest.mark.usefixtures("bench")
def test_the_command_writes_its_files(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("stribeck.report.limit_cycle.png_and_svg", lambda figure: (b"drawn", b""))  # as above, it is
    assert main(["limit-cycle", "arm.toml", "loop.toml", "--grid", "5x4", "--out", "out"]) == 0
    content = json.loads(Path("out/limit_cycle.json").read_text())
    assert content["joints"]["A"]["verdict"] == "rest"
    assert abs(content["joints"]["A"]["steady_error"]) <= 6.25 / 30.0
    assert Path("out/report.html").stat().st_size > 10_000
    assert {path.name for path in Path("out").glob("*.png")} >= {"phase_1.png", "trace_1.png", "map_1.png"}
    out, err = capsys.readouterr()
    assert "comes to rest" in out
    assert "analysing: shooting for cycles" in err


@pytest.mark.usefixtures("bench")
@pytest.mark.parametrize(
    ("old", "new", "extra", "says"),
    [
        ("ratio = 0.8", "ratio = -0.8", "", "compensation.ratio must not be less than 0.0: found -0.8"),
        ("kp = 30.0", "kp = -30.0", "", "kp must be greater than 0.0: found -30.0"),
        ('"A"', '"C"', "", "is not a joint of this arm"),
        ("duration = 5.0", "duration = nan", "", "duration must be finite"),
        ("kv = 5.0", 'kv = 5.0\ndelay_samples = 2.5', "", "delay_samples must be a whole number"),
        ('"regulate"', '"sine"\nfrequency = 1.0', "", "a limit cycle is what a loop does of itself"),
        ("", "", "--grid 0x0", "the map's grid is empty or too large: found 0 x 0"),
        ("", "", "--grid 2000x2000", "found 2000 x 2000; give 2x2 at least, and at most 100000 cells in all"),
        ("", "", "--grid many", "--grid must be two numbers of cells: found 'many'"),
        ("", "", "--gird 3x3", "No such option: --gird"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line_and_no_folder(
    old: str, new: str, extra: str, says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("loop.toml").write_text(LOOP.replace(old, new, 1) if old else LOOP)
    assert main(["limit-cycle", "arm.toml", "loop.toml", "--out", "out", *extra.split()]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert says in line
    assert sorted(path.name for path in Path().iterdir()) == ["arm.toml", "loop.toml"]


def test_ctrl_c_leaves_nothing(
    bench: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def stop(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("stribeck.loop.analyse.shoot", stop)
    assert main(["limit-cycle", "arm.toml", "loop.toml", "--out", "out"]) == 130
    assert "interrupted; nothing was written" in capsys.readouterr().err
    assert sorted(path.name for path in bench.iterdir()) == ["arm.toml", "loop.toml"]
