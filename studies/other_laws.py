"""Question: is an effect named whose law is not the library's own? No real arm's is.

Method: to the commanded torque of recordings of the independent plant without an effect is added, by formula, what an
effect would have asked for along the recorded motion: textbook forms of the library's effects, most of them not the
library's own, a tenth of the joint's torque, in a vertical arm with one joint and a horizontal one with two. The motion
is the one that was recorded, so that a drive that had to overcome the effect would have got this command.
Expected: named where the library's law can follow most of it, else "unexplained"; another name hardly ever.
Source: forms of friction in Armstrong-Helouvry, Dupont & Canudas de Wit (1994).
"""

from __future__ import annotations

from collections import Counter
from typing import Any

import typer
from _other_laws import LAWS, put_in
from _output import write
from joblib import Parallel, delayed
from rich import print as show

from stribeck.gap import diagnose
from stribeck.withheld.cases import make_case

ARMS = ((301, 1, True), (302, 2, False))  # seed, joints, whether gravity acts
SHARE = 0.1  # of the joint's torque, both rms


def look(law: str, seed: int, joints: int, upright: bool) -> dict[str, Any]:
    """Put a law into the first joint; return what is named, and what is left over the noise floor before and after."""
    case, effect = make_case(seed, None, n_joints=joints, vertical=upright), LAWS[law][0]
    found = diagnose(case.arm_nominal, put_in(case.arm_true, case.runs, 0, law, SHARE), jobs=1)
    causes = {c.effect: (c.presence or 0.0, {c.effect, *c.equivalent}) for c in found.causes if c.joints}
    left = {stage.stage: stage.torque[case.arm_true.names[0]] for stage in found.stages}
    return {
        "law": law, "effect": effect, "seed": seed, "verdict": found.verdict, "named": list(found.named),
        "right": any(effect in causes[name][1] for name in found.named),
        "wrong": [name for name in found.named if effect not in causes[name][1]],
        "presence": max((p for p, names in causes.values() if effect in names), default=0.0),
        "retuned": left["retuned"] / left["noise_floor"],
        "corrected": found.stages[-2].torque[case.arm_true.names[0]] / left["noise_floor"],
    }  # fmt: skip


def main(jobs: int = 2, law: list[str] | None = None) -> None:
    """Put every law in and count the answers; ``--law`` picks some."""
    work = [delayed(look)(name, *arm) for name in (law or LAWS) for arm in ARMS]
    rows = Parallel(n_jobs=jobs)(work)
    said = Counter("wrong" if r["wrong"] else "right" if r["right"] else r["verdict"] for r in rows)
    show(
        dict(said), [(r["law"], r["seed"], r["named"], round(r["retuned"], 1), round(r["corrected"], 1)) for r in rows]
    )
    print(f"written to {write('other_laws', {'said': dict(said), 'share': SHARE, 'rows': rows})}")


if __name__ == "__main__":
    typer.run(main)
