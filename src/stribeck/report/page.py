"""The page that every report shares: sections as values, one template each, one self-contained HTML file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import ClassVar

from jinja2 import Environment, PackageLoader, StrictUndefined


@dataclass(frozen=True)
class Section:
    """Base of all sections; subclass one for each kind, with a template of its own.

    ``title`` may be empty. A template sees its section as ``section``; everything in it is escaped.
    """

    template: ClassVar[str]
    title: str


@dataclass(frozen=True)
class Answer(Section):
    """The first screen: a badge and a few short answers, each (question, sentence).

    ``tone`` is ``good``, ``named``, ``partial`` or ``open``; ``subtitle`` says what was examined.
    """

    template: ClassVar[str] = "answer.html"
    badge: str
    tone: str
    subtitle: str
    answers: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Picture(Section):
    """A figure: ``source`` is a data URI, ``file`` the PNG beside the page, ``title`` the finding."""

    template: ClassVar[str] = "picture.html"
    source: str
    caption: str
    file: str


@dataclass(frozen=True)
class Row:
    """A row of a table; ``mark`` is empty, ``strong``, ``flag`` or ``muted``."""

    cells: tuple[str, ...]
    mark: str = ""


@dataclass(frozen=True)
class Table(Section):
    """A table; ``numeric`` holds the indices of columns that are set flush right."""

    template: ClassVar[str] = "table.html"
    columns: tuple[str, ...]
    rows: tuple[Row, ...]
    numeric: frozenset[int] = frozenset()
    note: str = ""


@dataclass(frozen=True)
class Bullets(Section):
    """A list of sentences; ``tone`` is empty or ``warning``."""

    template: ClassVar[str] = "bullets.html"
    items: tuple[str, ...]
    tone: str = ""


@dataclass(frozen=True)
class Facts(Section):
    """Pairs of a term and what it is."""

    template: ClassVar[str] = "facts.html"
    pairs: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Law:
    """A named law: its equation as a data URI (empty where it cannot be set) and in words.

    ``picture`` is what it looks like in the residual of an arm that has it, as a data URI; empty where there is none.
    ``drawn`` is the law that it shows, where that is another one of the family.
    """

    name: str
    equation: str
    image: str
    symptom: str
    source: str
    picture: str = ""
    drawn: str = ""


@dataclass(frozen=True)
class Laws(Section):
    """The laws behind the names that a page uses."""

    template: ClassVar[str] = "laws.html"
    laws: tuple[Law, ...]


@dataclass(frozen=True)
class Files(Section):
    """Files beside the page: (file name, what it is)."""

    template: ClassVar[str] = "files.html"
    files: tuple[tuple[str, str], ...]


def render(title: str, sections: Sequence[Section], footer: str = "") -> str:
    """Return the whole page as HTML; it loads nothing and runs nothing.

    Parameters
    ----------
    title : str
        Of the browser tab, and of the print.
    sections : sequence of Section
        In reading order.
    footer : str
        One line at the end, as of `footer_of`.
    """
    return _environment().get_template("page.html").render(title=title, sections=sections, footer=footer)


def footer_of(version: str) -> str:
    """Return the line at the end of a page, with the version of stribeck that found what it shows."""
    return f"stribeck {version}. This page is one file: it loads nothing and runs nothing."


@cache
def _environment() -> Environment:
    # autoescape for every template, whatever its suffix: names come from files that anyone may have written
    return Environment(
        loader=PackageLoader("stribeck.report", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
