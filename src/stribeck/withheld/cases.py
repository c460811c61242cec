"""Blind cases: an arm, its wrong data sheet, and recordings with an effect that is known only here."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stribeck.arm import Arm
from stribeck.withheld.arms import misinformed, random_arm
from stribeck.withheld.bench import ALWAYS, draw_bench
from stribeck.withheld.excitation import programme
from stribeck.withheld.hide import Case, Plot, hide
from stribeck.withheld.motions import Motion

__all__ = ["Case", "make_case"]


def make_case(
    seed: int,
    effect: str | Sequence[str] | None,
    level: str = "clear",
    n_joints: int = 2,
    *,
    joint: str | None = None,
    vertical: bool | None = None,
    disturbed: bool = False,
    smooth: bool = False,
) -> Case:
    """Record a case in which everything but the effect's name and level is drawn from `seed`.

    Parameters
    ----------
    seed : int
        The same seed gives the same case.
    effect : str, sequence of str, or None
        Of `injections.KNOWN` or `injections.UNKNOWN`; None hides nothing.
    level : str
        ``clear``, ``medium`` or ``weak``, see `severity`.
    n_joints : int
        1 to 4.
    joint : str or None
        Where the effect sits; drawn where None.
    vertical : bool or None
        Whether gravity acts; drawn where None.
    disturbed : bool
        Whether coloured torque noise shakes a joint, which is no effect of the arm.
    smooth : bool
        Whether a joint has friction without a falling part, as arms with ``negative_damping`` have.
    """
    rng = np.random.default_rng([seed, 2026])
    names = (effect,) if isinstance(effect, str) else tuple(effect or ())
    upright = bool(rng.random() < 0.5) if vertical is None else vertical
    if vertical is None:  # an offset shows only under gravity, a torque limit only where gravity does not need it all
        upright = (upright or "encoder_offset" in names) and "torque_saturation" not in names
    true = random_arm(rng, n_joints, upright)
    bench = draw_bench(rng, true, names)
    count = 2.0 * math.pi / 2**bench.bits
    true = replace(
        true,
        sample_time=1.0 / bench.rate,
        joints=tuple(replace(j, encoder_resolution=count) for j in true.joints),
    )
    places = [joint or place_of(rng, name, true) for name in names]
    for name, place in zip(names, places, strict=True):
        if name == "negative_damping":
            true = _without_stribeck(true, place)
    if smooth:
        true = _without_stribeck(true, str(np.random.default_rng([seed, 2027]).choice(true.names)))
    nominal = misinformed(true, rng, float(rng.choice([0.02, 0.05, 0.1])), float(rng.choice([0.1, 0.2, 0.3])))
    motions = programme(nominal, rng, bench.kinds, bench.duration, bench.one_by_one)
    plot = Plot(names, tuple(places), level, int(rng.integers(2**31)), disturbed)
    return hide(true, nominal, motions, _telling(motions), bench, plot, seed)


def place_of(rng: np.random.Generator, name: str, arm: Arm, among: Sequence[str] = ()) -> str:
    """Return the joint in which an effect is hidden: drawn, of all or ``among`` some, but for those with one place."""
    drawn = str(rng.choice(among or arm.names))
    return only_place(name, arm) or drawn


def only_place(name: str, arm: Arm) -> str | None:
    """Return the one joint in which an effect can be; None for one that can be in any."""
    return {"payload": arm.names[-1], "gravity_tilt": arm.names[0], "base_flexibility": arm.names[0]}.get(name)


def _without_stribeck(arm: Arm, place: str) -> Arm:
    """Friction of joint `place` without its falling part, so that negative damping is news."""
    joints = [
        replace(j, friction=replace(j.friction, C1=0.0), backward=replace(j.backward, C1=0.0)) if j.name == place else j
        for j in arm.joints
    ]
    return replace(arm, joints=tuple(joints))


def _telling(motions: Sequence[Motion]) -> list[Motion]:
    """Return three motions that size the effect: one of each kind that is always there, and one more."""
    first = [next(i for i, motion in enumerate(motions) if motion.name == kind) for kind in ALWAYS]
    other = next(i for i in range(len(motions)) if i not in first)
    return [motions[i] for i in sorted([*first, other])]
