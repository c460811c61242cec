"""Sentences and the terminal summary."""

from __future__ import annotations

import io
import re
from dataclasses import replace

import pytest
from rich.console import Console

from stribeck.gap.result import Cause, Estimate, Place
from stribeck.report import sentences, summary, words


def printed(diagnosis, width=100, said=()):
    stream = io.StringIO()
    Console(file=stream, width=width, force_terminal=True, color_system=None).print(summary(diagnosis, said))
    return stream.getvalue()


def test_effects_and_regions_in_words():
    assert words.effect("position_dependent_friction") == "position-dependent friction"
    assert words.stage("presliding") == "+ presliding"
    assert words.region("velocity_reversal") == "at velocity reversals"
    assert words.region("low velocity") == "at low velocity"
    assert words.region("0.20 to 0.40 rad") == "at positions of 0.20 to 0.40 rad"
    assert words.region("-0.38 to -0.20 rad") == "at positions of −0.38 to −0.20 rad"
    assert words.region("0 to 3.1 Hz") == "between 0 and 3.1 Hz"
    assert words.region("last third of a run") == "in the last third of a run"
    assert words.region("odd") == "in “odd”"
    assert words.joints(["A", "B"]) == "joints A and B"
    assert words.joints(["joint_3"]) == "joint_3"


def test_short_keeps_both_ends_and_control_characters_go():
    name = words.short("shoulder\x1b[31m pitch of the left arm\n", 20)
    assert len(name) == 20
    assert name.startswith("shoulder")
    assert name.endswith("left arm")
    assert name.isprintable()


def test_class_probability_is_that_of_the_class(diagnosis):
    made = diagnosis(equivalent=("presliding", "backlash"))
    cause = words.cause_of(made, "presliding")
    assert words.class_probability(made, cause) == pytest.approx(0.97)


def test_named_effect_at_another_joint_is_not_the_claim(diagnosis):
    made = diagnosis()
    made = replace(made, causes=(*made.causes, Cause("presliding", 0.001, ("B",), ("presliding",))))
    assert "joint A" in sentences.which(made)
    assert "joint B" not in sentences.which(made)


@pytest.mark.parametrize(
    ("joints", "alike", "says"),
    [
        (("A", "B"), (), "Presliding at joints A or B, or at both (probability 97 % that it is there)."),
        (("A", "B", "C"), (), "Presliding at joints A, B or C, or at several (probability 97 % that it is there)."),
        (("A", "B"), ("backlash",), "Presliding or backlash at joints A or B, or at both (97 % together): these data"),
    ],
)
def test_what_is_somewhere_is_claimed_nowhere_else(diagnosis, joints, alike, says):
    made = diagnosis()
    cause, *others = made.causes
    cause = replace(cause, joints=joints, equivalent=("presliding", *alike), presence=0.97, anywhere=True)
    made = replace(made, causes=(cause, *others))
    assert sentences.which(made).replace("\u00a0", " ").startswith(says)
    assert says[: says.index(" (")] in " ".join(printed(made).split()).replace("\u00a0", " ")


def test_a_warning_that_the_screen_shows_already_is_not_said_twice(diagnosis):
    made = replace(diagnosis(), warnings=("run.csv: doubtful", "a limit"))
    assert "warning: run.csv: doubtful" in printed(made)
    assert "doubtful" not in printed(made, said=["run.csv: doubtful"])
    assert "warning: a limit" in printed(made, said=["run.csv: doubtful"])


def test_two_effects_are_both_claimed(diagnosis):
    text = sentences.which(diagnosis(named=("presliding", "cable_spring"))).replace("\u00a0", " ")
    first, second = (f"(probability {chance} % that it is there)" for chance in (97, 90))
    assert text == f"Presliding at joint A {first}; and cable spring at joint B {second}."


def test_of_more_than_two_only_the_last_is_joined_by_and(diagnosis):
    made = diagnosis(named=("presliding", "cable_spring"))
    third = replace(words.cause_of(made, "cable_spring"), effect="delay", equivalent=("delay",))
    text = sentences.which(replace(made, named=(*made.named, "delay"), causes=(*made.causes, third)))
    assert text.count("; and ") == 1
    assert [part.split(" at ")[0] for part in text.split("; ")] == ["Presliding", "cable spring", "and delay"]


def test_how_far_without_anything_closable_claims_nothing(diagnosis):
    text = sentences.how_far(replace(diagnosis(), closed=None))
    assert text.startswith("No part of a torque gap counts as closed. Torque rms, as given → re-tuned → corrected: A ")


def test_how_far_says_what_becomes_of_the_motion(diagnosis):
    made = diagnosis()
    text = sentences.how_far(made).replace("\u00a0", " ")
    assert re.search(r"Motion, simulated for 0\.50 s, re-tuned → corrected: A [\d.]+ → [\d.]+ rad; B", text)
    assert "worse" not in text
    stages = tuple(replace(s, motion={"A": 0.2, "B": 0.001}) if s.stage == "presliding" else s for s in made.stages)
    assert "; at joint A it is worse for what is named." in sentences.how_far(replace(made, stages=stages))
    without = tuple(replace(s, motion={}) for s in made.stages)
    assert "Motion" not in sentences.how_far(replace(made, stages=without))


@pytest.mark.parametrize(
    ("verdict", "says"),
    [
        ("no_gap", "No unmodelled effect is named"),
        ("explained", "Presliding at joint A"),
        ("partly_explained", "This explains a part only"),
        ("unexplained", "No cause is named"),
    ],
)
def test_summary_says_verdict_and_cause(diagnosis, verdict, says):
    text = " ".join(printed(diagnosis(verdict)).split())
    assert text.startswith(words.VERDICT[verdict])
    assert says in text
    assert "noise floor" in text


def test_summary_of_hostile_names_is_plain_text(diagnosis):
    text = printed(diagnosis(arm="\x1b[31m[bold]arm[/nonsense]", joints=("[red]A", "B\x07")), width=200)
    assert "\x1b" not in text
    assert "\x07" not in text
    assert "[bold]arm[/nonsense]" in text
    assert "[red]A" in text


def test_partly_explained_without_a_name_claims_nothing(diagnosis):
    made = diagnosis("partly_explained", named=())
    assert sentences.which(made).startswith("No cause is named")
    assert "closes" not in sentences.how_far(made)


def test_presence_is_claimed_where_effects_share_the_probability(diagnosis):
    made = diagnosis()
    made = replace(made, causes=(replace(made.causes[0], probability=0.5, presence=0.98), *made.causes[1:]))
    assert "(probability 98\u00a0% that it is there)" in sentences.which(made)


def test_where_says_how_much_lies_at_the_joint_and_where_it_is_densest(diagnosis):
    place = Place("A", "actuator", "high velocity", Estimate(0.94, 0.88, 0.97))
    rest = Place("B", "unknown", "all motion", Estimate(0.05, 0.02, 0.1))
    text = sentences.where(replace(diagnosis(), where=(place, rest))).replace("\u00a0", " ")
    assert "94 % (88 to 97 %)" in text
    assert "at joint A, in the actuator stage, densest at high velocity" in text
    assert "at joint B, of unknown origin, densest throughout the motion" in text
    unnamed = sentences.where(replace(diagnosis("unexplained"), where=(place,)))
    assert "most like the actuator stage" in unnamed


def test_where_claims_no_stage_that_these_data_cannot_tell(diagnosis):
    channels = ("actuator", "rigid_body", "friction")
    place = Place("A", "actuator", "high velocity", Estimate(0.94, 0.88, 0.97), channels)
    assert "at joint A, in the actuator, rigid body or friction stage, densest" in sentences.where(
        replace(diagnosis(), where=(place,))
    )


def test_where_states_no_share_of_an_only_joint(diagnosis):
    place = Place("elbow", "external", "velocity reversal", Estimate(0.999, 0.999, 0.999))
    made = replace(diagnosis(joints=("elbow",)), where=(place,), delivered=(), before_measurement=None)
    head = "The gap that re-tuning leaves is"
    assert sentences.where(made) == f"{head} in the external stage, densest at velocity reversals."
    unknown = replace(place, channel="unknown")
    assert (
        sentences.where(replace(made, where=(unknown,))) == f"{head} of unknown origin, densest at velocity reversals."
    )
    assert sentences.where(replace(made, where=(unknown,), named=())) == f"{head} densest at velocity reversals."
    two = (
        replace(place, share=Estimate(0.9, 0.85, 0.93)),
        replace(place, channel="sensing", share=Estimate(0.1, 0.0, 0.2)),
    )
    text = sentences.where(replace(made, where=two)).replace("\u00a0", " ")
    assert text.startswith("90 % (85 to 93 %) of the gap that re-tuning leaves is in the external stage, densest")
    assert "; next, 10 % (0 to 20 %) in the sensing stage, densest" in text
    assert "elbow" not in text


def test_where_blames_nothing_where_no_share_is_told(diagnosis):
    """What the records show by themselves explains a gap that is none of the torque."""
    assert sentences.where(replace(diagnosis(), where=())).startswith("Nowhere beyond the noise")


def test_title_of_where_takes_its_share_from_the_region_it_names(diagnosis):
    made = diagnosis()
    region = next(r for r in made.regions if (r.joint, r.region) == ("B", "velocity reversal"))
    places = (Place("B", "friction", "velocity reversal", Estimate(0.8, 0.7, 0.9)),)
    places += (Place("B", "unknown", "velocity reversal", Estimate(0.1, 0.0, 0.2)),)
    text = sentences.finding(replace(made, where=places)).replace("\u00a0", " ")
    assert text == f"B holds 90 % of the gap; {100 * region.share.value:.0f} % of that lies at velocity reversals"
