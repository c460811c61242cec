"""What an effect looks like: the picture that lies beside the file of its class, where there is one."""

from __future__ import annotations

import inspect
from functools import cache
from pathlib import Path

from stribeck.model.effect import Effect
from stribeck.report.style import data_uri


def picture_file(effect: Effect) -> Path:
    """Return where the picture of an effect belongs: a PNG of the effect's name beside the file of its class.

    Raises
    ------
    OSError, TypeError
        For a class that was not read from a file.
    """
    return Path(inspect.getfile(type(effect))).with_name(f"{effect.name}.png")


@cache
def symptom_picture(effect: Effect) -> str:
    """Return the picture as a data URI, or "" without one.

    Every effect of the library has one, drawn by ``studies/symptoms.py``; one of another package may have its own.
    """
    try:
        return data_uri(picture_file(effect).read_bytes(), "png")
    except (OSError, TypeError):
        return ""
