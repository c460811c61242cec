"""Across what a symptom shows: the residual of re-tuned models over the signals that effects name in ``shows``."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from _symptom_cases import Case
from _symptom_records import record_symptom
from _symptom_values import Array, Points, Symptom
from scipy.signal import welch

from stribeck.gap.records.prepare import Prepared
from stribeck.identify.conditioning import Conditioned
from stribeck.identify.residual import Residual
from stribeck.model.effect import Effect
from stribeck.model.path import SignalPath

PAUSE = 0.5  # s, drawn between two runs
AROUND = 0.25  # s, before and after a start
REST = 1e-4  # rad, the least distance that is drawn
Read = Callable[[Conditioned, Array], Array]


def _column(name: str) -> Read:
    return lambda run, load: np.asarray(getattr(run, name)[run.analysis_index, 0])


def _command(run: Conditioned, load: Array) -> Array:
    return run.filtered(run.command)[:, 0]


def _rate(run: Conditioned, load: Array) -> Array:
    return np.gradient(_command(run, load), run.time[run.analysis_index])


def _since_start(run: Conditioned, load: Array) -> Array:
    moving = run.stuck[:, 0] < 0.5
    return _since(run, run.time[np.flatnonzero(np.diff(moving.astype(int)) == 1) + 1])


def _since_load_turned(run: Conditioned, load: Array) -> Array:
    return _since(run, run.time[run.analysis_index][np.flatnonzero(np.diff(np.sign(load))) + 1])


def _since(run: Conditioned, events: Array) -> Array:
    """Return the time since the nearest event (s), negative before it; not a number where none is near."""
    if len(events) == 0:
        return np.full(len(run.analysis_index), np.nan)
    away = run.time[run.analysis_index][:, None] - events
    nearest = away[np.arange(len(away)), np.argmin(np.abs(away), axis=1)]
    return np.where(np.abs(nearest) < AROUND, nearest, np.nan)


def _travel(run: Conditioned, load: Array) -> Array:
    """Return the distance since the joint last turned or stood still, rad."""
    moving = np.where(run.stuck[:, 0] > 0.5, 0.0, np.sign(run.velocity[:, 0]))
    starts = np.flatnonzero(np.diff(moving, prepend=0.0))
    last = np.zeros(len(moving), dtype=int)
    last[starts] = starts
    last = np.maximum.accumulate(last)
    return np.maximum(np.abs(run.position[:, 0] - run.position[last, 0]), REST)[run.analysis_index]


ACROSS: Mapping[str, tuple[str, Read]] = {
    "position": ("position, rad", _column("position")),
    "velocity": ("velocity, rad/s", _column("velocity")),
    "acceleration": ("acceleration, rad/s²", _column("acceleration")),
    "command": ("command, N m", _command),
    "command rate": ("rate of the command, N m/s", _rate),
    "load": ("load, handed to the link, N m", lambda run, load: load),
    "load reversal": ("since the load changed its sign, s", _since_load_turned),
    "start": ("since the joint began to move, s", _since_start),
    "travel": ("distance since the last reversal, rad", _travel),
}


def symptom_of(effect: Effect, case: Case) -> Symptom:
    """Return the points in which an effect's symptom shows, across the signal that its class names."""
    if effect.direct:
        return record_symptom(effect, case)
    assert case.named is not None
    left, right = case.without.fit.residual[:, 0], case.retuned.fit.residual[:, 0]
    law = right - case.named.fit.residual[:, 0]
    if effect.shows == "frequency":
        return _spectra(case, left, right, law)
    if effect.shows == "time":
        x = [_after_each_other(runs) for runs in (case.bare, case.runs)]
        label = "time, runs one after the other, s"
    else:
        label, read = ACROSS[effect.shows]
        x = [_read(runs, p, read) for runs, p in ((case.bare, case.without.fit.p), (case.runs, case.retuned.fit.p))]
    speeding = effect.shows == "velocity"  # whose sign the axis shows already
    sides = ("speeding up", "slowing down") if speeding else ("forward", "backward")
    side = [_sides(runs, effect.shows) for runs in (case.bare, case.runs)]
    axes = {"travel": "log x", "velocity": "root x"}.get(effect.shows, "linear")
    return Symptom(
        Points(x[0], left, None, side[0]), Points(x[1], right, law, side[1]), label, "residual, N m", sides, axes,
        whole=effect.shows == "time",
    )  # fmt: skip


def _read(runs: Prepared, p: Array, read: Read) -> Array:
    residual = Residual(SignalPath(runs.arm), runs.fit, ())
    loads = [run.filtered(residual.stages(run, p)["load"])[:, 0] for run in runs.fit]
    return np.concatenate([read(run, load) for run, load in zip(runs.fit, loads, strict=True)])


def _sides(runs: Prepared, shows: str) -> Array:
    """Return 1 and -1 by direction, or by speeding up and slowing down; 0 at rest, but before a start its direction."""
    parts = []
    for run in runs.fit:
        velocity = np.where(run.stuck[:, 0] > 0.5, 0.0, run.velocity[:, 0])
        side = np.sign(velocity * run.acceleration[:, 0]) if shows == "velocity" else np.sign(velocity)
        if shows == "start":
            moving = np.append(np.flatnonzero(side), len(side) - 1)
            side = side[moving[np.searchsorted(moving[:-1], np.arange(len(side)))]]
        parts.append(side[run.analysis_index])
    return np.concatenate(parts)


def _after_each_other(runs: Prepared) -> Array:
    parts, start = [], 0.0
    for run in runs.fit:
        parts.append(start + run.time[run.analysis_index] - run.time[0])
        start += run.time[-1] - run.time[0] + PAUSE
    return np.concatenate(parts)


def _spectra(case: Case, left: Array, right: Array, law: Array) -> Symptom:
    def spectrum(runs: Prepared, values: Array) -> tuple[Array, Array]:
        ends = np.cumsum([len(run.analysis_index) for run in runs.fit])[:-1]
        rate = 1.0 / (runs.fit[0].decimation * runs.fit[0].sample_time)
        found = [welch(part, rate, nperseg=min(256, len(part)), detrend=False) for part in np.split(values, ends)]
        keep = (found[0][0] > 0.0) & (found[0][0] < runs.cutoff)
        return found[0][0][keep], np.sqrt(np.mean([power for _, power in found], axis=0))[keep]

    f0, bare = spectrum(case.bare, left)
    f1, seen = spectrum(case.runs, right)
    same = np.ones_like
    return Symptom(
        Points(f0, bare, None, same(f0)), Points(f1, seen, spectrum(case.runs, law)[1], same(f1)),
        "frequency, Hz", "residual, N m/√Hz", None, "log y", joined=True,
    )  # fmt: skip


def sizes(case: Case, symptom: Symptom) -> dict[str, float]:
    """Return the rms without the effect, with it, and with its law taken off: of the residual, or of the record."""
    if case.named is None:
        assert symptom.with_it.law is not None
        found = symptom.without.y, symptom.with_it.y, symptom.with_it.y - symptom.with_it.law
    else:
        found = case.without.fit.residual, case.retuned.fit.residual, case.named.fit.residual
    return dict(zip(("without", "with", "left"), (float(np.sqrt(np.mean(v**2))) for v in found), strict=True))
