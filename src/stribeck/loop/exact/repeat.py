"""Where a sampled loop's motion repeats exactly, and what becomes of a small disturbance of it.

Between two changes of a sign the law and the motion are smooth and contract, so that nearly every cycle of a sampled
loop locks onto its samples: after some rounds, which take a whole number of samples, it repeats to the last digit. Such
a motion is a fixed point of the map over those samples; Newton's method finds it, and the eigenvalues of the map's
derivative are its multipliers. Where none is found the mean rates of growth along the motion (Lyapunov numbers, by
repeated QR factorisation: Benettin et al. 1980, Meccanica 15) stand in their place.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stribeck.loop.exact.ending import Ending, size_of
from stribeck.loop.exact.place import Place
from stribeck.loop.exact.rounds import NONE, Rounds
from stribeck.loop.exact.strobe import Strobe
from stribeck.simulate import JointLoop

Floats = NDArray[np.float64]
_MOST_ROUNDS, _MOST_SAMPLES = 48, 60_000  # within which it is to repeat
_SETTLING = 100  # further rounds first
_OFFSETS = 17  # samples of a round that are compared
_ALIKE = 1e-3  # of the cycle's size: rounds that may be the same
_NEAR = 0.02  # of the cycle's size: so close to the motion its fixed point must be
_CLOSE, _ITERATIONS, _TRIES = 1e-9, 6, 3
_ROUNDS = 12  # over which rates of growth are averaged
_LEAST = 1e-6  # a multiplier below is what a difference leaves of zero
_TURNS = 64  # of the averages
_LEAST_MOVE = 1e-12  # rad; SB_LEAST_MOVE in control.h
DIES = "its velocity dies out before it turns: the least step that counts (1e-12 rad), or noise, sets the period"


def repeated(rounds: Rounds, ending: Ending) -> Ending:
    """Return the ending of a sampled loop with its multipliers, on the exactly repeating motion where there is one.

    Parameters
    ----------
    rounds : Rounds
        Of a continuous loop, under noise, dither or the steps of an encoder nothing is changed.
    ending : Ending
        Any; only a lasting motion changes.
    """
    smooth = not rounds.noisy and all(_smooth(entry) for entry in rounds.loop.joints)
    if not (rounds.sampled and smooth and ending.kind == "roughly"):
        return ending
    size, period = _largest(ending)
    ts = rounds.loop.sample_time
    settled = rounds.run(ending.place, NONE, duration=min(_SETTLING * period, _MOST_SAMPLES * ts), quiet=False)
    if settled.why != "end":
        return ending
    motion = _Motion(rounds, settled.place, size, period)
    out = _with_multipliers(rounds, ending, motion)
    return replace(out, status=f"{out.status}; {DIES}") if motion.dies else out


def _with_multipliers(rounds: Rounds, ending: Ending, motion: _Motion) -> Ending:
    for samples in motion.candidates():
        found = _newton(Strobe(rounds, motion.place, samples, motion.size, motion.rate))
        if found is not None:
            return _on_orbit(rounds, ending, *found, samples)
    growth = _growth(motion)
    if growth is None:
        return ending
    return replace(ending, multipliers=_kept(growth), status=f"{ending.status}; multipliers are mean growth a round")


def _smooth(entry: JointLoop) -> bool:
    return entry.encoder_resolution == 0.0 and entry.compensation.kind != "dither"


class _Motion:
    """A stretch of settled motion, from the sample at which it is fastest."""

    def __init__(self, rounds: Rounds, place: Place, size: float, period: float) -> None:
        self.rounds, self.size, self.rate = rounds, size, 2.0 * np.pi / period
        ts = rounds.loop.sample_time
        self.round = max(round(period / ts), 1)
        first = rounds.run(place, NONE, rows=self.round + 1, quiet=False).record
        speed = np.abs(first[:, 1] - [rounds.rate(j) for j in range(rounds.n)])
        self.dies = _dies(speed * ts, first[:, 2] != 0.0)
        speed = speed[:, speed.max(axis=0) > 1e-3 * speed.max()]
        base = int(np.argmax((speed / speed.max(axis=0)).min(axis=1))) if speed.size else 0  # it stood all the time
        self.place = rounds.run(place, NONE, duration=(base + 0.5) * ts, quiet=False).place if base else place

    def candidates(self) -> list[int]:
        """Return whole numbers of samples after which the motion is nearly where it was, fewest first."""
        rows = min(_MOST_ROUNDS * self.round, _MOST_SAMPLES) + self.round + 1
        record = self.rounds.run(self.place, NONE, rows=rows, quiet=False).record
        seen = np.concatenate([record[:, 0] / self.size, record[:, 1] / (self.size * self.rate)], axis=1)
        offsets = np.unique(np.linspace(0, self.round, _OFFSETS).astype(int))
        count = rows - self.round
        miss = np.max([np.abs(seen[o : o + count] - seen[o]).max(axis=1) for o in offsets], axis=0)
        miss[: self.rounds.history + 1] = np.inf  # the past must be forgotten
        lowest = (miss <= np.roll(miss, 1)) & (miss <= np.roll(miss, -1)) & (miss < _ALIKE)
        return [int(k) for k in np.flatnonzero(lowest)[:_TRIES]]


def _dies(move: Floats, slides: NDArray[np.bool_]) -> bool:
    """Tell whether a joint slides on by less and less, until its steps (rad) from one sample to the next are none."""
    below = slides & (move < 10.0 * _LEAST_MOVE)
    return bool((below[1:] & below[:-1]).any())


def _newton(map_: Strobe) -> tuple[Place, NDArray[np.complex128]] | None:
    """Return a stable fixed point of the map near its template, and its multipliers."""
    origin = z = map_.coordinates(map_.template)
    slopes, before = None, np.inf
    for _ in range(_ITERATIONS):
        found = map_.apply(z)
        if found is None or np.max(np.abs(z - origin) / map_.scale) > _NEAR:
            return None
        miss = found[0] - z
        error = float(np.max(np.abs(miss) / map_.scale))
        if error > 0.5 * before:  # a change of sign falls on a sample nearby: nothing smooth to solve
            return None
        if slopes is None or error > 0.1 * before or error < _CLOSE:
            slopes = map_.slopes(z, found[0])
        if slopes is None:
            return None
        if error < _CLOSE:
            roots = np.linalg.eigvals(slopes).astype(complex)
            roots = roots[np.argsort(-np.abs(roots))]
            return (map_.place(z), roots) if abs(roots[0]) < 1.0 else None
        before = error
        try:
            z = z + np.linalg.solve(np.eye(len(z)) - slopes, miss)
        except np.linalg.LinAlgError:
            return None
    return None


def _on_orbit(
    rounds: Rounds, ending: Ending, place: Place, roots: NDArray[np.complex128], samples: int
) -> Ending:  # fmt: skip
    """Return the ending on a motion that repeats after so many samples; multipliers are those of one round."""
    span = samples * rounds.loop.sample_time
    count = max(round(span / _largest(ending)[1]), 1)
    times = max(-(-_TURNS // count), 2)
    done = rounds.run(place, NONE, most=times * samples, duration=times * span, quiet=False)
    if done.why != "end":
        return ending
    each = roots if count == 1 else (np.abs(roots) ** (1.0 / count)).astype(complex)
    what = f"repeats every {samples} samples" + ("" if count == 1 else f", {count} rounds: means over them")
    return replace(
        ending, place=done.place, turns=done.turns, span=done.place.time - place.time, multipliers=_kept(each),
        status=what, repeat=span,
    )  # fmt: skip


def _growth(motion: _Motion) -> Floats | None:
    """Return the mean factors (m,) by which disturbances of a motion grow in a round, largest first."""
    place, logs, basis = motion.place, [], None
    for _ in range(_ROUNDS):
        map_ = Strobe(motion.rounds, place, motion.round, motion.size, motion.rate)
        z = map_.coordinates(place)
        found = map_.apply(z)
        slopes = None if found is None else map_.slopes(z, found[0])
        if found is None or slopes is None:
            return None
        scaled = slopes * map_.scale / map_.scale[:, None]
        basis, triangle = np.linalg.qr(scaled if basis is None else scaled @ basis)
        logs.append(np.log(np.abs(np.diag(triangle)) + 1e-300))
        place = found[1].place
    return np.sort(np.exp(np.mean(logs[2:], axis=0)))[::-1]


def _kept(roots: NDArray[np.complex128] | Floats) -> tuple[complex, ...]:
    """Return the multipliers without those that vanish; one at least."""
    return tuple(complex(root) for i, root in enumerate(roots) if i == 0 or abs(root) > _LEAST)


def _largest(ending: Ending) -> tuple[float, float]:
    """Return the largest amplitude (rad) and the longest period (s) of all joints."""
    sizes = [size_of(ending, ending.turns[ending.turns["joint"] == j]) for j in np.unique(ending.turns["joint"])]
    return max(size[0] for size in sizes), max(size[1] for size in sizes)
