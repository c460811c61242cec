"""Prediction: from the recorded state, on under the recorded command, over and over."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline
from scipy.ndimage import convolve1d, maximum_filter1d

from stribeck.arm import Arm, doubtful_values
from stribeck.errors import InputError
from stribeck.grid import LONG_AGO, uniform
from stribeck.identify.commanded import doubtful_commands, doubtful_torques
from stribeck.identify.conditioning import Conditioned, condition
from stribeck.identify.cutoff import cutoff_frequency
from stribeck.identify.filters import low_pass
from stribeck.identify.noise import encoder_noise
from stribeck.identify.residual import Residual
from stribeck.run import Run
from stribeck.simulate.engine import Engine, path_of
from stribeck.simulate.late import LateRecord, lateness

Floats = NDArray[np.float64]

ROUNDING = 1e-6  # of a sample time that is told by the record's own clock


@dataclass(frozen=True)
class Prediction:
    """A predicted recording of N samples in W windows.

    Attributes
    ----------
    t : array (N,)
        s.
    window : array (N,) of int
        The window to which each sample belongs.
    q, dq : array (N, n)
        Predicted record of position and velocity, rad and rad/s. Where a window ended early its last values are held.
    tau : array (N, n)
        Torque that the model needs along the recorded motion, N m of command, held from row to row as the command is;
        it departs from the command only below the cutoff up to which the recording's noise allows accelerations to be
        told, and at the recording's ends by as much as next to them. The link of a flexible joint is corrected by what
        was missing before (:mod:`stribeck.model.observer`): it is a prediction one sample ahead.
    status : tuple of str
        Of each window: ``ok``, or why it ended early.
    notes : tuple of str
        What was done to the recording first, for the reader.
    warnings : tuple of str
        What there is to doubt of the arm, the recording and the horizon.
    motion_error, torque_error : array (n,) or None
        Rms difference of ``q`` and ``tau`` from what was recorded, rad and N m; windows that ended early are left out.
        So are those with missing samples in the one, and rows near these in the other.
    """

    t: Floats
    window: NDArray[np.int64]
    q: Floats
    dq: Floats
    tau: Floats
    status: tuple[str, ...]
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    motion_error: Floats | None = None
    torque_error: Floats | None = None

    @property
    def failed(self) -> tuple[int, ...]:
        """Windows that ended early."""
        return tuple(i for i, status in enumerate(self.status) if status != "ok")


def predict(arm: Arm, run: Run, horizon: float) -> Prediction:
    """Start at the recorded state every ``horizon`` seconds and simulate on under the recorded command.

    Parameters
    ----------
    arm : Arm
        With the effects of its file.
    run : Run
        Put on a uniform clock first where it is not on one; then the prediction is on that clock.
    horizon : float
        Length of a window, s; at least two samples.

    Raises
    ------
    InputError
        When the run has not the arm's joints or the horizon does not fit the run.
    """
    if run.n != arm.n:
        raise InputError(f"{run.name}: not a recording of this arm", f"{run.n} joints", f"the arm has {arm.n}")
    recorded, began = run, run.t[0]
    run, notes = uniform(run)
    engine = Engine(path_of(arm))
    noise = encoder_noise(arm, [run], [recorded])
    cutoff = cutoff_frequency(arm, [run], engine.moved_inertia(np.median(run.q, axis=0)), noise)
    every, thinned = (condition(arm, run, cutoff, noise, thin=thin) for thin in (False, True))
    found = predict_conditioned(engine, engine.p, every, horizon, thinned)
    warnings = (
        *doubtful_values(arm),
        *(f"{run.name}: {text}" for text in run.warnings),
        *doubtful_torques(arm, [run], noise),
        *doubtful_commands(engine.path, engine.p, [thinned]),
        *_beyond(run, horizon),
    )
    good = ~np.isin(found.window, found.failed)
    across, near = _missing(run, found.window, thinned)
    if across.any():
        lost = f"{len(np.unique(found.window[across]))} of {found.window[-1] + 1} windows lie across missing samples"
        warnings = (
            *warnings,
            f"{run.name}: {lost}; they count in no motion error, and rows near them in no torque error",
        )
    errors = [
        np.sqrt(np.mean((told - recorded)[used] ** 2, axis=0)) if used.any() else np.full(arm.n, np.nan)
        for told, recorded, used in ((found.q, run.q, good & ~across), (found.tau, run.tau, good & ~near))
    ]
    t = found.t + (began - run.t[0] if abs(began) >= LONG_AGO else 0.0)
    return replace(found, t=t, notes=notes, warnings=warnings, motion_error=errors[0], torque_error=errors[1])


def _missing(run: Run, window: NDArray[np.int64], filtered: Conditioned) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows (N,) of windows with missing samples, and those that these reach through the filters."""
    if run.gaps is None:
        return np.zeros(len(run.t), dtype=bool), np.zeros(len(run.t), dtype=bool)
    half = round(len(filtered.taps) // 2 * filtered.sample_time / run.sample_time)
    return np.isin(window, window[run.gaps]), maximum_filter1d(run.gaps, 2 * half + 1)


def _beyond(run: Run, horizon: float) -> list[str]:
    """Return a warning where a recording is shorter than a window."""
    if horizon <= run.duration + 2 * run.sample_time:
        return []
    return [f"{run.name}: lasts {run.duration:.4g} s, less than the horizon of {horizon:g} s: it is one shorter window"]


def predict_conditioned(
    engine: Engine, p: Floats, data: Conditioned, horizon: float, thinned: Conditioned | None = None
) -> Prediction:
    """Do as `predict`, for given parameter values and a run that has been conditioned.

    Where it is given ``thinned``, too, that tells the torque, as it does in a diagnosis: the friction of a joint at
    rest depends on how sharp the steps of its command are.

    Parameters
    ----------
    engine : Engine
    p : array (p,)
        Parameter values, SI.
    data : Conditioned
        The run, not thinned.
    horizon : float
        Length of a window, s.
    thinned : Conditioned or None
        The same run, thinned.
    """
    first, samples = _windows(data, horizon)
    residual = Residual(engine.path, [data], columns=())
    late = lateness(engine.path, p)
    alike = np.ptp(late) == 0.0
    record = LateRecord(data, np.zeros(len(late)) if alike else late / data.sample_time)
    prompt = p if alike else _prompt(engine, p)
    longer = np.minimum(samples + record.further, len(data.time) - first)
    states = _start_states(engine, p, record, residual, first)
    found = engine.windows(prompt, states, data.told_time, data.run.tau, first, longer)
    q, dq = (
        record.told(_held(values, first, longer, found.filled, recorded), recorded, first, samples)
        for values, recorded in ((found.q, data.position), (found.dq, data.velocity))
    )
    departure = _departure(engine, p, thinned or data, data.time)
    window = np.repeat(np.arange(len(first)), samples)
    return Prediction(data.time, window, q, dq, data.run.tau - departure, found.status)


def _prompt(engine: Engine, p: Floats) -> Floats:
    """Return parameter values (p,) with which no position record is late."""
    out = p.copy()
    out[list(engine.path.shifts)] = 0.0
    return out


def _departure(engine: Engine, p: Floats, data: Conditioned, times: Floats) -> Floats:
    """Return what a recording tells of its residual at ``times`` (N, n): above the analysis cutoff, it is noise.

    Near an end the motion's own filter sees one side alone, and the acceleration that it gives there is none: until it
    has died down, in two thirds of the low-pass's half, the mean of the rows beside stands.
    """
    residual = Residual(engine.path, [data], columns=()).stages(data, p)["residual"]
    taps = low_pass(data.cutoff, data.sample_time)
    half = len(taps) // 2
    blind = min(2 * half // 3 + 1, (len(residual) - 1) // 2)
    told = residual[blind : len(residual) - blind]
    whole = np.pad(told, ((blind, blind), (0, 0)), "mean", stat_length=max(half, 1))
    smooth = convolve1d(whole, taps, axis=0, mode="nearest")
    if len(smooth) == len(times):
        return np.asarray(smooth)
    between = make_interp_spline(data.time, smooth, k=min(3, len(smooth) - 1), check_finite=False)
    return np.asarray(between(np.clip(times, data.time[0], data.time[-1])))


def _windows(data: Conditioned, horizon: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the first sample and the number of samples of each window."""
    count = len(data.time)
    if not 2 * data.sample_time * (1.0 - ROUNDING) <= horizon:
        found = f"{horizon:g} s"
        raise InputError("horizon is shorter than two samples", found, f"give at least {2 * data.sample_time:g} s")
    edges = np.arange(0.0, data.time[-1] - data.time[0] + 0.5 * data.sample_time, horizon)
    first = np.unique(np.round(edges / data.sample_time).astype(np.int64))
    first = first[first < count]
    return first, np.diff(np.append(first, count))


def _start_states(
    engine: Engine, p: Floats, record: LateRecord, residual: Residual, first: NDArray[np.int64]
) -> Floats:
    """Return the state (W, s) at each window's start: smoothed motion, at rest where stuck, effects carried along."""
    true = engine.forward.true_motion.map(len(first))
    values = np.repeat(p[:, None], len(first), axis=1)
    position, rate = (v.full().T for v in true(*(v.T for v in record.state(first)), values))
    carried = residual.states(record.data, p)[first, : engine.path.x.numel()]
    return np.concatenate([position, rate, carried], axis=1)


def _held(values: Floats, first: np.ndarray, samples: np.ndarray, filled: np.ndarray, recorded: Floats) -> Floats:
    """Return the rows with each window's unreached ones held at its last reached one, or at its first recorded one."""
    out = values.copy()
    start = 0
    for row, length, reached in zip(first, samples, filled, strict=True):
        if reached < length:
            last = out[start + reached - 1] if reached > 0 else recorded[row]
            out[start + reached : start + length] = last
        start += length
    return out
