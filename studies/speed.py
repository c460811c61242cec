"""Question: is it quick enough to use without thinking? Residual, re-tuning and a whole diagnosis, timed.

Method: the example recording (two links, 500 Hz, six runs of 10 s). Residual and exact Jacobian of one run at every
sample, nominal and with bristles, whose states follow each other; one re-tuning on the runs that a diagnosis fits; a
diagnosis with its peak memory, children included. Against what one would write instead: `scipy.optimize.least_squares`
with finite differences on a NumPy inverse dynamics, same data, parameters, prior, bounds and weights, calls in turn.
Expected: under 20 ms, 2 s, 60 s and 1 GB on 2 idle cores; re-tuning in less time than least squares. Costs are no
ranking: by hand, friction at rest is zero.
Source: the project's own acceptance figures.
"""

from __future__ import annotations

import os

os.environ["OMP_NUM_THREADS"] = "1"  # read when numpy is first imported

import time
from dataclasses import replace
from importlib.resources import files

import numpy as np
import typer
from _measure import against, fastest, in_turn, peak_memory
from _output import write
from _rivals import least_squares_by_hand
from rich import print as show

from stribeck.arm import load_arm
from stribeck.effects.registry import effect_named
from stribeck.gap import diagnose
from stribeck.gap.fitted.model import fit_model, weights_from
from stribeck.gap.records.prepare import prepare
from stribeck.identify.conditioning import condition
from stribeck.identify.residual import Residual
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath
from stribeck.run import load_run

LIMITS = {"jacobian_ms": 20.0, "bristles_ms": 20.0, "retune_s": 2.0, "diagnosis_s": 60.0, "peak_mb": 1000.0}


def main(cases: int = 20, jobs: int = 2, whole: bool = True) -> None:
    """Time all; ``--cases N`` repeats the residual N times, ``--no-whole`` leaves the diagnosis out."""
    folder = files("stribeck") / "example"
    arm = load_arm(folder / "arm.toml")
    runs = [load_run(folder / f"run_{k:02d}.csv", arm.n) for k in range(6)]
    prepared, path = prepare(arm, runs), SignalPath(arm)
    soft = Placed(effect_named("presliding", "maxwell_slip"), 0, {"stiffness": 200.0, "damping": 1.0})
    bristles = SignalPath(arm, [replace(soft, joint=j) for j in range(arm.n)])
    p, q, one = values_of(path.entries), values_of(bristles.entries), [condition(arm, runs[0], prepared.cutoff)]
    residual, value, moving = Residual(path, one), Residual(path, one, ()), Residual(bristles, one)
    residual(p), value(p), moving(q)  # compiles
    weights = weights_from(Residual(path, prepared.fit, ())(p)[0], prepared, np.full(arm.n, 1e-9))
    fitted = fit_model(prepared, (), weights).fit
    by_hand = least_squares_by_hand(arm, prepared.fit, weights, fitted)
    ours, theirs = in_turn(
        lambda: fit_model(prepared, (), weights), lambda: least_squares_by_hand(arm, prepared.fit, weights, fitted), 7
    )
    result = {
        "samples": len(one[0].time),
        "residual_ms": 1e3 * fastest(lambda: value(p), cases),
        "jacobian_ms": 1e3 * fastest(lambda: residual(p), cases),
        "bristles_ms": 1e3 * fastest(lambda: moving(q), cases),
        "retune_s": ours,
        "by_hand_s": theirs,
        "retune_over_by_hand": ours / theirs,
        "cost": {"retune": fitted.misfit + fitted.prior, "by_hand": float(by_hand.cost)},
    }
    if whole:
        started = time.perf_counter()
        with peak_memory() as peak:
            found = diagnose(arm, runs, jobs=jobs)
        result |= {"diagnosis_s": time.perf_counter() - started, "peak_mb": peak.megabytes, "named": found.named}
    show(result)
    print(f"written to {write('speed', result, against_limits=against(result, LIMITS))}")


if __name__ == "__main__":
    typer.run(main)
