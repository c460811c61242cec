"""The table of what each recording leaves."""

from __future__ import annotations

from stribeck.gap.result import Diagnosis, Recording
from stribeck.report import words
from stribeck.report.numbers import number, unit_text
from stribeck.report.page import Row, Table

LISTED = 20


def recording_table(diagnosis: Diagnosis) -> Table | None:
    """Return what each recording leaves at each joint, re-tuned and corrected, beside its noise; None without any.

    Of many recordings, those that leave most over their noise.
    """
    gathered: dict[tuple[str, bool], list[Recording]] = {}
    for row in diagnosis.recordings:
        gathered.setdefault((row.run, row.held_out), []).append(row)
    if not gathered:
        return None
    loudest = sorted(gathered, key=lambda key: -_over_noise(gathered[key]))[:LISTED]
    stages = ("re-tuned", "corrected", "noise") if diagnosis.named else ("re-tuned", "noise")
    unit = unit_text(words.torque_unit(diagnosis))
    columns = ["recording", ""]
    columns += [f"{words.clean(joint)} {stage}, {unit}" for joint in diagnosis.joints for stage in stages]
    rows = []
    for run, held_out in (key for key in gathered if key in loudest):
        at = {row.joint: row for row in gathered[run, held_out]}
        values = [value for joint in diagnosis.joints for value in _values(at[joint], named=bool(diagnosis.named))]
        rows.append(Row((words.clean(run), "held out" if held_out else "fitted", *map(number, values))))
    more = len(gathered) - len(rows)
    note = f"Rms of the {words.effort(diagnosis)} that is left, and the noise floor of the same rows." + (
        f" The {LISTED} that leave most over it; {more} more leave less." if more else ""
    )
    return Table("Recording by recording", tuple(columns), tuple(rows), frozenset(range(2, len(columns))), note)


def _over_noise(rows: list[Recording]) -> float:
    return max(row.corrected / max(row.noise, 1e-300) for row in rows)


def _values(row: Recording, *, named: bool) -> tuple[float, ...]:
    return (row.retuned, row.corrected, row.noise) if named else (row.retuned, row.noise)
