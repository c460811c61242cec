"""What rules of decision look at: one search a case, the first step's models along torque and along motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from stribeck.arm import Arm
from stribeck.gap.answer.verdict import NAMED_OVER, causes_of
from stribeck.gap.diagnose import searched
from stribeck.gap.fitted.corrected import arm_of
from stribeck.gap.fitted.model import Model, weights_of
from stribeck.gap.records.blocks import block_of_rows, block_sums, correlation_rows
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.gap.search.candidates import candidates
from stribeck.gap.search.setting import Asked
from stribeck.gap.search.step import Step
from stribeck.identify.conditioning import Conditioned, condition
from stribeck.run import Run
from stribeck.simulate.engine import Engine, path_of
from stribeck.simulate.predict import predict_conditioned

HORIZON = 0.5  # s


def fits_of_a_case(arm: Arm, runs: Sequence[Run], leave_out: Sequence[str]) -> dict[str, Any]:
    """Return, as a diagnoser does, what the shipped rule names, and beside it what other rules need (``fits``)."""
    prepared = prepare(arm, runs)
    steps = searched(prepared, Asked(jobs=1, leave_out=tuple(leave_out))).steps
    floor = steps[-1].floor
    causes, _ = causes_of(steps, arm.names, prepared.scales)
    named = [cause for cause in causes if (cause.presence or 0.0) > NAMED_OVER]
    said = diagnosis_of([(cause.effect, cause.joints[0], cause.equivalent) for cause in named])
    return {"diagnosis": said, "fits": _fits(prepared, floor, steps[0], leave_out)}


def diagnosis_of(named: Sequence[tuple[str, str, Sequence[str]]]) -> dict[str, Any]:
    """Return names (effect, joint, class) in the form of a diagnosis, as far as a score looks at names."""
    causes = [
        {"effect": effect, "joints": [joint], "equivalent": list(group), "parameters": {}, "probability": None}
        for effect, joint, group in named
    ]
    verdict = "explained" if named else "unexplained"
    names = [effect for effect, _, _ in named]
    return {"named": names, "verdict": verdict, "causes": causes, "where": [], "gap": {"closed": None}}


def _fits(prepared: Prepared, floor: np.ndarray, step: Step, leave_out: Sequence[str]) -> dict[str, Any]:
    models, base = (step.base, *step.rivals), len(step.base.placed)
    torque = [np.concatenate([model.fit.residual, model.held]) for model in models]
    motion = [_motion(prepared, model, [*prepared.fit, *prepared.held]) for model in models]
    split = len(step.base.fit.residual)
    return {
        "rivals": [[m.placed[-1].effect.name, prepared.arm.names[m.placed[-1].joint]] for m in step.rivals],
        "own": [sum(entry.owner == base for entry in model.fit.entries) for model in models],
        "tuned": len(step.base.fit.free),
        "prior": [model.fit.prior for model in models],
        "candidates": len(candidates(prepared.arm, step.base.placed, leave_out)),
        "twins": [replace(step.ranking, best=k).twins() for k in range(1, len(models))],
        "score": [_score(prepared, floor, step.base, rival) for rival in step.rivals],
        "fit": _sums([r[:split] for r in torque], [r[:split] for r in motion], prepared.fit),
        "held": _sums([r[split:] for r in torque], [r[split:] for r in motion], prepared.held),
    }


def _sums(torque: Sequence[np.ndarray], motion: Sequence[np.ndarray], runs: Sequence[Conditioned]) -> dict[str, Any]:
    """Return squares summed over blocks (K, B, n) by domain, rows a block (B,), and rows that count as one (K, n)."""
    block = block_of_rows(runs)
    out: dict[str, Any] = {"rows": np.bincount(block).tolist()}
    for name, residuals in (("torque", torque), ("motion", motion)):
        out[name] = [_short(block_sums(residual**2, block)) for residual in residuals]
        out[f"{name}_correlation"] = [_short(correlation_rows(residual, runs)) for residual in residuals]
    return out


def _short(values: np.ndarray) -> Any:
    return np.vectorize(lambda v: float(f"{v:.6g}"))(values).tolist()


def _motion(prepared: Prepared, model: Model, runs: Sequence[Conditioned]) -> np.ndarray:
    """Return the position error (M, n), rad, of simulating on from the recorded state every HORIZON."""
    arm = arm_of(prepared.arm, model.fit, model.placed)
    engine = Engine(path_of(arm))
    parts = []
    for thinned in runs:
        run = condition(arm, thinned.run, prepared.cutoff, thinned.noise)
        error = predict_conditioned(engine, engine.p, run, HORIZON).q - run.position
        parts.append(error[np.searchsorted(run.time, thinned.time[thinned.analysis_index] - 1e-9)])
    return np.nan_to_num(np.concatenate(parts), nan=np.pi, posinf=np.pi, neginf=-np.pi)


def _score(prepared: Prepared, floor: np.ndarray, base: Model, rival: Model) -> list[float]:
    """Return statistic and degrees of freedom of the score test of a rival's own parameters, robust to colour.

    The scores of whole blocks are the units (Newey & West 1987 with blocks for lags); what the re-tuned parameters
    could do, priors included, is projected out. Derivatives are those at the rival's fit: a law's velocity or period
    has none where its amount is nothing (Davies 1977).
    """
    scale = weights_of(base, prepared, floor).scale
    rows = base.fit.residual.size
    sd = np.array([base.fit.entries[i].sd for i in base.fit.free])
    known = np.isfinite(sd)
    tuned = ((base.fit.jacobian * scale[..., None]) * np.where(known, sd, 1.0)).reshape(rows, -1)
    mine = [c for c, i in enumerate(rival.fit.free) if rival.fit.entries[i].owner == len(base.placed)]
    own = (rival.fit.jacobian[:, :, mine] * scale[..., None]).reshape(rows, -1)
    gram = tuned.T @ tuned + np.diag(np.where(known, 1.0, 1e-6))
    own = own - tuned @ np.linalg.solve(gram, tuned.T @ own)
    own /= np.maximum(np.linalg.norm(own, axis=0), 1e-300)
    residual = (base.fit.residual * scale).ravel()
    block = np.repeat(block_of_rows(prepared.fit), base.fit.residual.shape[1])
    return score_test(own, residual, block)


def score_test(own: np.ndarray, residual: np.ndarray, block: np.ndarray) -> list[float]:
    """Return the statistic of the scores own' residual whose blocks are independent, and its degrees of freedom.

    Parameters
    ----------
    own : array (M, k)
        Derivatives by the parameters in question, what else is fitted projected out.
    residual : array (M,)
    block : array (M,)
        Block number of each row.
    """
    blocks = block_sums(own * residual[:, None], block)
    total, apart = blocks.sum(axis=0), blocks - blocks.mean(axis=0)  # about the mean: what is there is no noise
    spread = apart.T @ apart * len(blocks) / max(len(blocks) - 1, 1)
    inverse = np.linalg.pinv(spread, rcond=1e-8)
    return [float(total @ inverse @ total), int(np.linalg.matrix_rank(spread, tol=1e-8 * np.trace(spread)))]
