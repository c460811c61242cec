"""A sampled loop seen at its samples: the map over whole samples, in the numbers that act on its motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stribeck.loop.exact.place import Place, Stretch
from stribeck.loop.exact.rounds import NONE, Rounds

Floats = NDArray[np.float64]
_STEP = 1e-5  # of a difference, over the size of each coordinate
_OF_SAMPLE = 1e-3  # the same of an integral, over what one sample adds: a joint that sticks lets go at a sample
_HALVINGS, _AGREE = 12, 1e-3  # of a step, until the differences of two agree
LAST, FILTERED, INTEGRAL, THETA = 0, 1, 2, 4  # in the memory of a joint


class Strobe:
    """The map of a sampled loop from a sample to the ``samples``-th next.

    A sampled loop does not depend on where in time its samples lie, so that a motion that repeats after whole samples
    is a fixed point of this map; its derivative is exact where no event falls on a sample.

    Parameters
    ----------
    rounds : Rounds
        Sampled.
    template : Place
        At a sample; what is not among the coordinates, contact modes and held signs among it, is taken from it.
    samples : int
    size, rate : float
        Amplitude (rad) and angular frequency (rad/s) of the motion, by which steps of differences are measured.
    """

    def __init__(self, rounds: Rounds, template: Place, samples: int, size: float, rate: float) -> None:
        self.rounds, self.template, self.samples = rounds, template, samples
        rows = [row for entry in rounds.loop.joints for row in _of_joint(rounds, entry.joint, size, rate)]
        rows += _of_effects(rounds, template)
        self._in_values = np.array([row[0] for row in rows], dtype=int)
        self._turned = np.array([row[1] for row in rows], dtype=int)  # the joint whose reference counts, or -1
        self._past = _of_past(rounds)
        commands = [size * rounds.entry(rounds.arm.names[j]).kp for _, _, j in self._past]
        self.scale = np.array([row[2] for row in rows] + commands)
        layout, modes = rounds.layout, template.values[rounds.layout.modes]
        integrals = [layout.memory.start + layout.memory_width * j + INTEGRAL for j in range(rounds.n)]
        self._steps = _STEP * self.scale
        self._steps[: len(rows)][np.isin(self._in_values, integrals)] = _OF_SAMPLE * size * rounds.loop.sample_time
        still = [layout.state.start + rounds.n + j for j in range(rounds.n) if modes[j] == 0.0]
        self.frozen = np.isin(np.arange(len(self.scale)), np.flatnonzero(np.isin(self._in_values, still)))

    def coordinates(self, place: Place) -> Floats:
        """Return the coordinates (m,) of a place; positions are less their references."""
        here = place.values[self._in_values] - self._reference(place.time)
        return np.concatenate([here, [place.past[which] for which in self._past]])

    def place(self, z: Floats) -> Place:
        """Return the place with the coordinates ``z`` (m,)."""
        values, past = self.template.values.copy(), self.template.past.copy()
        shift, count = z - self.coordinates(self.template), len(self._in_values)
        values[self._in_values] += shift[:count]
        for which, by in zip(self._past, shift[count:], strict=True):
            past[which] += by
        return replace(self.template, values=values, past=past)

    def apply(self, z: Floats) -> tuple[Floats, Stretch] | None:
        """Return where the map takes ``z``, and how; None where the motion grows without bound."""
        span = (self.samples + 0.5) * self.rounds.loop.sample_time
        done = self.rounds.run(self.place(z), NONE, most=self.samples, duration=span, quiet=False)
        return (self.coordinates(done.place), done) if done.why == "end" else None

    def slopes(self, z: Floats, image: Floats) -> Floats | None:
        """Return the derivative (m, m) of the map at ``z`` by differences; a joint that sticks has no velocity.

        None where they hang on their step, however small: a change of a sign falls on a sample right there.
        """
        matrix = np.zeros((len(z), len(z)))
        for i in np.flatnonzero(~self.frozen):
            column = self._column(z, image, int(i))
            if column is None:
                return None
            matrix[:, i] = column
        return matrix

    def _column(self, z: Floats, image: Floats, i: int) -> Floats | None:
        step, before = self._steps[i], None
        for _ in range(_HALVINGS):
            moved = z.copy()
            moved[i] += step
            found = self.apply(moved)
            if found is None:
                return None
            column: Floats = (found[0] - image) / step
            scaled = column * self.scale[i] / self.scale
            if before is not None and np.abs(scaled - before).max() <= _AGREE * max(1.0, np.abs(scaled).max()):
                return column
            step, before = 0.5 * step, scaled
        return None

    def _reference(self, time: float) -> Floats:
        entries = {self.rounds.index(entry.joint): entry for entry in self.rounds.loop.joints}
        return np.array([entries[j].start + self.rounds.rate(j) * time if j >= 0 else 0.0 for j in self._turned])


def _of_joint(rounds: Rounds, joint: str, size: float, rate: float) -> list[tuple[int, int, float]]:
    """Return a joint's own coordinates: index into a place's values, joint whose reference counts or -1, scale."""
    layout, j, entry = rounds.layout, rounds.index(joint), rounds.entry(joint)
    state, memory = layout.state.start, layout.memory.start + layout.memory_width * j
    rows = [(state + j, j, size), (state + layout.n + j, -1, size * rate)]
    if entry.actuator_lag > 0.0:
        rows.append((state + layout.size + j, -1, size * entry.kp))
    if entry.velocity != "true":
        rows.append((memory + LAST, j, size))
    if entry.velocity_filter > 0.0:
        rows.append((memory + FILTERED, -1, size * rate))
    if entry.ki > 0.0:
        rows.append((memory + INTEGRAL, -1, size / rate))
    if entry.compensation.kind == "adaptive":
        level = rounds.axes[j].friction
        rows += [(memory + THETA + i, -1, max(abs(float(level[i])), 1e-3)) for i in range(3)]
    return rows


def _of_effects(rounds: Rounds, template: Place) -> list[tuple[int, int, float]]:
    state, begin = rounds.layout.state.start, 2 * rounds.n
    here = template.values[rounds.layout.state]
    return [(state + i, -1, max(abs(float(here[i])), 1e-3)) for i in range(begin, rounds.layout.size)]


def _of_past(rounds: Rounds) -> list[tuple[int, int, int]]:
    """Return the past commands that still come through: computed (0) or issued (1), row, joint."""
    late = bool(rounds.engine.forward.delays)
    kept = []
    for entry in rounds.loop.joints:
        j, rows = rounds.index(entry.joint), rounds.history
        kept += [(0, row, j) for row in range(rows - entry.delay_samples, rows)]
        kept += [(1, row, j) for row in range(rows) if late]
    return kept
