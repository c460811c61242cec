"""Question: how sure may the diagnosis be of an effect that its search has taken? Weights of evidence, from cases.

Method: cases of the independent plant, sealed as in `blind_effects.py`, are searched. For each effect that a search
takes, the evidence (`stribeck.gap.search.presence`) is held against whether it, or one of its class, was hidden there,
and a logistic regression weighs it. Stated beside the shipped weights: those of these cases, and how well both
foretell, the former in tenfold cross-validation over cases. What the records show by themselves (encoder steps, a late
velocity) is left out. Probabilities hold for the mixture asked for here: one effect in three of five cases.
Expected: both weights foretell alike, within what cross-validation costs. Source: Cox (1958), logistic regression.
"""

from __future__ import annotations

import shutil
from dataclasses import asdict

import numpy as np
import typer
from _output import OUT, write
from _presence import chances, cross_validated, evidence_of_a_case, judged, log_loss, regression
from _presence_figure import presence_figure

from stribeck.blind.batch import diagnose_cases
from stribeck.blind.farm import Processes
from stribeck.blind.key import open_sealed
from stribeck.effects.registry import registry
from stribeck.gap.answer.verdict import NAMED_OVER
from stribeck.gap.search.presence import CENTRE, LEVEL, WEIGHT
from stribeck.withheld import KNOWN
from stribeck.withheld.plan import Order
from stribeck.withheld.seal import record_sealed


def main(
    single: int = 190,
    pairs: int = 24,
    none: int = 30,
    unknown: int = 40,
    left_out: int = 30,
    seed: int = 4000,
    jobs: int = 2,
    fresh: bool = False,
) -> None:
    """Record, search, weigh."""
    work = OUT / "presence" / "work"
    if fresh:
        shutil.rmtree(work, ignore_errors=True)
    hidden = tuple(name for name in KNOWN if not registry()[name].direct)
    order = Order(single, pairs, none, unknown, left_out, hidden)
    if not (work / "key.json").exists():
        print("digest", record_sealed(order, work / "cases", work / "key.json", seed=seed, jobs=jobs, progress=print))
    diagnose_cases(work / "cases", work / "fits", farm=Processes(jobs), diagnoser=evidence_of_a_case, progress=print)
    opened = open_sealed(work / "fits", work / "key.json")
    figures, right, case = judged(opened.truths, opened.answers)
    centre, weight, level = regression(figures, right)
    shipped, crossed = chances(figures, CENTRE, WEIGHT, LEVEL), cross_validated(figures, right, case)
    result = {
        "effects_taken": len(right),
        "of_them_there": int(right.sum()),
        "weights": {"centre": asdict(centre), "weight": asdict(weight), "level": level},
        "named": {
            key: {"all": int(np.sum(p > NAMED_OVER)), "there": int(np.sum(right[p > NAMED_OVER]))}
            for key, p in (("shipped", shipped), ("cross_validated", crossed))
        },
        "log_loss": {"shipped": log_loss(shipped, right), "cross_validated": log_loss(crossed, right)},
    }
    for key, value in result.items():
        print(f"{key}: {value}")
    print(f"written to {write('presence', result, reliability=presence_figure(shipped, crossed, right))}")


if __name__ == "__main__":
    typer.run(main)
