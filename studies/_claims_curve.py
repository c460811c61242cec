"""Claims about the friction curve and its identification (2.3, 3, 4.1, 4.2)."""

from __future__ import annotations

import numpy as np
from _claims import Claim, judged
from _laws import least_viscous
from _paper import SPEEDS, constants
from _repeats import errors, repeat

from stribeck.identify.section3.saddle import alphas_by_velocity
from stribeck.identify.tustin_fit import tustin


def curve_claims(repeats: int, seed: int) -> list[Claim]:
    """Return the verdicts; so many draws of the paper's readings."""
    true, rng = constants("A"), np.random.default_rng(seed)
    rows = [repeat(true, rng) for _ in range(repeats)]
    by_hand, fit, plain = (errors(rows, true, method) for method in ("section3", "ipopt", "least_squares"))
    saddle = -true[3] * np.log(true[2] * true[3] / true[1])
    alphas = alphas_by_velocity(saddle, true[1], true[2])
    left = true[1] * np.exp(-saddle / true[3]) / tustin(true, np.array([saddle]))[0]
    least = {f"{v:g}": least_viscous(v) for v in (1e-6, SPEEDS[0])}
    friction = float(tustin(true, np.array([0.03]))[0])
    lost = {"no_curve": by_hand["no_curve"], "of": repeats, "curve_error": by_hand["curve"]}
    fits = {"curve_error": plain["curve"], "ipopt": fit["curve"]}
    both = {"friction_at_0.03": friction, "least_C2": least}
    failing = judged(by_hand["no_curve"] > 0.3 * repeats, by_hand["no_curve"] > 0)
    return [
        Claim("linear_part", judged(left < 0.02), {"decay_at_the_saddle": float(left)}, "curve"),
        Claim("infinite_alphas", judged(len(alphas) > 2), {"alphas": alphas}, "curve"),
        Claim("least_squares", judged(plain["curve"]["median"] > 0.05), fits, "curve"),
        Claim("scatter", failing, lost, "curve"),
        Claim("both_torques", judged(abs(friction - 6.5) < 0.1), both, "curve"),
    ]
