"""What was found of an FMU, as lines to print."""

from __future__ import annotations

from stribeck.export.validate.check import Validation


def told(found: Validation) -> list[str]:
    """Return the lines: what it is, how far it departs from the simulator, what was skipped, and the problems."""
    lines = list(found.facts)
    lines += [
        f"{one.kind}: at most {one.position:.2g} {one.unit} from the arm's own simulator, "
        f"{one.events} stick-slip events"
        for one in found.deviations
    ]
    lines += [f"skipped: {text}" for text in found.skipped]
    lines += [f"problem: {text}" for text in found.problems]
    return [*lines, _count(len(found.problems))]


def _count(problems: int) -> str:
    return "no problems" if not problems else f"{problems} problem{'s' * (problems > 1)}"
