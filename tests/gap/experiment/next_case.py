"""Two candidates fitted to recordings of the pendulum, and recordings of a further motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np
from scipy.interpolate import CubicSpline

from stribeck.effects.registry import registry
from stribeck.gap.experiment.plan import DURATION
from stribeck.gap.fitted.model import Model, fit_model, retune, weights_of
from stribeck.gap.records.floor import noise_floor
from stribeck.gap.records.prepare import Prepared, prepare
from stribeck.gap.search.rank import rank
from stribeck.gap.search.screen import screen
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath
from stribeck.run import Run
from stribeck.withheld.excitation import programme
from stribeck.withheld.injections import Injection
from stribeck.withheld.motions import Motion
from stribeck.withheld.recorder import Gains, default_gains, record

from ..conftest import NOMINAL, TRUE


@dataclass(frozen=True)
class Question:
    """Two candidates for what recordings show, the better fit first."""

    prepared: Prepared
    floor: np.ndarray
    base: Model
    models: tuple[Model, ...]

    @property
    def names(self) -> list[str]:
        return [model.placed[-1].effect.name for model in self.models]

    def apart(self) -> float:
        """How far apart the two are on these recordings, as a t value: the root of the likelihood ratio."""
        return float(np.sqrt(2.0 * abs(self.models[0].fit.cost - self.models[1].fit.cost)))

    def told_apart(self) -> bool:
        """Whether the search's own rule tells them apart."""
        ranking = rank(self.prepared, [self.base, *self.models], self.floor, 0)
        return len(ranking.twins()) == 1

    def best(self) -> str:
        ranking = rank(self.prepared, [self.base, *self.models], self.floor, 0)
        return self.names[ranking.best - 1]


def question(runs: Sequence[Run], names: Sequence[str]) -> Question:
    """Fit the effects ``names`` to runs, the second of which is held out."""
    runs = list(runs)
    prepared = prepare(NOMINAL, [runs[0], *runs[2:]], [runs[1]])
    path = SignalPath(NOMINAL)
    noise = noise_floor(NOMINAL, path, values_of(path.entries), prepared.held, prepared.cutoff, 0)
    floor = np.sqrt(np.mean(noise**2, axis=0))
    base = retune(prepared, floor)
    weights = weights_of(base, prepared, floor)
    models = []
    for name in names:
        start = screen(prepared, base, weights, registry()[name], 0).start
        placed = (Placed(registry()[name], 0),)
        models.append(fit_model(prepared, placed, weights, base.fit, start, evaluations=30))
    weights = weights_of(min(models, key=lambda m: m.fit.cost), prepared, floor)
    models = [fit_model(prepared, m.placed, weights, m.fit, evaluations=20) for m in models]
    return Question(prepared, floor, base, tuple(sorted(models, key=lambda m: m.fit.cost)))


def followed(reference: Run, hidden: Sequence[Injection], noise: float = 1e-5) -> Run:
    """Return what the independent plant does under a PID controller that follows a reference and its torque."""
    assert reference.q_ref is not None
    spline = CubicSpline(reference.t, reference.q_ref[:, 0])

    def curve(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return spline(t), spline(t, 1), spline(t, 2)

    forward = partial(np.interp, xp=reference.t, fp=reference.tau[:, 0])
    motion = Motion("next", float(reference.t[-1]), (curve,), (forward,))
    (run,) = _recorded([motion], hidden, default_gains(NOMINAL, 3.0, forward="none"), noise)
    return run


def at_random(hidden: Sequence[Injection], seed: int, noise: float = 1e-5) -> Run:
    """Return as long a recording of the plant along a random motion, of the kinds that an engineer records."""
    kinds = ("slow reversals", "multisine", "via points", "point to point", "speed stairs", "sweep", "micro steps")
    rng = np.random.default_rng(seed)
    motions = programme(NOMINAL, rng, [str(rng.choice(kinds))], DURATION)
    (run,) = _recorded(list(motions), hidden, default_gains(NOMINAL, 3.0), noise)
    return run


def _recorded(motions: list[Motion], hidden: Sequence[Injection], gains: Gains, noise: float) -> tuple[Run, ...]:
    return record(TRUE, hidden, motions, rate=250.0, noise=noise, gains=gains, model=NOMINAL, seed=11)


CASES = [
    *product(["actuator_lag"], [{"time": 0.005}, {"time": 0.008}], [("delay", "actuator_lag")]),
    *product(["delay"], [{"time": 0.005}, {"time": 0.008}], [("delay", "actuator_lag")]),
    ("joint_flexibility", {"stiffness": 5000.0}, ("joint_flexibility", "backlash")),
    ("backlash", {"gap": 0.003}, ("joint_flexibility", "backlash")),
]
