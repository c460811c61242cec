"""Numbers as people read them: as many digits as the interval supports, units bound to their number."""

from __future__ import annotations

import math

from stribeck.gap.result import Estimate

NBSP = "\u00a0"
MINUS = "\u2212"
MOST = 6  # digits of a value, however narrow its interval: those of the files
NOTHING = 1e-12  # rad or m; a smaller error is rounding
_POWERS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: float, digits: int = 3) -> str:
    """Return ``value`` with ``digits`` significant digits, trailing zeros kept: 1.90, 0.100, 1.20 × 10⁻⁵."""
    if not math.isfinite(value):
        return "not known" if math.isnan(value) else f"{MINUS if value < 0 else ''}∞"
    if value == 0.0:
        return "0"
    return _fixed(value, digits - 1 - _exponent(value, digits))


def milli(value: float, digits: int = 3) -> str:
    """Return a position or an error in thousandths of its unit, rad or m; what is rounding is 0."""
    return number(1e3 * value if abs(value) > NOTHING else 0.0, digits)


def as_written(value: float) -> str:
    """Return a value that a person wrote, with at most six digits and no zeros added: 4, 0.17, 0.06."""
    text = number(value, 6)
    return text.rstrip("0").rstrip(".") if "." in text and "×" not in text else text


def with_unit(value: float, unit: str, digits: int = 3) -> str:
    """Return ``value`` and its unit; the unit "1" is left out."""
    text = number(value, digits)
    return f"{text}{NBSP}{unit_text(unit)}" if unit_text(unit) and math.isfinite(value) else text


def unit_text(unit: str) -> str:
    """Return a unit for display: nothing for "1", powers raised."""
    return "" if unit in ("", "1") else unit.replace("^2", "²").replace("^3", "³").replace(" ", NBSP)


def estimate(value: Estimate) -> str:
    """Return the value, without unit, with the digits that half its interval supports: two of that, six in all."""
    return number(value.value) if _places(value) is None else _fixed(value.value, _places(value) or 0)


def interval(value: Estimate) -> str:
    """Return "1410 to 1590" with the digits of :func:`estimate`; in words where it is not bounded."""
    if math.isnan(value.low) or math.isnan(value.high):
        return "not known"
    if not (math.isfinite(value.low) or math.isfinite(value.high)):
        return "not bounded"
    if value.low == value.value == value.high:
        return "exact"
    places = _places(value)
    low, high = (number(x) if places is None or not math.isfinite(x) else _fixed(x, places)
                 for x in (value.low, value.high))  # fmt: skip
    return f"{low} to {high}"


def percent(part: float) -> str:
    """Return a part of one in per cent: whole ones, one decimal below ten."""
    if not math.isfinite(part):
        return "not known"
    return f"{_percent_digits(part)}{NBSP}%"


def change(part: float) -> str:
    """Return a change by a part of one in per cent, with its sign; none where it rounds to nothing."""
    size = percent(abs(part))
    return size if size == percent(0.0) else f"{MINUS if part < 0.0 else '+'}{size}"


def percent_interval(value: Estimate) -> str:
    """Return "62 % (50 to 70 %)"; the value alone where the interval is not known."""
    if not (math.isfinite(value.low) and math.isfinite(value.high)):
        return percent(value.value)
    return f"{percent(value.value)} ({_percent_digits(value.low)} to {percent(value.high)})"


def probability(value: float) -> str:
    """Return a probability in per cent that never rounds to certainty."""
    if value > 0.999:
        return f"over 99.9{NBSP}%"
    if 0.0 < value < 0.001:
        return f"under 0.1{NBSP}%"
    return f"{100 * value:.1f}{NBSP}%" if value > 0.985 or 0.0 < value < 0.015 else percent(value)


def _percent_digits(part: float) -> str:
    value = 100.0 * round(part, 6)  # the digits that files have: they agree on what is all
    if 99.5 <= value < 100.0:
        return "99.9" if value > 99.9 else f"{value:.1f}"  # what is not all must not read as all
    text = f"{value:.0f}" if abs(value) >= 9.95 or abs(value - round(value)) < 0.05 else f"{value:.1f}"
    return "0" if text in ("-0", "-0.0") else text.replace("-", MINUS)


def _exponent(value: float, digits: int) -> int:
    """Return the power of ten of ``value`` after rounding to ``digits`` significant digits."""
    return int(f"{value:.{digits - 1}e}".split("e")[1])


def _places(value: Estimate) -> int | None:
    half = 0.5 * (value.high - value.low)
    if not (math.isfinite(half) and half > 0.0 and math.isfinite(value.value)):
        return None
    largest = max(abs(x) for x in (value.value, value.low, value.high))
    return min(1 - _exponent(half, 2), MOST - 1 - _exponent(largest, MOST))


def _fixed(value: float, places: int) -> str:
    """Return ``value`` rounded to ``places`` decimals, as a power of ten where zeros would fill the page."""
    value = round(value, places)
    if value == 0.0:
        return "0"
    exponent = math.floor(math.log10(abs(value)))
    if exponent >= -4 and (exponent < 6 or places > 0):
        return f"{value:.{max(places, 0)}f}".replace("-", MINUS)
    mantissa = value / 10.0**exponent
    power = str(exponent).translate(_POWERS)
    return f"{mantissa:.{min(max(exponent + places, 0), 6)}f}".replace("-", MINUS) + f"{NBSP}×{NBSP}10{power}"
