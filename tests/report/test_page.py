"""Sections and the page that other reports share."""

from __future__ import annotations

import dataclasses

import pytest

from stribeck.effects.registry import laws
from stribeck.report import page
from stribeck.report.equation import equation_image
from stribeck.report.page import Answer, Bullets, Facts, Files, Law, Laws, Picture, Row, Section, Table, render

NASTY = "</style></td><b onclick='x'>&\"{{ 7 * 7 }}"
SECTIONS = (
    Answer(NASTY, NASTY, "good", NASTY, ((NASTY, NASTY),)),
    Picture(NASTY, "data:image/png;base64,AAAA", NASTY, NASTY),
    Table(NASTY, (NASTY, NASTY), (Row((NASTY, NASTY), "flag"),), frozenset({1}), NASTY),
    Bullets(NASTY, (NASTY,), "warning"),
    Facts(NASTY, ((NASTY, NASTY),)),
    Laws(NASTY, (Law(NASTY, NASTY, "", NASTY, NASTY, NASTY),)),
    Files(NASTY, ((NASTY, NASTY),)),
)


def test_every_field_of_every_section_is_escaped():
    text = render(NASTY, SECTIONS, NASTY)
    assert "onclick='x'" not in text
    assert "<b " not in text
    assert text.count("</style>") == 1
    assert "49" not in text.split("</style>")[1]


def test_every_kind_of_section_is_covered_above():
    kinds = {kind for kind in vars(page).values() if dataclasses.is_dataclass(kind) and issubclass(kind, Section)}
    assert kinds - {Section} == {type(section) for section in SECTIONS}


@pytest.mark.long
def test_every_effects_equation_can_be_set():
    failed = [effect.label for effect in laws().values() if not equation_image(effect.equation).startswith("data:")]
    assert failed == []


def test_an_equation_beyond_mathtext_is_left_to_text():
    assert equation_image(r"\begin{cases} x \end{cases}") == ""


def test_the_footer_tells_the_version():
    assert page.footer_of("1.2.3") == "stribeck 1.2.3. This page is one file: it loads nothing and runs nothing."
