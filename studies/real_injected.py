"""Question: is an effect named that is put into the recordings of a real arm? The DFKI double pendulum, once more.

Method: to the commanded torque of the DFKI double pendulum, design C.1, is added what an effect would have asked for
along the recorded motion: ten laws by formula, one of them in no library, at each joint, as strong as what re-tuning
leaves there without them, and twice as strong. The motion is the one that was recorded, so that a drive that had to
overcome the effect would have got this command. Named right, wrong, or not; and by how much the re-tuned gap grew.
Expected: named where the gap grows by as much as the arm's own; nothing named for the law outside the library.
Source: dfki-ric-underactuated-lab/double_pendulum (BSD-3-Clause); skipped where the recordings are not at hand.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import typer
from _output import write
from _real_figure import figure
from _real_laws import LAWS, OUTSIDE, put_in
from joblib import Parallel, delayed
from real_pendulum import DATA
from rich import print as show

from stribeck.arm import Arm, load_arm
from stribeck.gap import diagnose
from stribeck.run import Run, load_run

DESIGN = "design-C.1"
SIZES = (1.0, 2.0)  # of what re-tuning leaves at the joint


def look(arm: Arm, runs: list[Run]) -> dict[str, Any]:
    """Diagnose; return what is named and how surely, and what re-tuning leaves, N m rms."""
    found = diagnose(arm, runs, jobs=1)
    left = next(stage.torque for stage in found.stages if stage.stage == "retuned")
    causes = {c.effect: (c.presence or 0.0, c.joints, c.equivalent) for c in found.causes if c.joints}
    return {"verdict": found.verdict, "named": list(found.named), "left": dict(left), "causes": causes}


def row(law: str, joint: str, size: float, found: dict[str, Any], plain: dict[str, Any]) -> dict[str, Any]:
    """Return one line of the table: of an effect put in at a joint."""
    acting = {n for n, (_, at, alike) in found["causes"].items() if law in (n, *alike) and joint in at}
    wrong = [name for name in found["named"] if name not in acting and name not in plain["named"]]
    grown = np.sqrt(max(found["left"][joint] ** 2 - plain["left"][joint] ** 2, 0.0)) / plain["left"][joint]
    return {
        "effect": law, "joint": joint, "size": size, "gap_grown": float(grown), "verdict": found["verdict"],
        "named": found["named"], "right": bool(acting & set(found["named"])), "wrong": wrong,
        "presence": max((found["causes"][name][0] for name in acting), default=0.0),
    }  # fmt: skip


def main(data: Path = DATA, jobs: int = 2) -> None:
    """Put every law in at every joint and count the answers."""
    if not data.is_dir():
        print(f"skipped: no recordings in {data}; get them from the repository named above", file=sys.stderr)
        raise typer.Exit
    arm = load_arm(data / DESIGN / "arm.toml")
    runs = [replace(load_run(path, arm.n), tau_meas=None) for path in sorted((data / DESIGN).glob("run_*.csv"))]
    plain = look(arm, runs)
    asked = [(law, j, size) for law in LAWS for j in range(arm.n) for size in SIZES]
    changed = (put_in(runs, law, j, size * plain["left"][arm.names[j]]) for law, j, size in asked)
    found = Parallel(n_jobs=jobs)(delayed(look)(arm, new) for new in changed)
    rows = [row(law, arm.names[j], size, one, plain) for (law, j, size), one in zip(asked, found, strict=True)]
    inside = [r for r in rows if r["effect"] not in OUTSIDE]
    seen, outside = [r for r in inside if r["gap_grown"] >= 1.0], [r for r in rows if r not in inside]
    result = {
        "named_right": [sum(r["right"] for r in inside), len(inside)],
        "named_right_where_the_gap_grew_as_much": [sum(r["right"] for r in seen), len(seen)],
        "with_a_wrong_name": [sum(bool(r["wrong"]) for r in inside), len(inside)],
        "nothing_new_named_outside_the_library": [sum(not r["wrong"] for r in outside), len(outside)],
    }
    show(result)
    print(f"written to {write('real_injected', result | {'as_recorded': plain, 'rows': rows}, named=figure(inside))}")


if __name__ == "__main__":
    typer.run(main)
