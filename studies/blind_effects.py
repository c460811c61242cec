"""Question: which of thirteen effects does the diagnosis name, each hidden alone in random arms? All but three of 39.

Method: `stribeck.withheld.cases` draws an arm (horizontal or vertical, 100-1000 Hz), a wrong data sheet and a
laboratory for every case and hides one effect at a clear severity; `diagnose` sees arm file and recordings only.
``--none`` adds cases without an effect, ``--unknown`` cases with effects that the library does not hold.
Expected: at least 36 of 39 named right (the true effect, or listed as equivalent to one that is named), few names
beside it, 95 % intervals that hold the true value in about 19 of 20; nothing named where nothing, or nothing
known, is hidden. Source: the project's own acceptance figures; about a minute a case and core.
"""

from __future__ import annotations

from itertools import cycle, islice

import typer
from _output import write
from _scoring import is_right, matrix, run_case
from joblib import Parallel, delayed
from rich.console import Console
from rich.table import Table

from stribeck.withheld import UNKNOWN

EFFECTS = (
    "asymmetric_friction", "presliding", "load_dependent_friction", "position_dependent_friction", "actuator_lag",
    "delay", "torque_gain", "joint_flexibility", "backlash", "encoder_eccentricity", "payload", "gravity_tilt",
    "cable_spring",
)  # fmt: skip


def main(arms: int = 3, none: int = 0, unknown: int = 0, seed: int = 1000, cases: int = 0, jobs: int = 2) -> None:
    """Record, diagnose and score; ``--cases N`` stops after the first N."""
    wanted = [(effect, effect, True) for effect in EFFECTS for _ in range(arms)]
    wanted += [("no effect", None, True)] * none
    wanted += [(effect, effect, False) for effect in islice(cycle(UNKNOWN), unknown)]
    work = [(label, effect, seed + k, known) for k, (label, effect, known) in enumerate(wanted)][: cases or None]
    rows = Parallel(n_jobs=jobs, verbose=5)(delayed(run_case)(*item) for item in work)

    table = Table("effect", "seed", "outcome", "named", "joint", "true value in its interval", "verdict", "closed")
    for row in rows:
        inside = ", ".join(f"{p['name']} {'yes' if p['inside'] else 'no'}" for p in row["parameters"])
        closed = "" if row.get("closed") is None else f"{row['closed']:.0%}"
        joint = {True: "right", False: "wrong"}.get(row.get("joint_right"), "")
        named = row.get("error") or ", ".join(row["named"]) or "nothing"
        table.add_row(row["label"], str(row["seed"]), row["outcome"], named, joint, inside, row.get("verdict"), closed)
    intervals = [p["inside"] for row in rows for p in row["parameters"]]
    total = {
        "cases": len(rows),
        "right": sum(map(is_right, rows)),
        "joints_right": sum(row.get("joint_right") is True for row in rows),
        "extra_names": sum(len(row["extra"]) for row in rows),
        "intervals": len(intervals),
        "intervals_that_hold": sum(intervals),
    }
    Console().print(table, total)
    folder = write("blind_effects", {"seed": seed, **total, "rows": rows}, matrix=matrix(rows))
    print(f"written to {folder}")


if __name__ == "__main__":
    typer.run(main)
