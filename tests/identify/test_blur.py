"""What the motion's filter leaves in a residual lies around reversals, and is found as large as it is."""

from __future__ import annotations

import numpy as np
import pytest

from stribeck.identify.blur import blur
from stribeck.identify.conditioning import condition
from stribeck.identify.residual import Residual
from stribeck.model.layout import values_of
from stribeck.simulate import path_of

from .bench import joint
from .test_run_fit import CUTOFF, swung


def test_blur_is_what_a_perfect_model_leaves_and_lies_around_reversals() -> None:
    run = condition(joint(), swung(0.005)[2], CUTOFF, np.full(1, 1e-6), thin=True)
    path = path_of(joint())
    p = values_of(path.entries)
    residual = Residual(path, [run], ())
    found, left = blur(residual, p, CUTOFF)[:, 0], residual.value(p)[:, 0]
    assert np.sqrt(np.mean(left**2) / np.mean(found**2)) == pytest.approx(1.0, rel=0.15)
    fast = np.abs(run.velocity[run.analysis_index, 0]) > 0.5 * np.abs(run.velocity).max()
    assert np.std(found[fast]) < 0.3 * np.std(found[~fast])
