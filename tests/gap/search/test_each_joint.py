"""Drives that lag alike: one lateness of all joints is taken first, a lag of each belongs to its class."""

import numpy as np
import pytest
from joblib import Parallel

from stribeck.effects.registry import effect_named
from stribeck.gap.fitted.model import fit_model, retune, weights_of
from stribeck.gap.records.prepare import prepare
from stribeck.gap.search.each_joint import with_lags
from stribeck.gap.search.rank import rank
from stribeck.gap.search.step import Step
from stribeck.model.layout import Placed
from stribeck.withheld.example import nominal_arm, true_arm
from stribeck.withheld.excitation import programme
from stribeck.withheld.injections import Injection
from stribeck.withheld.recorder import default_gains, record

FLOOR = np.array([0.05, 0.02])
LATE = effect_named("time_shift", "all_joints")


@pytest.mark.parametrize(
    ("hidden", "values", "classed"),
    [("actuator_lag", {"time_constant": 0.015}, True), ("delay", {"time": 0.02}, False)],
)
def test_a_lag_of_each_joint_is_named_along_where_it_does_as_well(
    hidden: str, values: dict[str, float], classed: bool
) -> None:
    arm = true_arm()
    motions = programme(arm, np.random.default_rng(1), ("slow reversals", "multisine", "via points"), 4.0)
    lags = [Injection(hidden, joint, {"time": 0.015}) for joint in arm.names]
    runs = record(arm, lags, motions, rate=250.0, noise=1e-6, gains=default_gains(arm, 3.0), model=arm, seed=5)
    prepared = prepare(nominal_arm(), runs)
    base = retune(prepared, FLOOR)
    late = fit_model(prepared, (Placed(LATE, 0),), weights_of(base, prepared, FLOOR), base.fit, {"time": 0.015})
    step = Step(base, (late,), rank(prepared, [base, late], FLOOR, 0), (1,), (), FLOOR)
    with Parallel(n_jobs=1) as pool:
        (found,) = with_lags(prepared, [step], [base], pool, 0)
        (barred,) = with_lags(prepared, [step], [base], pool, 0, ["actuator_lag"])
    assert not barred.as_good
    names = [model.placed[-1].effect.name for model in found.as_good]
    assert names == (["time_shift", "actuator_lag"] if classed else [])
    assert all({place.joint for place in model.placed} == {0, 1} for model in found.as_good[1:])
