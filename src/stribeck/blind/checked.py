"""What a score takes from an answer, so that a file that lacks some of it is told of by its name and the key."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel, TypeAdapter

from stribeck.errors import InputError
from stribeck.textfile import structure


class _Value(BaseModel):
    value: float | None


class _Bounded(_Value):
    ci95: tuple[float | None, float | None]


class _Gap(BaseModel):
    closed: _Value | None


class _Place(BaseModel):
    joint: str
    channel: str


class _Cause(BaseModel):
    effect: str
    probability: float
    presence: float | None = None
    joints: list[str] = []
    equivalent: list[str] = []
    parameters: dict[str, dict[str, _Bounded]] = {}


class _Found(BaseModel):
    verdict: str
    named: list[str]
    causes: list[_Cause]
    where: list[_Place]
    gap: _Gap
    settings: dict[str, Any]


class _Answer(BaseModel):
    files: str
    leave_out: list[str]
    code: str
    seconds: float
    processor_seconds: float


class _Failed(_Answer):
    error: str


class _Told(_Answer):
    diagnosis: _Found
    retuned: str
    corrected: str


_FAILED, _TOLD = TypeAdapter(_Failed), TypeAdapter(_Told)


def check_answer(answer: Mapping[str, Any], path: Path) -> None:
    """Raise `InputError`, one line with file and key, where an answer lacks what a score takes from it."""
    if "error" in answer:
        structure(answer, _FAILED, str(path))
        return
    structure(answer, _TOLD, str(path))
    found = answer["diagnosis"]
    whole = {cause["effect"] for cause in found["causes"] if {"joints", "equivalent", "parameters"} <= cause.keys()}
    for name in found["named"]:
        if name not in whole:
            raise InputError(
                f"{path}: diagnosis.named is no cause of diagnosis.causes", name, "diagnose the case again"
            )
