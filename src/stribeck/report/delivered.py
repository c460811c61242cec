"""The table of measured beside commanded torque."""

from __future__ import annotations

from stribeck.gap.result import Delivered, Diagnosis, Estimate
from stribeck.report import words
from stribeck.report.numbers import estimate, interval, number, percent_interval, unit_text
from stribeck.report.page import Row, Table


def delivered_table(diagnosis: Diagnosis) -> Table | None:
    """Return measured beside commanded torque; None where the recordings do not hold both."""
    rows = tuple(
        Row(
            (
                words.clean(row.joint),
                estimate(row.gain),
                interval(row.gain),
                estimate(row.offset),
                interval(row.offset),
                estimate(_in_ms(row.delay)),
                interval(_in_ms(row.delay)),
                number(row.left),
                _share(row),
            )
        )
        for row in diagnosis.delivered
    )
    whole = diagnosis.before_measurement
    if whole and len(rows) > 1:
        rows = (*rows, Row(("all", *[""] * 7, percent_interval(whole))))
    effort, unit = words.effort(diagnosis), unit_text(words.torque_unit(diagnosis))
    between = "95 % interval"
    columns = (
        "at",
        "gain",
        between,
        f"offset, {unit}",
        between,
        "delay, ms",
        between,
        f"left, {unit}",
        "of the gap, at least",
    )
    note = (
        f"Measured {effort} as gain times the commanded one, late by the delay, plus the offset, and what that leaves, "
        "rms. A delay of up to one sample may be the logging's. Of the gap: what is gone of it on the "
        f"{words.held(diagnosis)} with the measured {effort} in the command's place; it arises before the measurement. "
        "What gain and offset close counts for nothing of it: the sensor's own look like the drive's. Nor does what is "
        "gone at a joint whose torque is as commanded: it was another joint's drive."
    )
    title = f"Measured beside commanded {effort}"
    return Table(title, columns, rows, frozenset(range(1, len(columns))), note) if rows else None


def _share(row: Delivered) -> str:
    if row.share:
        return percent_interval(row.share)
    return "no gap" if row.gain.low * row.gain.high > 0.0 else "not known"


def _in_ms(time: Estimate) -> Estimate:
    return Estimate(1e3 * time.value, 1e3 * time.low, 1e3 * time.high, "ms")
