"""The page and the PNG files of a whole report."""

from __future__ import annotations

import re
import struct
from html.parser import HTMLParser

import pytest

CASES = ("no_gap", "explained", "class", "partly_explained", "unexplained", "hostile")
DRAWN = ("explained",)  # the others' figures take their time
VOID = {"meta", "img", "br", "link"}


class Reader(HTMLParser):
    """Collects tags, addresses and text, and checks that tags close in order."""

    def __init__(self):
        super().__init__()
        self.tags, self.addresses, self.open, self.parts = [], [], [], []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.addresses += [value for name, value in attrs if name in ("src", "href", "action", "srcset")]
        assert not [name for name, _ in attrs if name.startswith("on")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if not self.open or self.open[-1] != "style":
            self.parts.append(data)

    @property
    def text(self):
        return " ".join(" ".join(self.parts).replace("\u00a0", " ").split())


def read(folder):
    reader = Reader()
    reader.feed((folder / "report.html").read_text(encoding="utf-8"))
    reader.close()
    assert reader.open == []
    return reader


@pytest.mark.long
@pytest.mark.parametrize("case", CASES)
def test_page_is_one_file_that_loads_and_runs_nothing(written, case):
    _, folder = written(case, case in DRAWN)
    page = read(folder)
    assert not {"script", "link", "iframe", "object", "base", "form"} & set(page.tags)
    files = {path.name for path in folder.iterdir()} | {"diagnosis.json", "corrected.toml"}
    outside = [a for a in page.addresses if not a.startswith("data:image/")]
    assert set(outside) <= files
    assert "url(" not in (folder / "report.html").read_text(encoding="utf-8")
    assert page.tags.count("img") >= 4


@pytest.mark.long
@pytest.mark.parametrize("case", [pytest.param(c, marks=[] if c in DRAWN else pytest.mark.slow) for c in CASES])
def test_figures_are_written_as_png_of_a_readable_size(written, case):
    _, folder = written(case)
    names = {path.name for path in folder.glob("*.png")}
    always = {"measured_nominal_corrected.png", "residual.png", "waterfall.png", "where.png"}
    assert names == (always if case == "no_gap" else always | {"candidates.png"})
    for name in names:
        content = (folder / name).read_bytes()
        assert content[:8] == b"\x89PNG\r\n\x1a\n"
        width, height = struct.unpack(">II", content[16:24])
        assert 900 <= width <= 3000, name
        assert 350 <= height <= 3000, name
        assert len(content) > 20_000, name


def test_a_hostile_name_is_text_and_nothing_else(written):
    _, folder = written("hostile", drawn=False)
    page = read(folder)
    assert "<img src=x onerror=alert(1)>" in page.text  # shown as it was written
    assert "x" not in page.addresses
    assert "\x1b" not in page.text


def test_named_effect_is_claimed_with_probability_parameters_and_intervals(written):
    text = read(written("explained")[1]).text
    assert "Presliding at joint A (probability 97 % that it is there)." in text
    assert "stiffness 1502 1411 to 1594 N m/rad" in text
    assert "closes 91 % (88 to 93 %) of the torque gap above the noise floor" in text
    assert "velocity reversals" in text


def test_inseparable_effects_are_never_claimed_alone(written):
    _, folder = written("class", drawn=False)
    text = read(folder).text
    assert "Presliding or backlash at joint A (97 % together): these data cannot tell which." in text
    assert "Presliding at A removes" not in text
    assert "micro-amplitude reversals" in text  # the experiment that would tell


@pytest.mark.parametrize("case", ["no_gap", "unexplained"])
def test_abstention_claims_no_cause(written, case):
    text = read(written(case, drawn=False)[1]).text
    assert ("No unmodelled effect is named" if case == "no_gap" else "No cause is named") in text
    assert "Parameters of the named effects" not in text
    assert "What these effects are" not in text
    assert not re.search(r"closes \d", text)
    assert "corrected:" not in text


def test_partly_explained_says_that_the_rest_has_no_cause(written):
    text = read(written("partly_explained", drawn=False)[1]).text
    assert "This explains a part only; for the rest no cause is named." in text


def test_a_single_recording_is_not_said_to_be_judged_on_another(written):
    text = read(written("single", drawn=False)[1]).text
    assert "fitted to the first part of a run, judged on the last part of it." in text
    assert "above the noise floor, on a part that was not fitted." in text
    assert "run_00.csv, the last part of it" in text
    assert "held-out run" not in text
    assert "runs that were" not in text
    several = read(written("explained")[1]).text
    assert "fitted to 4 runs, judged on 2 held-out runs." in several
    assert "above the noise floor, on runs that were not fitted." in several


def test_prismatic_axis_is_in_newton_and_metre(written):
    text = read(written("partly_explained", drawn=False)[1]).text
    assert "J1 force, N " in text
    assert "Force rms" in text
    assert "orque" not in text.split("What these effects are")[0]
    assert "J1 motion, m " in text


def test_value_at_its_limit_is_flagged_and_warned_of(written):
    page = (written("explained")[1] / "report.html").read_text(encoding="utf-8")
    row = next(line for line in page.splitlines() if "A.com_x" in line and "<tr" in line)
    assert 'class="flag"' in row
    assert "at its limit" in row
    assert "Mind this" in page


@pytest.mark.slow  # one figure is below
def test_the_same_diagnosis_gives_the_same_page(written, tmp_path):
    from stribeck.report import write_report

    diagnosis, folder = written("explained")
    write_report(diagnosis, tmp_path)
    for path in tmp_path.iterdir():
        assert path.read_bytes() == (folder / path.name).read_bytes(), path.name


@pytest.mark.long
def test_the_same_figure_gives_the_same_bytes(diagnosis):
    from stribeck.report.figures.where import where_figure
    from stribeck.report.style import png_and_svg

    assert png_and_svg(where_figure(diagnosis(duration=3.0))) == png_and_svg(where_figure(diagnosis(duration=3.0)))
