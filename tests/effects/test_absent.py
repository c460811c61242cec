"""No effect is chosen where there is none: a full search over the bench's clean recordings takes nothing."""

import numpy as np
import pytest

from stribeck.gap.records.prepare import prepare
from stribeck.gap.search.search import search
from stribeck.gap.search.setting import Asked
from stribeck.gap.search.tuned import retuned
from stribeck.withheld.excitation import programme
from stribeck.withheld.recorder import default_gains, record

from .bench import NOISE, RATE, nominal_arm, true_arm

KINDS = ("slow reversals", "multisine", "via points", "point to point", "speed stairs", "multisine")


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_nothing_is_taken(seed: int) -> None:
    arm = nominal_arm()
    motions = programme(arm, np.random.default_rng(seed), KINDS, 6.0)
    runs = record(true_arm(), (), motions, rate=RATE, noise=NOISE, gains=default_gains(arm, 3.0), model=arm, seed=seed)
    prepared = prepare(arm, runs)
    asked = Asked(seed, jobs=1)
    _, steps = search(retuned(prepared, asked), asked)
    best = steps[0].best
    assert [step.taken for step in steps] == [False], best.placed if best else None
