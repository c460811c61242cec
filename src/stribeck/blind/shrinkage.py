"""How far the gap truly shrinks: both models of an answer on motions that the diagnoser never saw."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from joblib import Parallel, delayed

from stribeck.arm import Arm, load_arm
from stribeck.blind.key import Opened
from stribeck.effects.placing import stated_effects
from stribeck.gap.records.floor import noise_floor
from stribeck.grid import uniform
from stribeck.identify.conditioning import Conditioned, condition
from stribeck.identify.residual import Residual
from stribeck.model.layout import values_of
from stribeck.model.path import SignalPath
from stribeck.run import Run
from stribeck.withheld.fresh import fresh_runs

LEAST = 2.0  # squared residual over squared floor, less one, summed over joints: below, next to nothing is to be closed

Progress = Callable[[str], None]


def true_shrinkage(opened: Opened, jobs: int = 2, progress: Progress = lambda text: None) -> dict[str, dict[str, Any]]:
    """Return by case the part of the closable gap that an answer claims to close, and the part that it does close.

    Only answers that name something have one, and only cases of drawn motions, of which new ones can be drawn. The
    plant of the key records them; re-tuned and corrected arm of the answer are then judged as in a diagnosis.

    Parameters
    ----------
    opened : Opened
        Answers and truths.
    jobs : int
        Processes.
    progress : callable
        Told in words what is being done.
    """
    cases = [name for name, answer in opened.answers.items() if _claims(answer) and _drawn(opened.truths[name])]
    work = (delayed(_shrunk)(opened.truths[name], opened.answers[name]) for name in cases)
    found: dict[str, dict[str, Any]] = {}
    for name, row in zip(cases, Parallel(n_jobs=jobs, return_as="generator")(work), strict=True):
        found[name] = row
        progress(f"{len(found)} of {len(cases)} corrected models judged on new motions")
    return found


def _claims(answer: Mapping[str, Any]) -> bool:
    return "error" not in answer and answer["diagnosis"]["gap"]["closed"] is not None


def _drawn(truth: Mapping[str, Any]) -> bool:
    """Whether the case's motions are of a kind of which others can be drawn."""
    return bool(truth.get("laboratory", {}).get("kinds"))


def _shrunk(truth: Mapping[str, Any], answer: Mapping[str, Any]) -> dict[str, Any]:
    found = answer["diagnosis"]
    claimed = found["gap"]["closed"]["value"]
    try:
        runs = fresh_runs(truth, _arm(truth["arm_true"]), _arm(truth["arm_nominal"]))
        band = (float(found["settings"].get(name, math.inf)) for name in ("cutoff_hz", "corner_hz"))
        true = closed_on(runs, _arm(answer["retuned"]), _arm(answer["corrected"]), *band)
    except Exception as error:  # of one model among many: said in its row, not the end of the score
        return {"claimed": claimed, "true": None, "not_judged": f"{type(error).__name__}: {error}"}
    return {"claimed": claimed, "true": None if true is None else float(f"{true:.4g}")}


def closed_on(
    runs: Sequence[Run], retuned: Arm, corrected: Arm, cutoff: float, corner: float = math.inf
) -> float | None:
    """Return 1 - (rms_corrected^2 - floor^2) / (rms_retuned^2 - floor^2) of the torque gap along runs.

    Joints count in units of their noise floor, as in ``diagnosis.json``; None where the re-tuned arm is at the floor.

    Parameters
    ----------
    runs : sequence of Run
    retuned, corrected : Arm
        Before and after the named effects.
    cutoff, corner : float
        Of the band by which the diagnosis compared models, Hz.
    """
    even = [condition(retuned, uniform(run)[0], cutoff, thin=True).rolled_off(corner) for run in runs]
    floor = np.minimum(*(_noise(arm, even, cutoff) for arm in (retuned, corrected)))
    before, after = (float(np.sum(_mean_square(arm, even) / floor - 1.0)) for arm in (retuned, corrected))
    return 1.0 - max(after, 0.0) / before if before > LEAST else None


def _noise(arm: Arm, runs: Sequence[Conditioned], cutoff: float) -> np.ndarray:
    path = SignalPath(arm, stated_effects(arm))
    return np.asarray(np.mean(noise_floor(arm, path, values_of(path.entries), runs, cutoff, 0) ** 2, axis=0))


def _mean_square(arm: Arm, runs: Sequence[Conditioned]) -> np.ndarray:
    path = SignalPath(arm, stated_effects(arm))
    residual, _ = Residual(path, runs, ())(values_of(path.entries))
    return np.asarray(np.mean(residual**2, axis=0))


def _arm(text: str) -> Arm:
    with tempfile.TemporaryDirectory(prefix="stribeck-") as folder:
        path = Path(folder) / "arm.toml"
        path.write_text(text, encoding="utf-8")
        return load_arm(path)
