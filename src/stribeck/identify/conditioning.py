"""Recorded runs made ready for the cut: smoothed motion, centred command, stuck samples, the analysis filter.

Motion and torque pass the same zero-phase filters, so that filtering changes the balance of neither side.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.ndimage import maximum_filter1d, minimum_filter1d

from stribeck.arm import Arm
from stribeck.identify.braked import braked, undriven
from stribeck.identify.cutoff import MOST_OF_MOTION, motion_cutoff
from stribeck.identify.filters import decimated, low_pass, smoother
from stribeck.identify.flutter import flutter
from stribeck.identify.noise import encoder_noise
from stribeck.identify.sliding import sliding
from stribeck.run import Run

OVERSAMPLING = 3.0  # analysis samples per second over the cutoff
RATE_OVER_CUTOFF = 10.0  # samples per second that a thinned run keeps, over the cutoff
STUCK_TIME = 0.04  # s
WITHIN = 4.0  # standard deviations of noise, from end to end, that a record may stray at rest: one step of an encoder
SURE = 2.0  # standard deviations of the record's own differences, that the smoothed velocity may be off them
STILL = 1e-3  # of the rms speed: slower is at rest
INSTANT = (0.5, 0.1)  # of a sample, and of the period of the motion's filter: a reversal is as near as that to its own


@dataclass(frozen=True)
class Past:
    """What was recorded before a run's first sample.

    ``recordings`` were made, of ``recorded`` s together, and each joint had gone ``travelled`` (n,) in them, rad. Where
    the run is a part of a recording, that had lasted for ``lead`` s of its ``whole`` time, s, and each joint gone
    ``led`` (n,) in it.
    """

    recordings: int = 0
    recorded: float = 0.0
    travelled: np.ndarray | float = 0.0
    lead: float = 0.0
    led: np.ndarray | float = 0.0
    whole: float = 0.0


@dataclass(frozen=True)
class Conditioned:
    """One run on its uniform grid of N samples, with its M analysis samples.

    ``position``, ``velocity``, ``acceleration``, ``command``, ``stuck`` are (N, n); so are ``flutter``, noise in the
    acceleration that is too fast for the analysis, ``resting``, 1 where a joint surely rests, ``sliding``, the part of
    the motion that is no noise, and ``velocity_sd``, what encoder noise leaves in the velocity, or its filter after a
    hard stop and at a hard turn; ``noise`` (n,) is the encoder's own;
    ``undriven`` (n,) tells which joints have no torque all along, and ``braked`` (n,) which are held; ``instant`` is
    the time to either side for which a sample stands, s; ``analysis_time`` (M,); ``taps`` the low-pass (odd length).
    ``without`` are the names of effects that are not there in it, whatever the model has (set in
    ``gap.fitted.carrying``).
    ``clock`` is the time of the first sample by the clock of what acts from outside, s (set in ``gap.fitted.clocks``);
    None: its own. ``past`` is what was recorded before it (set in ``gap.records.sequence``). The low-pass is flat up to
    the ``cutoff``, Hz, or rolled off from a ``corner`` on (set in ``gap.fitted.band``).
    """

    name: str
    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    flutter: np.ndarray
    command: np.ndarray
    resting: np.ndarray
    sliding: np.ndarray
    velocity_sd: np.ndarray
    instant: float
    stuck: np.ndarray
    noise: np.ndarray
    undriven: np.ndarray
    braked: np.ndarray
    taps: np.ndarray
    decimation: int
    cutoff: float
    run: Run
    corner: float = math.inf
    clock: float | None = None
    past: Past = Past()
    without: frozenset[str] = frozenset()

    @property
    def told_time(self) -> np.ndarray:
        """Time (N,) that a law in time is told, s: the record's own, unless the run was given another ``clock``."""
        return self.time if self.clock is None else self.time - self.time[0] + self.clock

    def as_recorded(self, run: Conditioned) -> Conditioned:
        """Return a run in the place among all recordings that another conditioning of it was given, and its band."""
        told = {name: getattr(run, name) for name in ("clock", "past", "braked", "undriven", "without")}
        return replace(self, **told).rolled_off(run.corner)

    def rolled_off(self, corner: float) -> Conditioned:
        """Return the run with a low-pass that is rolled off from a corner on, Hz; a flat one where that is infinite."""
        if corner == self.corner:
            return self
        return replace(self, taps=low_pass(self.cutoff, self.sample_time, corner), corner=corner)

    @property
    def sample_time(self) -> float:
        """Step of the uniform grid, s."""
        return float(self.time[1] - self.time[0])

    @property
    def analysis_index(self) -> np.ndarray:
        """Samples (M,) at which filtered signals are kept; the filter's edges are dropped."""
        half = len(self.taps) // 2
        return np.arange(half, len(self.time) - half, self.decimation)

    def filtered(self, values: np.ndarray) -> np.ndarray:
        """Return values (K, ...) low-passed, rows i centred on sample i * decimation + half the taps' length."""
        flat = values.reshape(len(values), math.prod(values.shape[1:]))
        kept = decimated(flat.T, self.taps, self.decimation).T
        return kept.reshape(len(kept), *values.shape[1:])


def condition(
    arm: Arm,
    run: Run,
    cutoff: float,
    noise: np.ndarray | None = None,
    *,
    thin: bool = False,
    sharpness: float = 1.0,
    louder: float = 1.0,
    resting: np.ndarray | None = None,
) -> Conditioned:
    """Return one uniform run conditioned at an analysis cutoff (Hz).

    Parameters
    ----------
    arm : Arm
    run : Run
    cutoff : float
        Analysis cutoff, Hz.
    noise : array (n,) or None
        Position noise, rad; estimated from the run where None.
    thin : bool
        Keep only as many samples as the cutoff needs, after both sides have passed the motion's filter.
    sharpness : float
        Factor on the motion filter's cutoff, to see how much a residual owes to it.
    louder : float
        Noise of the run over ``noise``, for ``velocity_sd`` and ``sliding`` alone: the filters are those of ``noise``.
    resting : array (N, n) or None
        Where the joints surely rest; read off the run where None.
    """
    h = run.sample_time
    keep = max(1, int(1.0 / (RATE_OVER_CUTOFF * cutoff * h))) if thin else 1
    if noise is None:
        noise = encoder_noise(arm, [run])
    sharp = min(motion_cutoff(run, noise, cutoff), MOST_OF_MOTION / (keep * h))
    smooth, passed, gain = smoother(sharpness * sharp, h)
    position = smooth(run.q)
    curve = make_interp_spline(run.t, position, k=5)
    velocity, acceleration = curve(run.t, 1), curve(run.t, 2)
    command = held_command(run.tau if run.droop is None else run.tau + run.droop)
    if keep > 1:
        command = smooth(command)
    speed = np.sqrt(np.mean(velocity**2, axis=0))
    resting = at_rest(run, noise) if resting is None else resting
    velocity_sd = np.maximum(louder * gain * noise, 0.5 * STILL * speed + 1e-9)
    # after a hard stop, and at a hard turn, the filter rings on
    velocity_sd = np.maximum(velocity_sd, np.where(resting, np.abs(velocity), rung(run, velocity, louder * noise)))
    stuck = _stuck(velocity, np.maximum(3.0 * gain * noise, STILL * speed), h)
    return Conditioned(
        name=run.name,
        time=run.t[::keep],
        position=position[::keep],
        velocity=velocity[::keep],
        acceleration=acceleration[::keep],
        flutter=flutter(acceleration, louder * noise, sharpness * sharp, cutoff, h)[::keep],
        command=command[::keep],
        resting=resting[::keep].astype(float),
        sliding=sliding(position[::keep], louder * passed * noise),
        velocity_sd=velocity_sd[::keep],
        instant=INSTANT[0] * keep * h + INSTANT[1] / (sharpness * sharp),
        stuck=stuck[::keep],
        noise=noise,
        undriven=undriven(arm, run),
        braked=braked(arm, run, noise),
        taps=low_pass(cutoff, keep * h),
        decimation=max(1, int(1.0 / (OVERSAMPLING * cutoff * keep * h))),
        cutoff=cutoff,
        run=run,
    )


def shaken(arm: Arm, run: Conditioned, cutoff: float, draw: np.ndarray) -> Conditioned:
    """Return a thinned run with its own noise times a draw (N, n) added once more to its recorded positions.

    It knows that its velocities scatter more: else a joint at rest would seem to move, which the record's did not.
    """
    moved = replace(run.run, q=run.run.q + run.noise * draw)
    louder, resting = float(np.sqrt(2.0)), at_rest(run.run, run.noise)
    return condition(arm, moved, cutoff, run.noise, thin=True, louder=louder, resting=resting).as_recorded(run)


def rung(run: Run, velocity: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """Return by how much a smoothed velocity (N, n) is off the record's own differences beyond what noise gives them.

    As a standard deviation, rad/s: half of what exceeds SURE deviations of such a difference.
    """
    h = run.sample_time
    differences = np.gradient(run.q, h, axis=0)
    own = noise / (np.sqrt(2.0) * h)
    return np.asarray(0.5 * np.maximum(np.abs(velocity - differences) - SURE * own, 0.0))


def at_rest(run: Run, noise: np.ndarray) -> np.ndarray:
    """Return where a record (N, n) stays within its own noise for at least STUCK_TIME."""
    width = max(3, round(STUCK_TIME / run.sample_time)) | 1
    if len(run.q) < width:
        return np.zeros(run.q.shape, dtype=bool)
    span = maximum_filter1d(run.q, width, axis=0) - minimum_filter1d(run.q, width, axis=0)
    still = span <= WITHIN * noise
    still[: width // 2] = still[len(still) - width // 2 :] = False  # no whole window is centred there
    return np.asarray(maximum_filter1d(still, width, axis=0, mode="constant"))


def held_command(tau: np.ndarray) -> np.ndarray:
    """Return a zero-order-hold command (N, n) as the continuous signal that it is, at the samples.

    A value held from its sample to the next is seen half a step late and averaged over the step, sinc(w h / 2). The
    mean of the values before and after has the right phase and cos(w h / 2); the second difference mends the rest.
    """
    before = np.concatenate([tau[:1], tau[:-1]])
    return emphasised(0.5 * (tau + before))


def emphasised(values: np.ndarray) -> np.ndarray:
    """Return values (N, n) less a twelfth of their second difference: undoes a droop of (w h)^2 / 12."""
    out = values.copy()
    out[1:-1] -= np.diff(values, 2, axis=0) / 12.0
    return out


def _stuck(velocity: np.ndarray, threshold: np.ndarray, h: float) -> np.ndarray:
    """Return 1.0 where a joint stays below its threshold for at least STUCK_TIME."""
    width = max(3, round(STUCK_TIME / h))
    stuck = np.zeros_like(velocity)
    for j in range(velocity.shape[1]):
        slow = np.abs(velocity[:, j]) < threshold[j]
        edges = np.flatnonzero(np.diff(np.concatenate([[0], slow.astype(int), [0]])))
        for start, stop in zip(edges[::2], edges[1::2], strict=True):
            if stop - start >= width:
                stuck[start:stop, j] = 1.0
    return stuck
