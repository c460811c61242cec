"""The texts of an FMU: model description, build description, terminals and documentation, from jinja2 templates."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version

from jinja2 import Environment, PackageLoader, StrictUndefined

from stribeck.arm import Arm
from stribeck.export.structure import Structure
from stribeck.export.variables import Table

LOG_CATEGORIES = (
    ("logEvents", "changes of mode"),
    ("logStatusWarning", "warnings"),
    ("logStatusDiscard", "steps that could not be made"),
    ("logStatusError", "errors, and calls that are not allowed"),
    ("logAll", "everything"),
)
STOP_TIME, STEP_SIZE = 5.0, 0.01  # s, of the default experiment


@dataclass(frozen=True)
class Description:
    """What the texts of one FMU are made from.

    Attributes
    ----------
    arm : Arm
    table : Table
    structure : Structure
    token : str
        Digest of what is compiled.
    only_steps : str
        Why the model cannot be exchanged; empty where it can.
    """

    arm: Arm
    table: Table
    structure: Structure
    token: str
    only_steps: str

    @property
    def identifier(self) -> str:
        """The model identifier: the arm's name as C can write it."""
        return identifier_of(self.arm.name)


def identifier_of(name: str) -> str:
    """Return a name as an identifier of C: ``two-link arm`` is ``two_link_arm``."""
    text = re.sub(r"_+", "_", re.sub(r"[^A-Za-z0-9]", "_", name)).strip("_")[:60]
    return text if re.match(r"[A-Za-z]", text) else f"arm_{text}".rstrip("_")


def render(name: str, description: Description) -> str:
    """Return the text of one template."""
    arm, table = description.arm, description.table
    text: str = (
        _environment()
        .get_template(name)
        .render(
            arm=arm,
            description=f"{arm.name}: {arm.n} joint{'s' if arm.n > 1 else ''} with true stiction",
            token=description.token,
            version=_version(),
            identifier=description.identifier,
            only_steps=description.only_steps,
            units=sorted(table.units, key=lambda unit: unit.name),
            variables=table.variables,
            structure=description.structure,
            index=table.index,
            log_categories=LOG_CATEGORIES,
            stop_time=STOP_TIME,
            step_size=arm.sample_time or STEP_SIZE,
            effects=table.forward.path.placed,
        )
    )
    return text.rstrip() + "\n"


@cache
def _environment() -> Environment:
    loader = PackageLoader("stribeck.export", "templates")
    environment = Environment(loader=loader, autoescape=True, undefined=StrictUndefined)
    environment.filters["number"] = lambda value: repr(float(value))
    return environment


def _version() -> str:
    try:
        return version("stribeck")
    except PackageNotFoundError:  # run from the source tree
        return "0"
