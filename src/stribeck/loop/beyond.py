"""What a loop ends in from outside the sinusoids that its describing function finds."""

from __future__ import annotations

from collections.abc import Sequence

from stribeck.arm import unit_at
from stribeck.loop.cycle import WORDS, Cycle
from stribeck.loop.describing.roots import Root
from stribeck.loop.exact.ending import answers
from stribeck.loop.exact.engine import RoundsEngine
from stribeck.loop.exact.rounds import Rounds
from stribeck.loop.exact.shooting import ending_of
from stribeck.simulate import Loop

TIMES = 5.0  # of the sinusoid's amplitude, at which the loop is started: the first swing back is damped


def beyond(engine: RoundsEngine, loop: Loop, joint: str, roots: Sequence[Root], known: Cycle) -> str:
    """Return a note where a loop ends otherwise from beyond its outermost sinusoid than from its other starts; "" else.

    A sinusoid that is unstable parts motions that shrink from those that grow. Where no larger one is stable a loop may
    rest from every start within it, and be lost from without.

    Parameters
    ----------
    engine : RoundsEngine
    loop : Loop
    joint : str
    roots : sequence of Root
        Of the joint's describing function.
    known : Cycle
        The answer from the other starts.
    """
    outer = max(roots, key=lambda root: root.amplitude, default=None)
    rounds = Rounds(engine, loop)
    if outer is None or outer.stable or rounds.noisy:
        return ""
    error = TIMES * outer.amplitude
    verdict = answers(rounds, ending_of(rounds, rounds.start({joint: error})))[joint].verdict
    if verdict == "undetermined" or verdict in (known.verdict, *known.basin.values()):
        return ""
    unit = unit_at("rad", engine.arm.joints[rounds.index(joint)].kind)
    inside, far = f"{1e3 * outer.amplitude:.3g} m{unit}", f"{1e3 * error:.3g} m{unit}"
    ends = "it grows without bound" if verdict == "unbounded" else f"it ends in {WORDS.get(verdict, verdict)}"
    return f"from an error of {far} {ends}: the describing function has an unstable sinusoid of ±{inside}"
