"""The gap in motion: forward simulation from recorded states, as the check that the torque gap is the real one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stribeck.arm import Arm
from stribeck.errors import StribeckError
from stribeck.identify.conditioning import Conditioned, condition
from stribeck.simulate.engine import Engine, path_of
from stribeck.simulate.predict import predict_conditioned

BRAKE = 1e9  # N m, N


def motion_gap(arm: Arm, runs: Sequence[Conditioned], cutoff: float, horizon: float) -> tuple[dict[str, float], int]:
    """Return the rms position error (rad) per joint over windows of a horizon (s), and the windows that failed.

    A window that the simulation could not finish is left out of every joint's figure and counted. A joint that a brake
    holds in a run is held.
    """
    path = path_of(arm)
    engine = Engine(path)
    squares, count, failed = np.zeros(arm.n), 0, 0
    for thinned in runs:
        run = condition(arm, thinned.run, cutoff, thinned.noise).as_recorded(thinned)
        prediction = predict_conditioned(engine, _with_brakes(engine, run), run, horizon)
        good = ~np.isin(prediction.window, prediction.failed)
        failed += len(prediction.failed)
        error = (prediction.q - run.position)[good]
        squares += np.sum(error**2, axis=0)
        count += len(error)
    if count == 0:
        raise StribeckError("no window could be simulated", do="give a shorter horizon")
    return {name: float(np.sqrt(squares[j] / count)) for j, name in enumerate(arm.names)}, failed


def _with_brakes(engine: Engine, run: Conditioned) -> np.ndarray:
    """Return the parameter values (p,) with friction that nothing overcomes at the joints that a run holds."""
    level = [entry.owner == "friction" and entry.name == "C0" for entry in engine.path.entries]
    joint = [entry.joint for entry in engine.path.entries]
    return np.where(level & run.braked[joint], BRAKE, engine.p)
