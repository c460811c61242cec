"""The header of a run: which columns an arm needs, and which of those that are there are probably meant."""

from __future__ import annotations

import re
from collections.abc import Sequence

_UNIT = re.compile(r"\s*[\[(].*[\])]$|[_ ](?:s|sec|rad|n\.?m)$")  # as in "q1 [rad]" and "q1_rad"
_ALIKE = {
    "t": ("t", "time", "timestamp"),
    "q": ("q", "pos", "position", "angle", "theta"),
    "tau": ("tau", "torque", "tau_cmd", "torque_cmd"),
}


def is_number(text: str) -> bool:
    """Return whether a header's entry is a number: then row 1 is a sample, not a header."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def to_do(missing: Sequence[str], names: Sequence[str], required: Sequence[str], n: int) -> str:
    """Return what to do about columns that a header misses.

    Parameters
    ----------
    missing, names, required : sequence of str
        Columns that are not there, those that are, and all that must be.
    n : int
        Number of the arm's joints.
    """
    meant = {wanted: found for wanted in missing if (found := _meant(wanted, names, n)) is not None}
    arm = f"this arm has {n} joint{'s' if n > 1 else ''}"
    exactly = f"the header must name them exactly: {', '.join(required)} ({arm})"
    renamed = ", ".join(f"{found!r} to {wanted}" for wanted, found in meant.items())
    return f"rename {renamed}; {exactly}" if renamed else exactly


def _meant(wanted: str, names: Sequence[str], n: int) -> str | None:
    """Return the one column that is probably ``wanted``; None where there is none, or more than one."""
    found = re.fullmatch(r"([a-z]+?)(\d*)", wanted)
    assert found is not None
    kind, number = found.groups()
    numbers = ("", "1") if n == 1 and number else (number,)
    alike = {f"{name}{between}{k}" for name in _ALIKE[kind] for k in numbers for between in ("", "_", " ")}
    near = [name for name in names if _UNIT.sub("", name.casefold()) in alike]
    return near[0] if len(near) == 1 else None
