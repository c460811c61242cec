"""The key of sealed cases, believed only when it is the one whose digest was shown before the answers were in."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, StrictBool
from pydantic_core import PydanticCustomError

from stribeck.arm.values import Finite, NotNegative
from stribeck.blind.comparable import true_values
from stribeck.blind.files import checked, read_answer, read_json, read_settings
from stribeck.errors import InputError
from stribeck.textfile import read_whole
from stribeck.withheld.injections import RULES
from stribeck.withheld.seal import KEY_SCHEMA


@dataclass(frozen=True)
class _Hidden:
    effect: str
    joint: str
    parameters: dict[str, Finite]
    strength: NotNegative
    strength_left: NotNegative | None = None  # older keys have none

    def __post_init__(self) -> None:
        if self.effect not in RULES:
            raise PydanticCustomError("hidden", "must be an effect of the plant")
        try:
            true_values(self.effect, self.parameters)
        except KeyError as error:
            raise PydanticCustomError("hidden", "must have the parameter {name}", {"name": error.args[0]}) from None


@dataclass(frozen=True)
class _Truth:
    files: str
    level: str | None
    known: StrictBool
    effects: tuple[_Hidden, ...]
    disturbances: tuple[_Hidden, ...]
    worth: dict[str, Finite] = field(default_factory=dict)
    laboratory: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class _Key:
    cases: Annotated[dict[Annotated[str, Field(pattern="^case_[0-9]+$")], _Truth], Field(min_length=1)]


@dataclass(frozen=True)
class Opened:
    """Answers and truths side by side, by case; ``settings`` are those of the answers, ``digest`` that of the key."""

    digest: str
    settings: dict[str, Any]
    truths: dict[str, dict[str, Any]]
    answers: dict[str, dict[str, Any]]


def open_sealed(results: Path, key: Path, *, partial: bool = False) -> Opened:
    """Return answers with their truths.

    Parameters
    ----------
    results : path
        What ``withheld diagnose`` wrote.
    key : path
        What ``withheld record`` wrote beside the cases.
    partial : bool
        Whether the cases that have no answer yet may be left out.

    Raises
    ------
    InputError
        When the key is not the one that was sealed or lacks what is scored, an answer belongs to other recordings than
        those in the key, or answers are missing or are not as ``withheld diagnose`` writes them.
    """
    settings = read_settings(results)
    digest = _digest(key)
    if digest != settings["digest"]:
        what = f"{key}: is not the key of these cases"
        raise InputError(what, f"digest {digest[:12]}..", f"the sealed digest is {settings['digest'][:12]}..")
    truths = checked(read_json(key, KEY_SCHEMA, "not a key"), _Key, key)["cases"]
    missing = [name for name in truths if not (results / f"{name}.json").exists()]
    if missing and (not partial or len(missing) == len(truths)):
        what = f"{results}: {len(missing)} of {len(truths)} cases have no answer"
        raise InputError(what, missing[0], "run withheld diagnose again; it goes on where it stopped")
    answers = {n: read_answer(results / f"{n}.json") for n in truths if n not in missing}
    for name, answer in answers.items():
        if answer["files"] != truths[name]["files"]:
            what = f"{results / name}.json: answers another recording than the one in the key"
            raise InputError(what, str(answer["files"])[:12], "diagnose the cases as they were recorded")
    return Opened(digest, settings, {name: truths[name] for name in answers}, answers)


def _digest(path: Path) -> str:
    try:
        return hashlib.sha256(read_whole(path, "give the key file")).hexdigest()
    except OSError as error:
        raise InputError(f"{path}: cannot be read", str(error.strerror), "give the key file") from None
