"""What the search's evidence was in many cases, whether what it took was there, and the weights that follow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, astuple, fields
from typing import Any

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit

from stribeck.arm import Arm
from stribeck.gap.diagnose import searched
from stribeck.gap.records.prepare import prepare
from stribeck.gap.search.presence import Evidence, evidence
from stribeck.gap.search.setting import Asked
from stribeck.run import Run

RIDGE = 2.0  # of the squared weights, in units of each figure's spread
FOLDS = 10


def evidence_of_a_case(arm: Arm, runs: Sequence[Run], leave_out: Sequence[str]) -> dict[str, Any]:
    """Return, as a diagnoser does, the evidence for each effect that the search takes, and its class."""
    steps = searched(prepare(arm, runs), Asked(jobs=1, leave_out=tuple(leave_out))).steps
    rows = []
    for step in steps:
        if step.taken:
            names = {step.rivals[k - 1].placed[-1].effect.name for k in step.ranking.twins()}
            rows.append({"class": sorted(names), **asdict(evidence(step))})
    empty = {"named": [], "verdict": "unexplained", "causes": [], "where": [], "gap": {"closed": None}}
    return {"diagnosis": empty, "evidence": rows}


def judged(truths: Mapping[str, Any], answers: Mapping[str, Any]) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Return the evidence (M, figures), whether the effect was there (M,), and of which case each row is."""
    rows, right, case = [], [], []
    for name, truth in truths.items():
        hidden = {row["effect"] for row in truth["effects"]} - set(truth["leave_out"])
        for row in answers[name]["evidence"]:
            rows.append([row[field.name] for field in fields(Evidence)])
            right.append(bool(hidden & set(row["class"])))
            case.append(name)
    return np.array(rows), np.array(right, dtype=float), case


def regression(figures: np.ndarray, right: np.ndarray) -> tuple[Evidence, Evidence, float]:
    """Return centre, weights and level of a logistic regression with a ridge (le Cessie & van Houwelingen 1992)."""
    centre, spread = figures.mean(axis=0), figures.std(axis=0)
    spread = np.where(spread > 1e-9, spread, 1.0)  # what never varies weighs nothing
    scaled = np.column_stack([np.ones(len(figures)), (figures - centre) / spread])
    sign = 2.0 * right - 1.0

    def cost(w: np.ndarray) -> float:
        return float(np.sum(np.logaddexp(0.0, -sign * (scaled @ w))) + 0.5 * RIDGE * np.sum(w[1:] ** 2))

    w = minimize(cost, np.zeros(scaled.shape[1])).x
    return Evidence(*centre.tolist()), Evidence(*(w[1:] / spread).tolist()), float(w[0])


def chances(figures: np.ndarray, centre: Evidence, weight: Evidence, level: float) -> np.ndarray:
    """Return the probability (M,) of each row."""
    odds = level + (figures - np.array(astuple(centre))) @ np.array(astuple(weight))
    return np.asarray(expit(odds))


def cross_validated(figures: np.ndarray, right: np.ndarray, case: Sequence[str], seed: int = 0) -> np.ndarray:
    """Return each row's probability (M,) by the weights of the other folds' cases."""
    names = sorted(set(case))
    fold = dict(zip(names, np.random.default_rng(seed).integers(0, FOLDS, len(names)), strict=True))
    of_row = np.array([fold[name] for name in case])
    out = np.zeros(len(right))
    for k in range(FOLDS):
        if np.any(of_row == k):
            out[of_row == k] = chances(figures[of_row == k], *regression(figures[of_row != k], right[of_row != k]))
    return out


def log_loss(chance: np.ndarray, right: np.ndarray) -> float:
    """Return the mean of -log(probability of what was)."""
    p = np.clip(chance, 1e-3, 1.0 - 1e-3)
    return float(-np.mean(right * np.log(p) + (1.0 - right) * np.log(1.0 - p)))
