"""Decoys: laws that are no effects of the library, against which a name must hold. None of them is ever named.

Of laws that no library holds, some pass for one that it does: a share of another drive's command is a torque gain to a
fit that knows no better. Each decoy is torque linear in a constant or a few: couplings of two joints that no effect of
the library is, inertia that varies, a drive that speed, heat or its own torque weakens or that pulls harder to one
side, a tool that rings or swings.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations, permutations
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from stribeck.arm import Arm
from stribeck.identify.conditioning import Conditioned

Floats = NDArray[np.float64]
Term: TypeAlias = Callable[[Conditioned], Floats]

RINGS = np.geomspace(1.0, 16.0, 20)  # Hz, of a tool: a step is three times what its damping widens
BESIDE = (0.95, 1.0, 1.05)  # of these: what lies between two is a mixture
DAMPING = 0.05
MOVED = (0.05, 0.9, 0.2)  # a step of a tool's frequency and damping (logarithms), and of its reach in last links
WARMS, WARMED = 5.0, (0.5, 300.0)  # s
DAMPED, REACHES, SWINGS = (0.003, 0.7), (0.0, 1.0), (0.1, 25.0)  # what a tool may come to; Hz


@dataclass(frozen=True)
class Decoy:
    """A law outside the library: what it ``says`` in words, and its ``terms``, each a torque (N, n) along a run.

    One unknown constant belongs to each term, whose unit does not matter; that of a law that ``resists`` is positive.
    The torques are such as a drive must give. ``nearby`` makes the law with other values of what its torque is not
    linear in, ``bent`` things, each moved by so many steps (bent,); None where there are none. Decoys of one ``form``
    lead to one another so.
    """

    says: str
    terms: tuple[Term, ...]
    resists: bool = False
    nearby: Callable[[Floats], Decoy] | None = None
    bent: int = 0
    form: str = ""

    def rows(self, runs: Sequence[Conditioned]) -> Floats:
        """Return the terms' torques (M, n, terms) at the analysis samples of runs, filtered as a residual is.

        A joint at rest takes no part: its friction is an interval there, and holds against any of them.
        """
        parts = []
        for run in runs:
            moving = (run.stuck < 0.5).astype(float)
            parts.append(np.stack([run.filtered(moving * term(run)) for term in self.terms], axis=2))
        return np.concatenate(parts)


def decoys(arm: Arm) -> Iterator[Decoy]:
    """Yield all decoys for an arm; what is said of turns, of those joints that turn."""
    names, turning = arm.names, [joint.kind == "revolute" for joint in arm.joints]
    for j, name in enumerate(names):
        for turns in (1, 2) if turning[j] else ():
            says = f"an inertia at {name} that varies {turns} time{'s' * (turns > 1)} a turn (a linkage, an unbalance)"
            yield Decoy(says, (_varying(j, turns, 0.0), _varying(j, turns, 0.5 * np.pi)))
        yield Decoy(f"torque that speed takes at {name} (a drive's voltage limit)", (_at(j, _taken_by_speed),), True)
        yield Decoy(f"a drive at {name} that pulls harder to one side (half of its bridge)", (_at(j, _one_sided),))
        says = f"a drive at {name} whose gain changes with its torque (iron that saturates)"
        yield Decoy(says, (_at(j, _by_its_torque),))
        warmth = partial(_warmth, j, name)
        yield replace(warmth(np.zeros(1)), nearby=warmth, bent=1, form=f"heat {j}")
    for hertz in RINGS if arm.n > 1 and all(turning) else ():  # at a single joint a stand that gives way is the same
        terms = tuple(_rings(arm, beside * hertz) for beside in BESIDE)
        yield Decoy(_tool(arm, hertz), terms, nearby=partial(_swings, arm, hertz), bent=len(MOVED), form="tool")
    for i, j in permutations(range(arm.n), 2):
        one, other = names[i], names[j]
        yield Decoy(f"a share of {other}'s command at {one} (cross-talk of drives)", (_from(i, j, _command),))
        yield Decoy(f"friction at {one} under the load of {other}", (_from(i, j, _friction_under),), True)
        yield Decoy(f"torque at {one} by the square of {other}'s speed", (_from(i, j, _squared_speed),))
    for i, j in combinations(range(arm.n), 2):
        pair = f"between {names[i]} and {names[j]}"
        yield Decoy(f"an inertia {pair} (a differential)", (_across(i, j, lambda run: run.acceleration),))
        yield Decoy(f"damping {pair}", (_across(i, j, lambda run: run.velocity),))
        rests = (_at(i, _constant), _at(j, _constant))  # wherever that is
        for way, kind in ((-1.0, "an open tendon"), (1.0, "a crossed tendon")):
            yield Decoy(f"a spring {pair} ({kind})", (_stretched(i, j, way), *rests))
        if turning[i] and turning[j]:
            yield Decoy(f"friction {pair}, in their common motion (an idler)", (_rubbing(i, j, 1.0),), True)
            yield Decoy(f"friction {pair}, in their relative motion", (_rubbing(i, j, -1.0),), True)


def _tool(arm: Arm, hertz: float) -> str:
    return f"a tool that rings across {arm.names[-1]}'s link at {hertz:.2g} Hz"


def _swings(arm: Arm, hertz: float, moved: Floats) -> Decoy:
    """Return a tool on a soft hinge at the end of the last link, its mass some way beyond."""
    steps = np.asarray(moved) * MOVED
    hertz = float(np.clip(hertz * np.exp(steps[0]), *SWINGS))
    damping = float(np.clip(DAMPING * np.exp(steps[1]), *DAMPED))
    return Decoy(_tool(arm, hertz), (_rings(arm, hertz, damping, float(np.clip(steps[2], *REACHES))),))


def _rings(arm: Arm, hertz: float, damping: float = DAMPING, reach: float = 0.0) -> Term:
    """Return the term of a mass that rings across the end of the last link, beyond that of one that is fixed there.

    It hangs on a hinge there, ``reach`` link lengths behind it.
    """

    def term(run: Conditioned) -> Floats:
        felt, lever = _across_the_end(arm, run, reach)
        return np.asarray(lever * (_swinging(felt, hertz, damping, run.sample_time) - felt)[:, None])

    return term


def _across_the_end(arm: Arm, run: Conditioned, reach: float) -> tuple[Floats, Floats]:
    """Return what a mass beyond the last link feels across it (N,), m/s^2, and its torque by 1 N (N, n)."""
    angle, speed, rate = (np.cumsum(of, axis=1) for of in (run.position, run.velocity, run.acceleration))
    last = angle[:, -1]
    turned, lengths = angle - last[:, None], np.array([joint.length for joint in arm.joints])
    lengths[-1] *= 1.0 + reach
    lever = np.cos(turned) * lengths  # of each link's turn
    felt = np.sum(lever * rate - np.sin(turned) * lengths * speed**2, axis=1)
    felt -= np.array(arm.gravity) @ np.array([-np.sin(last), np.cos(last)])
    return felt, np.cumsum(lever[:, ::-1], axis=1)[:, ::-1]


def _swinging(felt: Floats, hertz: float, damping: float, sample_time: float) -> Floats:
    """Return the acceleration of a mass on a spring whose other end feels so much (N,); it starts at rest."""
    omega = 2.0 * np.pi * hertz
    spring = [2.0 * damping * omega, omega**2]
    b, a = signal.bilinear(spring, [1.0, *spring], 1.0 / sample_time)
    return np.asarray(signal.lfilter(b, a, felt, zi=signal.lfilter_zi(b, a) * felt[0])[0])


def _at(j: int, torque: Callable[[Conditioned, int], Floats]) -> Term:
    """Return the term by which joint ``j`` takes a torque of its own signals."""
    return _from(j, j, lambda run, at, other: torque(run, at))


def _from(i: int, j: int, torque: Callable[[Conditioned, int, int], Floats]) -> Term:
    """Return the term by which joint ``i`` takes a torque that comes from joint ``j``."""

    def term(run: Conditioned) -> Floats:
        out = np.zeros_like(run.position)
        out[:, i] = torque(run, i, j)
        return out

    return term


def _across(i: int, j: int, signal: Callable[[Conditioned], Floats]) -> Term:
    """Return the term of a coupling matrix: each joint takes what the other's signal (N, n) makes."""

    def term(run: Conditioned) -> Floats:
        values = signal(run)
        out = np.zeros_like(values)
        out[:, i], out[:, j] = values[:, j], values[:, i]
        return out

    return term


def _rubbing(i: int, j: int, side: float) -> Term:
    """Return the term of Coulomb friction in the motion dq_i + side dq_j, which acts on both joints."""

    def term(run: Conditioned) -> Floats:
        out = np.zeros_like(run.velocity)
        out[:, i] = np.sign(run.velocity[:, i] + side * run.velocity[:, j])
        out[:, j] = side * out[:, i]
        return out

    return term


def _varying(j: int, turns: int, phase: float) -> Term:
    """Return the term of an inertia J = cos(k q + phase) in J ddq + J' dq^2 / 2."""

    def torque(run: Conditioned, j: int) -> Floats:
        angle = turns * run.position[:, j] + phase
        slope = -turns * np.sin(angle)
        return np.asarray(np.cos(angle) * run.acceleration[:, j] + 0.5 * slope * run.velocity[:, j] ** 2)

    return _at(j, torque)


def _taken_by_speed(run: Conditioned, j: int) -> Floats:
    return np.asarray(run.command[:, j] * run.velocity[:, j] ** 2)


def _one_sided(run: Conditioned, j: int) -> Floats:
    return np.asarray(np.abs(run.command[:, j]))


def _by_its_torque(run: Conditioned, j: int) -> Floats:
    return np.asarray(run.command[:, j] * np.abs(run.command[:, j]))


def _warmth(j: int, name: str, moved: Floats) -> Decoy:
    """Return torque that a winding's own heat takes: by the squared command of some seconds, cold at first."""
    seconds = float(np.clip(WARMS * np.exp(moved[0]), *WARMED))

    def torque(run: Conditioned, j: int) -> Floats:
        share = 1.0 - np.exp(-run.sample_time / seconds)
        heat = signal.lfilter([share], [1.0, share - 1.0], run.command[:, j] ** 2)
        return np.asarray(run.command[:, j] * heat)

    return Decoy(f"torque that heat takes at {name} (a magnet that warms)", (_at(j, torque),), True)


def _constant(run: Conditioned, j: int) -> Floats:
    return np.ones_like(run.position[:, j])


def _stretched(i: int, j: int, way: float) -> Term:
    """Return the term of a spring that two joints stretch by their sum or their difference: it pulls at both."""

    def term(run: Conditioned) -> Floats:
        out = np.zeros_like(run.position)
        out[:, i] = run.position[:, i] + way * run.position[:, j]
        out[:, j] = way * out[:, i]
        return out

    return term


def _command(run: Conditioned, i: int, j: int) -> Floats:
    return np.asarray(-run.command[:, j])  # a share of it helps


def _friction_under(run: Conditioned, i: int, j: int) -> Floats:
    return np.asarray(np.sign(run.velocity[:, i]) * np.abs(run.command[:, j]))


def _squared_speed(run: Conditioned, i: int, j: int) -> Floats:
    return np.asarray(run.velocity[:, j] ** 2)
