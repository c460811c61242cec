"""What a planned run tells of two models, where one of them runs away on it or has nothing that is fitted."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from stribeck.arm import Tolerance
from stribeck.gap.experiment.separation import Candidate
from stribeck.identify.problem import Weights
from stribeck.identify.residual import Residual
from stribeck.model.layout import values_of
from stribeck.model.path import SignalPath

from ..conftest import NOMINAL, conditioned


@pytest.mark.parametrize("far", [1e300, np.inf, np.nan])
def test_a_law_that_runs_away_is_far_off_by_a_number(far: float) -> None:
    residual, jacobian = np.full((4, 1), far), np.full((4, 1, 2), -far)
    one = object.__new__(Candidate)
    one.p, one.correlation, one.unit = np.zeros(2), np.ones(1), np.ones(2)
    one.residual = SimpleNamespace(along=lambda runs: lambda p: (residual, jacobian))  # type: ignore[assignment]
    (left,), (columns,) = one.misfit([SimpleNamespace(analysis_index=np.arange(4))], [np.ones((4, 1))])  # type: ignore[list-item]
    assert left @ left > 1e100
    assert np.all(np.isfinite(columns.T @ columns))
    assert np.all(np.isfinite(columns.T @ left))


def test_a_model_of_which_nothing_is_fitted_is_off_by_all_that_it_leaves() -> None:
    """An arm whose values are all held, and no effect: nothing of a misfit is re-tuned away."""
    arm = replace(NOMINAL, tolerance=Tolerance(0.0, 0.0))
    run = conditioned([3.0])[0]
    path = SignalPath(arm)
    fit = SimpleNamespace(p=values_of(path.entries), entries=path.entries, free=np.array([], dtype=int))
    fit.residual, fit.jacobian = Residual(path, [run])(fit.p)
    weights = Weights(np.array([0.5]), np.array([4.0]))
    one = Candidate(arm, SimpleNamespace(fit=fit, placed=()), weights)  # type: ignore[arg-type]
    assert one.known.shape == (0, 0)
    noise = np.where(np.arange(len(fit.residual)) < 9, 0.5, 2.0)[:, None]  # of each row
    assert one.excess(run, noise) == pytest.approx(np.sqrt(np.sum((fit.residual / (2.0 * noise)) ** 2)))
