"""How strong an effect has to be to be clear, medium or weak on a given arm and motion.

Most effects are sized by measurement: their strength is changed until the torque that they are worth along the
motions (`measure.relative_gap`) is a drawn share of the torque that moves the joint. Some are worth little torque
anywhere however strong they are (they live in a few milliradians, at rest, or in another channel); these have
strengths as they are met in practice, on an axis that slides in parts of its way (`Stage.radian`). Every strength
stays within what can be built; where that is too little for the share asked for, the effect is weaker than its level
says, and the case notes what it is worth.

What is clear must be so to somebody who does not know the arm: a share of the torque that re-tuning takes in (a payload
within the tolerance of the last link's mass) shows nothing. Such an effect is made stronger until enough is left of it,
within the same bounds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from stribeck.arm import Arm
from stribeck.errors import StribeckError
from stribeck.withheld.injections import Injection
from stribeck.withheld.measure import relative_gap
from stribeck.withheld.motions import Motion
from stribeck.withheld.plant import Diverged
from stribeck.withheld.recorder import Gains
from stribeck.withheld.scales import SCALES
from stribeck.withheld.stage import stage_of

# Share of the rms torque that moves the joint (inertia and friction)
SHARES: Mapping[str, tuple[float, float]] = {"clear": (0.10, 0.25), "medium": (0.05, 0.10), "weak": (0.015, 0.05)}
ROUNDS, CLOSE = 4, 0.15  # trials at most, and how near is near enough, relative
CLEARLY = 3.0  # noise floors that re-tuning leaves of what is clear
FASTEST = 3.0  # factor by which a trial is stronger than the one before


def severity(
    effect: str,
    arm: Arm,
    joint: str,
    motions: Sequence[Motion],
    level: str,
    rng: np.random.Generator,
    gains: Gains | None = None,
    left: Callable[[Injection], float] | None = None,
) -> dict[str, float]:
    """Return parameters at which `effect` in `joint` is ``clear``, ``medium`` or ``weak`` along `motions`.

    Parameters
    ----------
    effect, joint, level : str
        Names; `SHARES` holds the levels.
    arm : Arm
        The true arm.
    motions : sequence of Motion
        What will be recorded; the effect is measured on these.
    rng : numpy.random.Generator
        Draws the share, and phases, harmonics and places.
    gains : Gains or None
        Controller of the laboratory.
    left : callable or None
        From an effect to what re-tuning leaves of it, over the noise floor; what is clear is not told by it where None.

    Raises
    ------
    StribeckError
        For an effect or a level that is not known.
    """
    if effect not in SCALES or level not in SHARES:
        raise StribeckError("no such effect or level", f"{effect}, {level}", f"levels are {', '.join(SHARES)}")
    scale, k = SCALES[effect], arm.names.index(joint)
    build = scale.build(stage_of(arm, k, motions, rng))
    if scale.levels is not None:
        low, high = scale.levels[level]
        return _short(build(math.exp(rng.uniform(math.log(low), math.log(high)))))
    target = float(rng.uniform(*SHARES[level]))

    def worth(s: float) -> float:
        return float(relative_gap(arm, [Injection(effect, joint, build(s))], motions, gains)[k])

    s = _search(worth, target, scale.range)
    if level == "clear" and left is not None:
        s = _raised(lambda s: left(Injection(effect, joint, build(s))), s, scale.range[1])
    return _short(build(s))


def _short(params: Mapping[str, float]) -> dict[str, float]:
    return {name: float(f"{value:.4g}") for name, value in params.items()}


def _search(worth: Callable[[float], float], target: float, bounds: tuple[float, float]) -> float:
    """Find the number at which `worth` is near `target`: straight lines in the logarithm, within the bounds."""
    low, high = bounds
    s, power, last = math.sqrt(low * high), 1.0, None
    for _ in range(ROUNDS):
        try:
            now = max(worth(s), 1e-6)
        except Diverged:  # too strong to hold on to
            high = s
            s = math.sqrt(low * s)
            continue
        if abs(now / target - 1.0) < CLOSE:
            break
        if last is not None and abs(math.log(s / last[0])) > 1e-3:
            power = min(2.0, max(0.4, math.log(now / last[1]) / math.log(s / last[0])))
        last = (s, now)
        s = min(high, max(low, s * (target / now) ** (1.0 / power)))
    return s


def _raised(left: Callable[[float], float], s: float, high: float) -> float:
    """Return the number, made larger until `left` is enough; the last one that can be held where it never is."""
    held = s
    for _ in range(ROUNDS):
        try:
            now = left(s)
        except Diverged:
            break
        held = s
        if now >= CLEARLY or s >= high:
            break
        s = min(high, s * min(FASTEST, 1.2 * CLEARLY / max(now, 1e-6)))
    return held
