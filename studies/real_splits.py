"""Question: does the verdict on a real arm depend on what is held out? The DFKI double pendulum, split at random.

Method: the recordings of design A.0 and of design C.1 (commanded torque) are cut into pieces of five seconds at most;
ten times a random third of the pieces is held out and the rest diagnosed. Held against one another: verdict and named
effects, and by how much the held-out torque residual lies below the re-tuned model's.
Expected: the same verdict in at least eight of ten splits, or an honest `unexplained`.
Source: dfki-ric-underactuated-lab/double_pendulum (BSD-3-Clause); skipped where the recordings are not at hand.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import typer
from _output import write
from real_pendulum import DATA
from rich import print as show

from stribeck.arm import Arm, load_arm
from stribeck.gap import diagnose
from stribeck.identify.stretches import part
from stribeck.run import Run, load_run

PIECE = 5.0  # s
HELD = 1.0 / 3.0
DESIGNS = ("design-A.0", "design-C.1")


def pieces(runs: Sequence[Run]) -> list[Run]:
    """Return the runs cut into pieces of equal length, at most PIECE long."""
    out: list[Run] = []
    for run in runs:
        count = int(np.ceil(run.duration / PIECE - 0.1))
        edges = np.linspace(0, len(run.t), count + 1).astype(int)
        out += [replace(part(run, *ends), name=f"{run.name}, part {k}") for k, ends in enumerate(pairwise(edges))]
    return out


def one(arm: Arm, cut: Sequence[Run], seed: int, jobs: int) -> dict[str, Any]:
    """Diagnose with a random third held out."""
    order = np.random.default_rng(seed).permutation(len(cut))
    out = set(order[: max(1, round(HELD * len(cut)))].tolist())
    fit, held = ([run for i, run in enumerate(cut) if (i in out) == side] for side in (False, True))
    found = diagnose(arm, fit, held, jobs=jobs)
    stages = {stage.stage: dict(stage.torque) for stage in found.stages}
    corrected = found.stages[-2].torque  # the last is the noise floor
    return {
        "verdict": found.verdict,
        "named": sorted(found.named),
        "presence": {f"{c.effect}, {', '.join(c.joints)}": c.presence for c in found.causes if c.joints},
        "retuned_below_published": {j: 1.0 - v / stages["as_given"][j] for j, v in stages["retuned"].items()},
        "corrected_below_retuned": {j: 1.0 - corrected[j] / v for j, v in stages["retuned"].items()},
    }


def main(data: Path = DATA, splits: int = 10, jobs: int = 2) -> None:
    """Diagnose every split and count the verdicts."""
    if not data.is_dir():
        print(f"skipped: no recordings in {data}; get them from the repository named above", file=sys.stderr)
        raise typer.Exit
    result: dict[str, Any] = {}
    for design in DESIGNS:
        arm = load_arm(data / design / "arm.toml")
        cut = pieces([load_run(path, arm.n) for path in sorted((data / design).glob("run_*.csv"))])
        rows = [one(arm, cut, seed, jobs) for seed in range(splits)]
        answers = Counter(f"{row['verdict']}: {', '.join(row['named']) or 'nothing named'}" for row in rows)
        result[design] = {"same": max(answers.values()) / splits, "answers": dict(answers), "splits": rows}
        show(design, result[design])
    print(f"written to {write('real_splits', result)}")


if __name__ == "__main__":
    typer.run(main)
