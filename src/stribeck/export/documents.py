"""The texts of an FMU: model description, build description, terminals and documentation, from jinja2 templates."""

from __future__ import annotations

import re
from dataclasses import dataclass, fields
from functools import cache, partial

from jinja2 import Environment, PackageLoader, StrictUndefined
from latex2mathml.converter import convert
from markupsafe import Markup

from stribeck.export.structure import Structure
from stribeck.export.variable import Variable, index_of, units_of
from stribeck.version import package_version

LOG_CATEGORIES = (
    ("logEvents", "changes of mode"),
    ("logStatusWarning", "warnings"),
    ("logStatusDiscard", "steps that could not be made"),
    ("logStatusError", "errors, and calls that are not allowed"),
    ("logAll", "everything"),
)


@dataclass(frozen=True)
class Description:
    """What the model description of one FMU is made from.

    Attributes
    ----------
    name, summary : str
    token : str
        Digest of what is compiled.
    identifier : str
        The model identifier, a name in C.
    variables : tuple of Variable
    structure : Structure
    only_steps : str
        Why the model cannot be exchanged; empty where it can.
    stop_time, step_size : float
        Of the default experiment, s.
    integrates : bool
        Whether it solves equations of motion, with their derivatives and events; else it is sampled.
    """

    name: str
    summary: str
    token: str
    identifier: str
    variables: tuple[Variable, ...]
    structure: Structure
    only_steps: str
    stop_time: float
    step_size: float
    integrates: bool = True


def identifier_of(name: str) -> str:
    """Return a name as an identifier of C: ``two-link arm`` is ``two_link_arm``."""
    text = re.sub(r"_+", "_", re.sub(r"[^A-Za-z0-9]", "_", name)).strip("_")[:60]
    return text if re.match(r"[A-Za-z]", text) else f"arm_{text}".rstrip("_")


def render(name: str, description: Description, fmi: int, **more: object) -> str:
    """Return the text of one template for a version of the standard; ``more`` is what that template alone needs."""
    values = {field.name: getattr(description, field.name) for field in fields(description)}
    values |= {
        "version": package_version(),
        "units": units_of(description.variables),
        "index": partial(index_of, description.variables),
        "log_categories": LOG_CATEGORIES,
        "fmi": fmi,
        "math": _math,
    }
    text: str = _environment().get_template(name).render(**values, **more)
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
