"""Question: which hidden effects does the diagnosis name, how often wrongly, and are its probabilities right? A table.

Method: the withheld check in one go. `stribeck.withheld` records cases of random arms, laboratories and motions, an
effect hidden in each (or two, or none, or one outside the library); its digest is shown; `stribeck.blind` diagnoses
arm file and recordings alone, opens the key and scores. Interrupted, the same call goes on; for the record, run
``stribeck withheld record | diagnose | score`` apart, and freeze the method between the first and the second.
Expected: named in 90 % at strengths of 3 and more and in 75 % between 1 and 3, wrong names in 3 %, false alarms in
3 %, silence on 90 % of what is outside the library, calibration error 0.05, intervals that hold in 92 to 98 %: the
project's own acceptance figures. Source: the score's table of what is asked; half a minute to two a case and core.
"""

from __future__ import annotations

import shutil

import typer
from _output import OUT, write

from stribeck.blind.batch import diagnose_cases
from stribeck.blind.farm import Processes
from stribeck.blind.key import open_sealed
from stribeck.blind.score import score
from stribeck.blind.shrinkage import true_shrinkage
from stribeck.report.withheld import write_score_report
from stribeck.withheld import KNOWN
from stribeck.withheld.plan import LEVELS, Order
from stribeck.withheld.seal import record_sealed

KINDS = ("single", "none", "outside", "pairs", "effects", "calibration", "intervals", "shrinkage", "targets", "time")


def main(
    cases: int = 60,
    none: int = 12,
    unknown: int = 12,
    pairs: int = 6,
    left_out: int = 12,
    effects: str = "",
    levels: str = ",".join(LEVELS),
    seed: int = 1000,
    jobs: int = 2,
    fresh: bool = False,
) -> None:
    """Record, diagnose and score; ``--effects a,b`` draws from these, ``--fresh`` begins anew."""
    work = OUT / "blind_effects" / "work"
    if fresh:
        shutil.rmtree(work, ignore_errors=True)
    names = tuple(effects.split(",")) if effects else tuple(KNOWN)
    order = Order(cases, pairs, none, unknown, left_out, names, tuple(levels.split(",")))
    if not (work / "key.json").exists():
        print("digest", record_sealed(order, work / "cases", work / "key.json", seed=seed, jobs=jobs, progress=print))
    diagnose_cases(work / "cases", work / "answers", farm=Processes(jobs), progress=print)
    opened = open_sealed(work / "answers", work / "key.json")
    found = score(opened, true_shrinkage(opened, jobs, print))
    folder = write("blind_effects", {"cases": found["cases"], **{kind: found[kind] for kind in KINDS}})
    write_score_report(found, folder)
    for line in found["targets"]:
        print(f"{line['what']}: {line['have']}")
    print(f"written to {folder}")


if __name__ == "__main__":
    typer.run(main)
