"""Answers and their settings, read back: in the form that the score takes them in, or refused by file and key."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, TypeAdapter
from pydantic_core import PydanticCustomError

from stribeck.arm.values import Finite
from stribeck.errors import InputError
from stribeck.textfile import read_whole, structure

SCHEMA, ANSWER_SCHEMA = "stribeck.withheld-results/1", "stribeck.withheld-answer/1"
SETTINGS = "settings.json"

Names = tuple[str, ...]
Chance = Annotated[Finite, Field(ge=0.0, le=1.0)]


@dataclass(frozen=True)
class _Settings:
    digest: str
    code: str
    library: Names


@dataclass(frozen=True)
class _Done:
    files: str
    leave_out: Names
    code: str
    seconds: Finite
    processor_seconds: Finite


@dataclass(frozen=True)
class _Failed(_Done):
    error: str


@dataclass(frozen=True)
class _Parameter:
    value: Finite | None
    ci95: tuple[Finite | None, Finite | None]


@dataclass(frozen=True)
class _Cause:
    effect: str
    probability: Chance | None
    presence: Chance | None = None
    joints: Names | None = None
    equivalent: Names | None = None
    parameters: dict[str, dict[str, _Parameter]] | None = None
    law: dict[str, str] | None = None

    def __post_init__(self) -> None:
        if self.effect not in ("none", "unknown") and None in (self.joints, self.equivalent, self.parameters):
            raise PydanticCustomError("cause", "must have joints, equivalent and parameters")


@dataclass(frozen=True)
class _Place:
    joint: str
    channel: str


@dataclass(frozen=True)
class _Closed:
    value: Finite


@dataclass(frozen=True)
class _Gap:
    closed: _Closed | None


@dataclass(frozen=True)
class _Found:
    verdict: str
    named: Names
    causes: tuple[_Cause, ...]
    where: tuple[_Place, ...]
    gap: _Gap

    def __post_init__(self) -> None:
        if not set(self.named) <= {cause.effect for cause in self.causes}:
            raise PydanticCustomError("named", "must have a cause for every name in named")


@dataclass(frozen=True)
class _Answered(_Done):
    diagnosis: _Found
    retuned: str | None = None
    corrected: str | None = None

    def __post_init__(self) -> None:
        if self.diagnosis.gap.closed is not None and None in (self.retuned, self.corrected):
            raise PydanticCustomError("arms", "must have retuned and corrected, of which gap.closed tells")


def read_settings(folder: Path) -> dict[str, Any]:
    """Return the settings of a folder of answers; raise `InputError` where there are none, or others than the score's.

    Parameters
    ----------
    folder : path
        What ``withheld diagnose`` wrote.
    """
    content = read_json(folder / SETTINGS, SCHEMA, "not a folder of answers")
    return checked(content, _Settings, folder / SETTINGS)


def read_answer(path: Path) -> dict[str, Any]:
    """Return an answer; raise `InputError` for one that lacks what the score reads, or has it in another type.

    Parameters
    ----------
    path : path
        ``case_0001.json``, ..
    """
    content = read_json(path, ANSWER_SCHEMA, "not an answer")
    return checked(content, _Failed if "error" in content else _Answered, path)


def read_json(path: Path, schema: str, what: str) -> dict[str, Any]:
    """Return the content of a JSON file of a schema; raise `InputError`, with `what` it is then, for any other."""
    try:
        text = read_whole(path, what)
    except OSError as error:
        raise InputError(f"{path}: cannot be read", str(error.strerror), what) from None
    return parse_json(text, path, schema, what)


def parse_json(text: bytes, path: Path, schema: str, what: str) -> dict[str, Any]:
    """Return the content of a file, as :func:`read_json` does, whose bytes are already here."""
    try:
        content = json.loads(text.decode("utf-8"))
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: is not JSON", str(error), what) from None
    if not isinstance(content, dict) or content.get("schema") != schema:
        found = content.get("schema", "no schema") if isinstance(content, dict) else type(content).__name__
        raise InputError(f"{path}: schema must be '{schema}'", str(found), what)
    return content


def checked(content: dict[str, Any], form: type, path: Path) -> dict[str, Any]:
    """Return the content itself; raise `InputError` where it lacks what a `form` has, or has it in another type."""
    structure(content, _adapter(form), str(path))
    return content


@cache
def _adapter(form: type) -> TypeAdapter[Any]:
    return TypeAdapter(form)
