"""PySINDy on a case: a sparse sum of candidate terms for the torque that the re-tuned model leaves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from _rival import Answer

from stribeck.arm import Arm
from stribeck.gap.fitted.model import Model
from stribeck.gap.records.prepare import Prepared
from stribeck.identify.conditioning import Conditioned

HARMONICS = range(1, 13)
MODELS = 20  # of the ensemble
THRESHOLDS = (0.1, 0.2, 0.4, 0.8)  # the first is the default
WORTH = 0.95  # of the held-out squares
MOST_LIKELY = 0.5  # share of the ensemble from which a term counts
TERM = {
    "1": "torque_offset", "u": "torque_gain", "sign u": "torque_dead_zone", "du/dt": "delay",
    "|v|": "asymmetric_friction", "v|v|": "quadratic_damping", "sign v exp(-|v|/s)": "negative_damping",
    "|u| sign v": "load_dependent_friction", "t sign v": "history", "q": "cable_spring",
    "sin Q": "gravity_tilt", "cos Q": "gravity_tilt",
}  # fmt: skip
WAVES = {"": "cogging", " sign v": "position_dependent_friction", " u": "torque_ripple"}


def by_sindy(arm: Arm, prepared: Prepared, base: Model) -> Answer:
    """Regress each joint's residual on terms of its own motion and command, and name the effects of what is left.

    The user is taken to know what this package knows: the filtered torque along the recorded motion after re-tuning,
    and a term for every effect that is a static law of one joint. Effects with a memory (compliance, play, presliding,
    dwell) have none. Terms and residual are scaled to an rms of 1. Ensembled STLSQ with the default ridge; of some
    thresholds that is taken whose model has the least error on the held-out runs, and no model where none has less
    than WORTH of the squares without.
    """
    named: list[tuple[float, str, str, float]] = []
    terms = 0
    for j, joint in enumerate(arm.names):
        columns, shares = _sparse(prepared, base, j)
        terms += len(columns)
        named += [(worth, _effect(term), joint, shares[term]) for term, worth in columns.items()]
    named.sort(reverse=True)
    places = tuple(dict.fromkeys((effect, joint) for _, effect, joint, _ in named))
    return Answer(places, named[0][3] if named else None, (), f"{terms} terms")


def _sparse(prepared: Prepared, base: Model, j: int) -> tuple[dict[str, float], dict[str, float]]:
    """Return the terms of a joint's model, with their torque over the joint's and their share of the ensemble."""
    import pysindy

    fitted, judged = terms_of(prepared.fit, j), terms_of(prepared.held, j)
    names = list(fitted)
    features, other = (np.column_stack(list(terms.values())) for terms in (fitted, judged))
    size = np.maximum(np.sqrt(np.mean(features**2, axis=0)), 1e-12)
    rms = max(float(np.sqrt(np.mean(base.fit.residual[:, j] ** 2))), 1e-12)
    least, best = WORTH * float(np.sum((base.held[:, j] / rms) ** 2)), (np.zeros(len(names)), np.zeros(len(names)))
    for threshold in THRESHOLDS:
        optimizer = pysindy.EnsembleOptimizer(pysindy.STLSQ(threshold=threshold), bagging=True, n_models=MODELS)
        np.random.seed(0)  # noqa: NPY002 - the ensemble draws from numpy's own generator
        optimizer.fit(features / size, (base.fit.residual[:, j] / rms)[:, None])
        drawn = np.array(optimizer.coef_list).reshape(MODELS, -1)
        share = np.mean(drawn != 0.0, axis=0)
        amount = np.where(share > MOST_LIKELY, np.median(drawn, axis=0), 0.0)
        left = float(np.sum((base.held[:, j] / rms - other / size @ amount) ** 2))
        if left < least:
            least, best = left, (amount, share)
    kept = [k for k in range(len(names)) if best[0][k] != 0.0]
    worth = {names[k]: float(abs(best[0][k])) * rms / prepared.scales[j].torque for k in kept}
    return worth, {names[k]: float(best[1][k]) for k in kept}


def _effect(term: str) -> str:
    if term in TERM:
        return TERM[term]
    return WAVES[term.partition("q")[2]]


def terms_of(runs: Sequence[Conditioned], j: int) -> Mapping[str, np.ndarray]:
    """Return the candidate terms of a joint, each (M,) at the runs' analysis samples, low-passed as the residual is."""
    parts = [_terms(run, j) for run in runs]
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _terms(run: Conditioned, j: int) -> dict[str, np.ndarray]:
    q, v, u = run.position[:, j], run.velocity[:, j], run.command[:, j]
    turn = np.where(run.stuck[:, j] > 0.5, 0.0, np.sign(v))
    absolute = run.position[:, : j + 1].sum(axis=1)
    slow = 0.2 * np.sqrt(np.mean(v**2)) + 1e-9
    terms = {
        "1": np.ones_like(q), "u": u, "sign u": np.sign(u), "du/dt": np.gradient(u, run.sample_time),
        "|v|": np.abs(v), "v|v|": v * np.abs(v), "sign v exp(-|v|/s)": turn * np.exp(-np.abs(v) / slow),
        "|u| sign v": np.abs(u) * turn, "t sign v": (run.time - run.time[0]) * turn, "q": q,
        "sin Q": np.sin(absolute), "cos Q": np.cos(absolute),
    }  # fmt: skip
    for n in HARMONICS:
        for wave, values in (("sin", np.sin(n * q)), ("cos", np.cos(n * q))):
            for kind, factor in (("", 1.0), (" sign v", turn), (" u", u)):
                terms[f"{wave} {n} q{kind}"] = values * factor
    return {name: run.filtered(values) for name, values in terms.items()}
