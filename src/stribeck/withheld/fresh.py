"""Recordings of a sealed case that nobody has seen: the same arm, effects and laboratory, another motion."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from stribeck.arm import Arm
from stribeck.run import Run
from stribeck.withheld.bench import Bench
from stribeck.withheld.excitation import programme
from stribeck.withheld.injections import Injection
from stribeck.withheld.recorder import record

KINDS = ("via points", "slow reversals", "multisine")
OWN_STREAM = 31  # of random numbers, apart from those of the case


def fresh_runs(truth: Mapping[str, Any], true: Arm, nominal: Arm) -> tuple[Run, ...]:
    """Record new motions of a case.

    Parameters
    ----------
    truth : mapping
        The case's entry in the key: ``seed``, ``laboratory``, ``effects`` and ``disturbances``.
    true, nominal : Arm
        The arm that recorded, and what its controller believes of it.

    Raises
    ------
    Diverged
        Where the arm cannot be held along these motions.
    """
    bench, seed = Bench(**truth["laboratory"]), int(truth["seed"])
    hidden = [Injection(e["effect"], e["joint"], e["parameters"]) for e in (*truth["effects"], *truth["disturbances"])]
    motions = programme(nominal, np.random.default_rng([seed, OWN_STREAM]), KINDS, bench.duration, bench.one_by_one)
    return record(
        true, hidden, motions, rate=bench.rate, noise=bench.noise, gains=bench.gains(nominal), model=nominal,
        channels=bench.channels, seed=seed + OWN_STREAM,
    )  # fmt: skip
