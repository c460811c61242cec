"""PEtab Select's criteria on the models that the search has fitted."""

from __future__ import annotations

import numpy as np
from _rival import CONSTANTS, Answer, friction_intervals

from stribeck.arm import Arm
from stribeck.gap.search.step import Step


def by_petab_select(arm: Arm, step: Step, criterion: str) -> Answer:
    """Weigh the model without an effect and its rivals by ``AIC``, ``AICc`` or ``BIC``, and name the best.

    Candidates and fits are those of this package's first step, so that only the choice differs; measurements count
    one by one, as PEtab's noise models have them.
    """
    import petab_select

    models = (step.base, *step.rivals)
    free = [len(model.fit.free) for model in models]
    priors = sum(0.0 < entry.sd < np.inf for entry in step.base.fit.entries)
    rows = step.base.fit.residual.size
    nllh = [_negative_log_likelihood(model.fit.residual) + model.fit.prior for model in models]
    if criterion == "AIC":
        values = [petab_select.criteria.calculate_aic(*pair) for pair in zip(nllh, free, strict=True)]
    else:
        calculate = getattr(petab_select.criteria, f"calculate_{criterion.lower()}")
        values = [calculate(cost, k, rows, priors) for cost, k in zip(nllh, free, strict=True)]
    known = petab_select.constants.Criterion(criterion)
    listed = petab_select.Models(
        [
            petab_select.Model(
                model_id=f"M{k}", model_subspace_id=f"M{k}", model_subspace_indices=[], parameters={},
                model_subspace_petab_yaml=None, criteria={known: value},
            )
            for k, value in enumerate(values)
        ]
    )  # fmt: skip
    weights = petab_select.analyze.compute_weights(listed, known)
    best = int(np.argmax(weights))
    place = models[best].placed[-1] if best else None
    named = ((place.effect.name, arm.names[place.joint]),) if place is not None else ()
    fit = models[best].fit
    rows_of = [(fit.value(f"{joint}.friction.{name}"), None) for joint in arm.names for name in CONSTANTS]
    return Answer(named, float(weights[best]), friction_intervals(arm, rows_of), f"weight {weights[best]:.3g}")


def _negative_log_likelihood(residual: np.ndarray) -> float:
    return float(0.5 * len(residual) * np.sum(np.log(np.mean(residual**2, axis=0)) + np.log(2 * np.pi) + 1.0))
