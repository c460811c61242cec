"""The return map of a continuous loop on the turns of one joint, its fixed points and their multipliers."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stribeck.loop.exact.place import Place, Stretch
from stribeck.loop.exact.rest import active_states, deviations, follow, seen_deviations, states_of
from stribeck.loop.exact.rounds import Rounds
from stribeck.loop.exact.turns import TINY

Floats = NDArray[np.float64]
_STEP = 1e-6  # of a difference, over the size of the cycle
_MOST_ITERATIONS = 12
_CLOSE = 1e-9  # of the cycle's size: a fixed point
_STAYS = 1e-6  # of its size that a cycle may move in a further round


@dataclass(frozen=True)
class Fixed:
    """A fixed point of the return map: a periodic motion.

    Attributes
    ----------
    place : Place
        On the section.
    turns : structured array
        Of all joints during one period.
    period : float
        s.
    multipliers : array (m,) of complex
        Largest first.
    """

    place: Place
    turns: np.ndarray
    period: float
    multipliers: NDArray[np.complex128]

    @property
    def stable(self) -> bool:
        """Whether small disturbances die out."""
        return bool(np.all(np.abs(self.multipliers) < 1.0))


class ReturnMap:
    """The map from one turn of joint ``watch`` to the ``fold``-th next, in the loop's active coordinates.

    Parameters
    ----------
    rounds : Rounds
        Continuous.
    watch : int
    template : Place
        A turn of that joint; what is not among the coordinates is taken from it.
    fold : int
    still : set of int
        Joints that stand still beside the motion; where they do so is no coordinate, nor what their controllers do.
    """

    def __init__(
        self, rounds: Rounds, watch: int, template: Place, fold: int = 1, still: frozenset[int] = frozenset()
    ) -> None:  # fmt: skip
        self.rounds, self.watch, self.template, self.fold = rounds, watch, template, fold
        n, modes = rounds.n, template.values[rounds.layout.modes]
        held = {n + j for j in range(n) if modes[j] == 0.0} | {n + watch} | states_of(rounds, still)
        self.still = sorted(still)
        self.kept = [i for i in active_states(rounds) if i not in held]

    def coordinates(self, place: Place) -> Floats:
        """Return the coordinates (m,) of a place: deviations for positions, else the states themselves."""
        state = place.values[self.rounds.layout.state].copy()
        state[: self.rounds.n] = deviations(self.rounds, place)
        return np.asarray(state[self.kept])

    def place(self, z: Floats) -> Place:
        """Return the place on the section with the coordinates ``z`` (m,)."""
        layout, values, n, j = self.rounds.layout, self.template.values.copy(), self.rounds.n, self.watch
        state = values[layout.state]
        shift = np.zeros(layout.ny)
        shift[self.kept] = z - self.coordinates(self.template)
        state += shift
        rate = self.rounds.rate(j)
        state[n + j] = rate
        if rate == 0.0:  # it arrives from above; whether it stops or reverses is found anew
            values[layout.modes][j] = 1.0
            if self.rounds.axes[j].filter == self.rounds.axes[j].dead_band == 0.0:
                values[layout.held][j] = 1.0
        values[1] = 1.0
        marks = values[layout.marks].reshape(n, -1)
        here = seen_deviations(self.rounds, replace(self.template, values=values))
        marks[j] = [0.0, here[j], here[j], 0.0, 0.0]
        return replace(self.template, values=values)

    def apply(self, z: Floats) -> tuple[Floats, Stretch] | None:
        """Return where the map takes ``z``, and how; None where the joint does not turn again."""
        done = follow(self.rounds, self.place(z), self.watch, self.fold, 1e7)
        return (self.coordinates(done.place), done) if done.why == "enough" else None

    def moved(self, place: Place, after: Place) -> bool:
        """Tell whether a joint that is to stand still does not."""
        state = self.rounds.layout.state
        return bool((np.abs(after.values[state] - place.values[state])[self.still] > _STAYS * TINY).any())

    def slopes(self, z: Floats, image: Floats, scale: Floats) -> Floats | None:
        """Return the derivative (m, m) of the map at ``z`` by differences."""
        matrix = np.zeros((len(z), len(z)))
        for i in range(len(z)):
            moved = z.copy()
            moved[i] += _STEP * scale[i]
            found = self.apply(moved)
            if found is None:
                return None
            matrix[:, i] = (found[0] - image) / (_STEP * scale[i])
        return matrix


def solve(section: ReturnMap, z: Floats, scale: Floats) -> Fixed | None:
    """Return the fixed point of the map near ``z`` (Newton's method), None where there is none within reach.

    Parameters
    ----------
    section : ReturnMap
    z : array (m,)
        First guess.
    scale : array (m,)
        Size of each coordinate along the cycle.
    """
    first = np.inf
    for _ in range(_MOST_ITERATIONS):
        found = section.apply(z)
        if found is None:
            return None
        image, done = found
        miss = image - z
        error = float(np.max(np.abs(miss) / scale))
        slopes = section.slopes(z, image, scale)
        if slopes is None or not np.isfinite(slopes).all() or error > 10.0 * first:
            return None
        if error < _CLOSE:
            again = section.apply(image)  # an unstable rest is a fixed point to rounding, and left within a round
            if again is None or float(np.max(np.abs(again[0] - image) / scale)) > _STAYS:
                return None
            roots = np.linalg.eigvals(slopes).astype(complex)
            order = np.argsort(-np.abs(roots))
            return _cycle(section, done.place, roots[order])
        first = min(first, error)
        try:
            z = z + np.linalg.solve(np.eye(len(z)) - slopes, miss)
        except np.linalg.LinAlgError:
            return None
    return None


def _cycle(section: ReturnMap, place: Place, multipliers: NDArray[np.complex128]) -> Fixed | None:
    """Return the period from a place on the cycle; the one before it has swept the other joints' marks clean."""
    done = follow(section.rounds, place, section.watch, section.fold, 1e7)
    if done.why != "enough" or section.moved(place, done.place):
        return None
    return Fixed(place, done.turns, done.place.time - place.time, multipliers)
