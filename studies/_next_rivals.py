"""What else one could record: motions of equal length within the same limits, at random and D-optimal."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.interpolate import PchipInterpolator

from stribeck.gap.experiment.choice import Options
from stribeck.gap.experiment.motions import Reach
from stribeck.gap.experiment.plan import SMALLER, Plan
from stribeck.run import Run
from stribeck.withheld.motions import Array

GAPS = (0.3, 1.5)  # s, between random points, before all are slowed down to what the joint may do
POINTS = 200
SMOOTHED = 0.05  # s
REST = 0.3  # s, at either end


def d_optimal(plan: Plan, options: Options, duration: float) -> Run:
    """Return the D-optimal programme for the re-tuned model, of the same kinds of motion; still for what is left."""
    choice = plan.classic(options)
    q = choice.programme.course(plan.step, options.reach)
    more = round(duration / plan.step) + 1 - len(q)
    return plan.followable(np.concatenate([q, np.repeat(q[-1:], max(more, 0), axis=0)]))


def at_random(plan: Plan, options: Options, duration: float, seed: int) -> Run:
    """Return a motion past random points without stops, as fast as a joint may, or smaller for the torque's sake."""
    t = plan.step * np.arange(round(duration / plan.step) + 1)
    for size in SMALLER:
        run = plan.followable(_past_points(t, options.reach, size, np.random.default_rng([seed, 77])))
        if np.all(np.abs(run.tau) <= plan.limit):
            break
    return run


def _past_points(t: Array, reach: Sequence[Reach], size: float, rng: np.random.Generator) -> Array:
    return np.stack([r.centre + size * (_wander(t, r, rng) - r.centre) for r in reach], axis=1)


def _wander(t: Array, reach: Reach, rng: np.random.Generator) -> Array:
    """Return positions (N,) past points drawn from the range, from rest to rest."""
    knots = np.concatenate([[0.0], np.cumsum(rng.uniform(*GAPS, POINTS))])
    curve = PchipInterpolator(knots, rng.uniform(reach.low, reach.high, POINTS + 1))
    fine = np.linspace(0.0, knots[-1], 20 * POINTS)
    speed = np.quantile(np.abs(curve(fine, 1)), 0.99) / reach.speed
    acceleration = np.sqrt(np.quantile(np.abs(curve(fine, 2)), 0.99) / reach.acceleration)
    slower = max(speed, acceleration, 1e-9)
    progress = np.clip(t - REST, 0.0, t[-1] - 2.0 * REST) / slower
    width = max(3, round(SMOOTHED / (t[1] - t[0])))
    window = np.hanning(width + 2)[1:-1]
    padded = np.pad(curve(np.minimum(progress, knots[-1])), (width, width), mode="edge")
    return np.asarray(np.convolve(padded, window / window.sum(), mode="same")[width:-width])
