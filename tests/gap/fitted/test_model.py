"""What a fitted model is, whatever its law."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from stribeck.gap.fitted.model import Model, finite


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -1e200])
@pytest.mark.parametrize("where", ["fitted", "held"])
def test_a_model_that_runs_away_on_any_run_is_not_finite(wrong: float, where: str) -> None:
    """A stand that is shaken off its start may come back to numbers on the runs that are held out."""
    rows = {"fitted": np.zeros((4, 2)), "held": np.zeros((3, 2))}
    fit: Any = SimpleNamespace(residual=rows["fitted"])
    assert finite(Model((), fit, rows["held"]))
    rows[where][1, 1] = wrong
    assert not finite(Model((), fit, rows["held"]))
