"""Sentences and the terminal summary."""

from __future__ import annotations

import io
from dataclasses import replace

import pytest
from rich.console import Console

from stribeck.gap.result import Cause
from stribeck.report import sentences, summary, words


def printed(diagnosis, width=100):
    stream = io.StringIO()
    Console(file=stream, width=width, force_terminal=True, color_system=None).print(summary(diagnosis))
    return stream.getvalue()


def test_effects_and_regions_in_words():
    assert words.effect("position_dependent_friction") == "position-dependent friction"
    assert words.stage("presliding") == "+ presliding"
    assert words.region("velocity_reversal") == "at velocity reversals"
    assert words.region("low velocity") == "at low velocity"
    assert words.region("0.2 to 0.4 rad") == "in “0.2 to 0.4 rad”"
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


def test_two_effects_are_both_claimed(diagnosis):
    text = sentences.which(diagnosis(named=("presliding", "cable_spring"))).replace("\u00a0", " ")
    assert text == "Presliding at joint A (probability 97 %); and cable spring at joint B (probability 90 %)."


def test_how_far_without_anything_closable_gives_the_numbers_alone(diagnosis):
    text = sentences.how_far(replace(diagnosis(), closed=None))
    assert text.startswith("Torque rms, as given → re-tuned → corrected: A ")


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
