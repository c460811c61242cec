"""The gap in motion: forward simulation from recorded states, as the check that the torque gap is the real one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from stribeck.arm import Arm
from stribeck.errors import StribeckError
from stribeck.gap.fitted.corrected import arm_of
from stribeck.gap.fitted.model import Model
from stribeck.gap.records.prepare import Prepared
from stribeck.identify.conditioning import Conditioned, condition
from stribeck.simulate.engine import Engine, path_of
from stribeck.simulate.predict import predict_conditioned

BRAKE = 1e9  # N m, N
HORIZON = 0.5  # s
ASTRAY = 5.0  # times as far, that an arm with what is there never went astray: of 646 right names 4 at most


class Motions:
    """How far arms go astray that are simulated forward from what was recorded; a model is simulated but once.

    Parameters
    ----------
    prepared : Prepared
        Its held-out runs are simulated.
    """

    def __init__(self, prepared: Prepared) -> None:
        self.prepared = prepared
        self._known: dict[int, tuple[Model, tuple[dict[str, float], str]]] = {}

    def of(self, model: Model) -> tuple[dict[str, float], str]:
        """Return the error of a model in motion by joint, rad rms, none where nothing goes; and what did not."""
        if id(model) not in self._known:
            self._known[id(model)] = model, self.of_arm(arm_of(self.prepared.arm, model.fit, model.placed))
        return self._known[id(model)][1]

    def of_arm(self, arm: Arm) -> tuple[dict[str, float], str]:
        """Return the same of an arm."""
        try:
            motion, failed = motion_gap(arm, self.prepared.held, self.prepared.cutoff, HORIZON)
        except StribeckError as error:
            return {}, f"no motion gap: {error}"
        said = f"{failed} windows could not be simulated and are left out of the motion gap" if failed else ""
        return motion, said

    def strayed(self, chain: Sequence[Model]) -> dict[str, float]:
        """Return the effects with which the models of a chain go astray, and how many times as far as without.

        Their torque fits, but their motion would be another one: they stand for something else.
        """
        out: dict[str, float] = {}
        for before, after in pairwise(chain):
            without, beside = (math.hypot(*self.of(model)[0].values()) for model in (before, after))
            if beside > ASTRAY * without > 0.0:
                out[after.placed[-1].effect.name] = beside / without
        return out


def told_strayed(strayed: dict[str, float]) -> list[str]:
    """Return a warning for each effect with which the arm goes astray."""
    return [
        f"{effect}: simulated forward, the arm with it goes {times:.2g} times as far astray as without: it stands for "
        "something else, and is not named"
        for effect, times in strayed.items()
    ]


def motion_gap(arm: Arm, runs: Sequence[Conditioned], cutoff: float, horizon: float) -> tuple[dict[str, float], int]:
    """Return the rms position error (rad) per joint over windows of a horizon (s), and the windows that failed.

    A window that the simulation could not finish is left out of every joint's figure and counted. A joint that a brake
    holds in a run is held, and an effect that a run is without is not there in it.
    """
    path = path_of(arm)
    engine = Engine(path)
    squares, count, failed = np.zeros(arm.n), 0, 0
    for thinned in runs:
        run = condition(arm, thinned.run, cutoff, thinned.noise).as_recorded(thinned)
        prediction = predict_conditioned(engine, _as_in(engine, run), run, horizon)
        good = ~np.isin(prediction.window, prediction.failed)
        failed += len(prediction.failed)
        error = (prediction.q - run.position)[good]
        squares += np.sum(error**2, axis=0)
        count += len(error)
    if count == 0:
        raise StribeckError("no window could be simulated", do="give a shorter horizon")
    return {name: float(np.sqrt(squares[j] / count)) for j, name in enumerate(arm.names)}, failed


def _as_in(engine: Engine, run: Conditioned) -> np.ndarray:
    """Return the parameter values (p,) as they are in a run: null those of effects that it is without.

    With friction that nothing overcomes at the joints that it holds.
    """
    level = [entry.owner == "friction" and entry.name == "C0" for entry in engine.path.entries]
    joint = [entry.joint for entry in engine.path.entries]
    return np.where(level & run.braked[joint], BRAKE, engine.path.without(run.without, engine.p))
