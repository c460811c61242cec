"""What a planned run tells of two models, where one of them runs away on it."""

from types import SimpleNamespace

import numpy as np
import pytest

from stribeck.gap.experiment.separation import Candidate


@pytest.mark.parametrize("far", [1e300, np.inf, np.nan])
def test_a_law_that_runs_away_is_far_off_by_a_number(far: float) -> None:
    residual, jacobian = np.full((4, 1), far), np.full((4, 1, 2), -far)
    one = object.__new__(Candidate)
    one.p, one.scale, one.unit = np.zeros(2), np.ones(1), np.ones(2)
    one.residual = SimpleNamespace(along=lambda runs: lambda p: (residual, jacobian))  # type: ignore[assignment]
    (left,), (columns,) = one.misfit([SimpleNamespace(analysis_index=np.arange(4))])  # type: ignore[list-item]
    assert left @ left > 1e100
    assert np.all(np.isfinite(columns.T @ columns))
    assert np.all(np.isfinite(columns.T @ left))
