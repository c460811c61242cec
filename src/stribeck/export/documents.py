"""The texts of an FMU: model description, build description, terminals and documentation, from jinja2 templates."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version

from jinja2 import Environment, PackageLoader, StrictUndefined
from latex2mathml.converter import convert
from markupsafe import Markup

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


def render(name: str, description: Description, fmi: int) -> str:
    """Return the text of one template for a version of the standard."""
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
            bristles=[name for name, bristle in zip(arm.names, table.forward.bristles, strict=True) if bristle],
            fmi=fmi,
            math=_math,
        )
    )
    return text.rstrip() + "\n"


@cache
def _environment() -> Environment:
    loader = PackageLoader("stribeck.export", "templates")
    environment = Environment(loader=loader, autoescape=True, undefined=StrictUndefined)
    environment.filters["number"] = lambda value: repr(float(value))
    return environment


def _math(latex: str) -> Markup:
    """Return an equation as MathML, which browsers set without a script; as it is where it is beyond the converter."""
    try:
        return Markup(convert(latex, display="block"))  # elements of the converter's own, its text escaped
    except Exception:  # the converter's errors have no base of their own; the law may be a third party's
        return Markup("<code>") + latex + Markup("</code>")


def _version() -> str:
    try:
        return version("stribeck")
    except PackageNotFoundError:  # run from the source tree
        return "0"
