"""Question: does the proposed next experiment settle what poor recordings leave open, better than others? See README.

Method: an independent plant with one hidden effect records two short, small motions. Where the diagnosis names a
class, or nothing although something came near, its next experiment is recorded: the plant's own loop follows the
reference file within noise, encoder and torque limit of the case. Old and new recordings are then diagnosed together.
The same with two rivals of equal length within the same range, speed and torque: motions past random points, and the
programme, of the same kinds of motion, that is D-optimal for the re-tuned model. Resolved: the hidden effect is named,
alone or with those that no motion of this arm tells from it, and nothing else. Where a change of the arm or its stand
is proposed, the candidates are refitted with the change known, and must come out apart; so they must for the rivals.
Expected: three quarters resolved, more than by either rival. Source: Atkinson & Fedorov (1975) for the criterion.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import typer
from _next_answers import METHODS, answered
from _next_cases import EFFECTS, poor_case
from _next_figure import next_figure
from _next_table import counts, in_words, summary
from _output import OUT, write

from stribeck.errors import StribeckError


def main(
    cases: int = 12, seed: int = 9000, at_most: int = 60, effects: str = "", joints: str = "1,2", fresh: bool = False
) -> None:
    """Draw cases until so many are open, record, diagnose, count; ``--fresh`` forgets those of an earlier run."""
    work = OUT / "next_experiment" / "work"
    if fresh:
        shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True, exist_ok=True)
    names = effects.split(",") if effects else list(EFFECTS)
    rows: list[dict[str, Any]] = []
    numbers = tuple(int(count) for count in joints.split(","))
    for number, effect in _drawn(names, seed, at_most):
        rows.append(_row(work, number, effect, numbers))
        print(in_words(rows[-1]), flush=True)
        if sum(counts(row) for row in rows) >= cases:
            break
    result = summary(rows)
    print("\n".join(f"{method}: {result['resolved'][method]}" for method in METHODS))
    print(f"written to {write('next_experiment', result, resolved=next_figure(result))}")


def _drawn(names: list[str], seed: int, at_most: int) -> Iterator[tuple[int, str]]:
    """Yield seeds and effects, every effect as often as the others, in a drawn order."""
    rng = np.random.default_rng(seed)
    order: list[str] = []
    for k in range(at_most):
        if not order:
            order = [str(name) for name in rng.permutation(names)]
        yield seed + k, order.pop()


def _row(work: Path, seed: int, effect: str, joints: tuple[int, ...]) -> dict[str, Any]:
    file = work / f"{seed}_{effect}_{''.join(map(str, joints))}.json"
    if not file.exists():
        try:
            row = answered(poor_case(seed, effect, joints))
        except StribeckError as error:  # an arm that cannot be held is no recording
            row = {"seed": seed, "effect": effect, "open": False, "error": str(error)}
        file.write_text(json.dumps(row, default=float), encoding="utf-8")
    return dict(json.loads(file.read_text(encoding="utf-8")))


if __name__ == "__main__":
    typer.run(main)
