"""The tables and lists of the diagnosis page."""

from __future__ import annotations

import math
from dataclasses import replace

from stribeck.gap.answer.files import diagnosis_json
from stribeck.gap.result import Cause, Delivered, Estimate, Stage, Tuned
from stribeck.report import sentences, tables, words
from stribeck.report.delivered import delivered_table
from stribeck.report.figures.candidates import candidates_figure, ranking
from stribeck.report.recordings import recording_table
from stribeck.report.tuned import tuned_table


def test_tuned_values_are_marked_by_what_to_mind(diagnosis):
    rows = (
        Tuned("A.C0", "N m", 4.6, 1.4, Estimate(5.214, 5.13, 5.3)),
        Tuned("A.mass", "kg", 4.0, 0.4, Estimate(4.0, 3.2, 4.8), identified=False),
        Tuned("A.com_x", "m", 0.17, 0.01, Estimate(0.14, 0.139, 0.141), at_limit=True),
        Tuned("A.com_y", "m", 0.0, 0.0, Estimate(0.0, 0.0, 0.0), identified=False),
        Tuned("cable_spring[A].stiffness", "N m/rad", 3.0, math.inf, Estimate(9.0, 8.9, 9.1), moved=True),
    )
    table = tuned_table(replace(diagnosis(), tuned=rows))
    assert [row.mark for row in table.rows] == ["", "muted", "flag", "muted", "flag"]
    assert [row.cells[-1] for row in table.rows] == [
        "", "uncertain", "at its limit", "held", "far from nominal",
    ]  # fmt: skip
    assert table.rows[0].cells[:5] == ("A.C0", "4.6", "1.4", "5.214", "5.130 to 5.300")
    assert table.rows[3].cells[3:5] == ("", "")
    assert table.rows[4].cells[:4] == ("cable_spring[A].stiffness", "3", "none", "9.00")


def test_values_beside_the_causes_are_those_that_are_delivered(diagnosis):
    bent = Tuned("A.C2", "N m s/rad", 0.8, 0.2, Estimate(0.187, 0.0, 0.56), at_limit=True, identified=False)
    last = replace(bent, tuned=Estimate(0.799, 0.79, 0.81), at_limit=False, identified=True)
    alone, both = (replace(diagnosis(), tuned=(bent,), corrected=values) for values in ((), (last,)))
    unit = "N\u00a0m\u00a0s/rad"
    assert tuned_table(alone).rows[0].cells[3:] == ("0.19", "0 to 0.56", unit, "at its limit; uncertain")
    table = tuned_table(both)
    assert table.columns[3:6] == ("re-tuned", "with the causes", "95 % interval")
    assert table.rows[0].cells[3:] == ("0.19", "0.799", "0.790 to 0.810", unit, "")
    assert table.rows[0].mark == ""
    assert [value["value"] for value in diagnosis_json(both)["corrected"]] == [0.799]
    assert "corrected" not in diagnosis_json(alone)


def test_measured_torque_is_told_beside_the_commanded_one(diagnosis):
    assert delivered_table(diagnosis()) is None
    assert "delivered" not in diagnosis_json(diagnosis())
    gain, offset, delay = (
        Estimate(0.83, 0.82, 0.84),
        Estimate(0.1, 0.05, 0.15, "N m"),
        Estimate(0.012, 0.011, 0.013, "s"),
    )
    rows = (
        Delivered("A", gain, offset, delay, 0.05, Estimate(0.62, 0.5, 0.7)),
        Delivered("B", gain, offset, delay, 0.05),
        Delivered("C", Estimate(0.1, -0.2, 0.4), offset, delay, 0.05),
    )
    made = replace(diagnosis("unexplained"), delivered=rows)
    table = delivered_table(made)
    assert table.columns[5] == "delay, ms"
    assert table.rows[0].cells[:8] == (
        "A",
        "0.830",
        "0.820 to 0.840",
        "0.100",
        "0.050 to 0.150",
        "12.0",
        "11.0 to 13.0",
        "0.0500",
    )
    assert [row.cells[-1] for row in table.rows] == ["62\u00a0% (50 to 70\u00a0%)", "no gap", "not known"]
    assert "By the measured torque, the actuator accounts for at least 62" in sentences.where(made)
    slight = replace(rows[0], share=Estimate(0.04, 0.03, 0.05))
    assert "actuator" not in sentences.where(replace(made, delivered=(slight,)))
    in_all = replace(made, delivered=(slight, rows[1]), before_measurement=Estimate(0.4, 0.3, 0.5))
    said = sentences.where(in_all)
    begun, ended = said.split("By the measured torque, actuators account for ")[1].split(" of what re-tuning leaves ")
    assert begun == "at least 40\u00a0% (30 to 50\u00a0%)"
    assert ended == "in all, gain and offset apart."
    assert delivered_table(in_all).rows[-1].cells == ("all", *[""] * 7, "40\u00a0% (30 to 50\u00a0%)")
    assert diagnosis_json(in_all)["gap"]["before_measurement"] == {"value": 0.4, "ci95": [0.3, 0.5]}
    assert "before_measurement" not in diagnosis_json(made)["gap"]
    written = diagnosis_json(made)["delivered"]["A"]
    assert written["delay"] == {"value": 0.012, "unit": "s", "ci95": [0.011, 0.013]}
    assert written["share"]["value"] == 0.62


def test_settings_carry_their_unit_with_the_value(diagnosis):
    made = replace(diagnosis(), settings={"cutoff_hz": 32.3418, "horizon_s": 0.5, "seed": 0, "rule": "t"})
    pairs = dict(tables.method(made, "1.0").pairs)
    assert pairs["cutoff"] == "32.3\u00a0Hz"
    assert pairs["seed"] == "0"
    assert "horizon" not in pairs


def test_long_lists_of_runs_are_cut(diagnosis):
    made = replace(diagnosis(), fit_runs=tuple(f"run_{k:03d}.csv" for k in range(100)))
    assert dict(tables.method(made, "1.0").pairs)["fitted to"].endswith("run_019.csv and 80 more")


def test_only_the_claimed_cause_is_strong(diagnosis):
    made = diagnosis(equivalent=("presliding", "backlash"))
    assert [row.mark for row in tables.cause_table(made).rows] == ["strong", "muted", "muted"]
    assert [row.mark for row in tables.cause_table(diagnosis("unexplained")).rows] == ["muted"] * 3


def test_what_the_records_show_is_there_by_its_own_chance_and_closes_nothing_of_the_torque(diagnosis):
    """Sentence and table say the same; the share of a cause, the JSON's probability, is another column."""
    nothing = Estimate(0.0, 0.0, 0.0)
    coarse = Cause("encoder_quantisation", 0.5, ("A",), ("encoder_quantisation",), {}, nothing, 0.98)
    made = replace(diagnosis(), named=("encoder_quantisation",), causes=(coarse, Cause("unknown", 0.5)))
    table = tables.cause_table(made)
    assert table.columns[2:4] == ("is there", "share")
    assert table.rows[0].cells == ("encoder quantisation", "A", "98\u00a0%", "50\u00a0%", "", "seen in the records")
    assert "(probability 98\u00a0% that it is there)" in sentences.which(made)
    assert diagnosis_json(made)["causes"][0]["presence"] == 0.98
    assert diagnosis_json(made)["causes"][0]["closes"]["value"] == 0.0


def test_search_path_says_what_was_added_and_what_was_not(diagnosis):
    first, second, gains = tables.search_path(diagnosis()).items
    assert gains.endswith("multiplied over the joints.")
    assert first.startswith("Step 1, 26 candidates: presliding at A gains 91")
    assert "added; next best" in first
    assert "nothing was added; the best" in second
    assert "No effect was tried" in tables.search_path(diagnosis("no_gap")).items[0]


def test_screened_out_candidates_are_counted_not_ranked(diagnosis):
    made = diagnosis()
    assert all(row.status != "screened out" for row in ranking(made, 1))
    out = sum(row.step == 1 and row.status == "screened out" for row in made.candidates)
    assert f"{out} screened out" in candidates_figure(made).axes[0].get_title(loc="left")


def test_what_was_tried_but_not_named_is_not_said_to_be_added(diagnosis):
    figure = candidates_figure(diagnosis("unexplained"))
    drawn = figure.axes[0].get_title(loc="left") + "".join(note.get_text() for note in figure.axes[0].texts)
    for text in (drawn, tables.search_path(diagnosis("unexplained")).items[0]):
        assert "tried, not named" in text
        assert "added" not in text
        assert "chosen" not in text


def test_what_an_experiment_hardly_promises_is_no_number(diagnosis):
    gain = {"t": 2.3e-07, "t_d_optimal": 2.6e-07, "t_random": 4.0, "probability_resolved": 0.18}
    section = tables.next_experiment(replace(diagnosis(), next_experiment={"expected_gain": gain}))
    said = dict(section.pairs)["expected gain"]
    assert "comes out less than 0.1 standard deviations from the next one (by a D-optimal motion less than" in said
    assert "by one at random 4" in said


def test_names_of_files_and_joints_stay_as_they_are_in_the_next_experiment(diagnosis):
    told = {
        "what": "Record slow ramp reversals, joint x_axis_1 alone",
        "separates": ["actuator_lag at x_axis_1", "position_dependent_friction"],
        "reference": "next_reference.csv",
    }
    section = tables.next_experiment(replace(diagnosis(), next_experiment=told))
    assert section.pairs == (
        ("what", told["what"]),
        ("separates", "actuator lag at x_axis_1, position-dependent friction"),
        ("reference", "next_reference.csv"),
    )
    nothing = tables.next_experiment(replace(diagnosis(), next_experiment={**told, "separates": []}))
    assert [name for name, _ in nothing.pairs] == ["what", "reference"]


def test_the_last_effect_added_is_the_final_stage_even_when_not_named_itself(diagnosis):
    made = diagnosis()
    stages = (*made.stages[:3], Stage("cable_spring", {"A": 0.01, "B": 0.01}, {}), made.stages[-1])
    made = replace(made, stages=stages)
    assert words.last_stage(made) == "cable_spring"
    assert [row.mark for row in tables.stage_table(made).rows] == ["", "", "", "strong", "muted"]


def test_a_picture_says_which_law_of_the_family_it_shows(diagnosis):
    made = diagnosis()
    causes = [
        replace(cause, law={"A": "maxwell_slip"}) if cause.effect == "presliding" else cause for cause in made.causes
    ]
    told = tables.laws(replace(made, causes=tuple(causes))).laws
    assert [(law.name, law.drawn) for law in told if law.name.startswith("presliding")] == [
        ("presliding (maxwell slip)", "lugre")
    ]
    assert tables.laws(made).laws[0].drawn == ""


def test_every_recording_has_a_row_with_each_joint(diagnosis) -> None:
    found = recording_table(diagnosis())
    assert found is not None
    assert [row.cells[:2] for row in found.rows] == [
        ("run_00.csv", "fitted"), ("run_04.csv", "held out"), ("run_05.csv", "held out")
    ]  # fmt: skip
    assert found.columns[2:5] == tuple(
        f"A {stage}, N\N{NO-BREAK SPACE}m" for stage in ("re-tuned", "corrected", "noise")
    )
    assert found.rows[0].cells[2:] == ("0.500", "0.120", "0.100") * 2
    silent = recording_table(diagnosis("no_gap"))
    assert silent is not None
    assert len(silent.columns) == 2 + 2 * 2  # nothing is corrected


def test_of_many_recordings_those_that_leave_most_are_listed(diagnosis) -> None:
    row = diagnosis().recordings[0]
    many = [replace(row, run=f"{k}", joint=joint, corrected=0.1 + k) for k in range(30) for joint in ("A", "B")]
    found = recording_table(replace(diagnosis(), recordings=tuple(many)))
    assert found is not None
    assert [row.cells[0] for row in found.rows] == [f"{k}" for k in range(10, 30)]
    assert "10 more leave less" in found.note
    assert recording_table(replace(diagnosis(), recordings=())) is None
