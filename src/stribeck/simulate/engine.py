"""The compiled engine of one signal path."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stribeck.arm import Arm
from stribeck.compiler import build, load
from stribeck.effects.placing import acting_effects, placed_effects, vanishes
from stribeck.errors import InputError, StribeckError
from stribeck.model.effect import TransmissionEffect
from stribeck.model.forward import Forward
from stribeck.model.layout import Placed, values_of
from stribeck.model.path import SignalPath
from stribeck.simulate.axis import check_mirrored
from stribeck.simulate.motion import BOUND, EVENT, STATUS, Trajectory, Windows
from stribeck.simulate.source import library_source

Floats = NDArray[np.float64]


def path_of(arm: Arm) -> SignalPath:
    """Return an arm's signal path with the effects of its file, without those at their null value or of records alone.

    Raises
    ------
    InputError
        When a motor without inertia is to turn between a drive and a spring.
    """
    placed = simulated(arm)
    for place in placed:
        if isinstance(place.effect, TransmissionEffect) and arm.joints[place.joint].rotor_inertia == 0.0:
            what = f"arm {arm.name!r}: {place.effect.name} needs a rotor between motor and link"
            raise InputError(what, f"{arm.names[place.joint]}.rotor_inertia = 0", "give one")
    return SignalPath(arm, placed)


def simulated(arm: Arm) -> list[Placed]:
    """Return the effects of an arm's file that a simulation of it has."""
    return [place for place in acting_effects(arm) if not place.effect.direct]


def left_out(arm: Arm, instead: str = "the loop file says what its controllers are given") -> list[str]:
    """Return a warning for each effect of an arm's file that the records alone show: no simulation has it.

    ``instead`` says where what it does to a controller belongs.
    """
    direct = (place for place in acting_effects(arm) if place.effect.direct)
    return [
        f"{arm.names[place.joint]}: {place.effect.name} is of records alone and left out here; {instead}"
        for place in direct
    ]


def left_at_null(arm: Arm) -> list[str]:
    """Return a warning for each effect of an arm's file that its values make vanish: an FMU has no parameters of it."""
    gone = (place for place in placed_effects(arm) if vanishes(place))
    return [
        f"{arm.names[place.joint]}: {place.effect.name} is at its null value and left out here, parameters and all; "
        "to tune them, give another value"
        for place in gone
    ]


class Engine:
    """Forward simulation of a signal path, compiled when first used.

    Parameters
    ----------
    path : SignalPath
    """

    def __init__(self, path: SignalPath) -> None:
        self.path, self.n = path, path.n
        self.forward = Forward(path)
        self.size = self.forward.size

    @property
    def p(self) -> Floats:
        """The path's own parameter values (p,)."""
        return values_of(self.path.entries)

    @cached_property
    def library(self) -> ctypes.CDLL:
        """The compiled library."""
        library = load(build(library_source(self.forward)))
        check_mirrored(library)
        return library

    def moved_inertia(self, q: Floats) -> Floats:
        """Return the inertia (n,) that each joint moves in a recorded pose (n,), the others held, kg m^2."""
        true, _ = self.forward.true_motion(q, np.zeros(self.n), self.p)
        return np.asarray(self.forward.inertia(true, self.p).full().ravel(), dtype=float)

    def measured(self, state: Floats) -> Floats:
        """Return the positions (n,) that the sensors give in a state (s,), rad."""
        seen = self.forward.outputs(0.0, state, np.zeros(self.n), np.zeros(self.n), self.p)[0]
        return np.asarray(seen.full().ravel(), dtype=float)

    def start(self, p: Floats, q: Floats, dq: Floats | None = None, command: Floats | None = None) -> Floats:
        """Return the state (s,) of an arm at a recorded position and velocity (n,), effects settled.

        Parameters
        ----------
        p : array (p,)
        q, dq : array (n,)
            As the sensor gives them, rad and rad/s; at rest without ``dq``.
        command : array (n,)
            Torque in force, N m; zero without.
        """
        rate = np.zeros(self.n) if dq is None else np.asarray(dq, dtype=float)
        torque = np.zeros(self.n) if command is None else np.asarray(command, dtype=float)
        true = self.forward.true_motion(q, rate, p)
        parts = [*true, self.forward.settled(q, rate, torque, p)]
        return np.concatenate([part.full().ravel() for part in parts])

    def run(
        self,
        p: Floats,
        state: Floats,
        times: Floats,
        command: Floats,
        *,
        modes: Floats | None = None,
        tolerance: float = 1e-8,
        most_events: int = 10_000,
    ) -> Trajectory:
        """Simulate from a state under a sampled command.

        Parameters
        ----------
        p : array (p,)
            Parameter values.
        state : array (s,)
            At ``times[0]``.
        times : array (M,)
            Instants of the samples, s.
        command : array (M, n)
            Torque held from each instant to the next, N m.
        modes : array (n,) or None
            Contact modes so far; they matter only in that rest is preferred.
        tolerance : float
            Of one step's error, relative and absolute.
        most_events : int
            So many are kept.
        """
        log = np.zeros(most_events, dtype=EVENT)
        first, samples = np.zeros(1, dtype=np.int64), np.full(1, len(times), dtype=np.int64)
        signals, mode, states, info = self._call(
            p, times, command, first, samples, np.atleast_2d(state), modes, tolerance, log, states_out=True
        )
        return Trajectory.of(np.asarray(times, dtype=float), signals, mode, states, log, info[0])

    def windows(
        self,
        p: Floats,
        states: Floats,
        times: Floats,
        command: Floats,
        first: Sequence[int] | np.ndarray,
        samples: Sequence[int] | np.ndarray,
        *,
        tolerance: float = 1e-6,
    ) -> Windows:
        """Simulate W windows, each from its own state, in one call.

        Parameters
        ----------
        p : array (p,)
        states : array (W, s)
            At ``times[first]``.
        times, command : array (N,), (N, n)
            Of the whole recording; a delay looks back before a window's start.
        first, samples : array (W,) of int
            First sample and number of samples of each window.
        tolerance : float
            Of one step's error, relative and absolute.
        """
        starts, lengths = (np.ascontiguousarray(v, dtype=np.int64) for v in (first, samples))
        if len(starts) and (starts.min() < 0 or lengths.min() < 1 or (starts + lengths).max() > len(times)):
            raise StribeckError("a window passes the end of the recording")
        signals, modes, _, info = self._call(p, times, command, starts, lengths, states, None, tolerance, None)
        return Windows(
            q=signals[:, 0],
            dq=signals[:, 1],
            modes=modes,
            friction=signals[:, 2],
            samples=lengths,
            filled=info[:, 1].copy(),
            status=tuple(STATUS[int(code)] for code in info[:, 0]),
        )

    def fixed_steps(
        self, p: Floats, state: Floats, modes: Floats, command: Floats, step: float, steps: int, *, implicit: bool
    ) -> Floats:
        """Return the state (s,) after steps of one size, events ignored: to show the order of either method.

        Parameters
        ----------
        p : array (p,)
        state : array (s,)
            At the start.
        modes : array (n,)
            Contact modes, which stay.
        command : array (n,)
            Torque in force, N m.
        step : float
            s.
        steps : int
            How many.
        implicit : bool
            Whether by the implicit method.
        """
        y = array_of(state, (self.size,), "state").copy()
        code = self.library.sb_fixed(
            pointer(array_of(p, (len(self.path.entries),), "p")), ctypes.c_int(implicit), ctypes.c_double(step),
            ctypes.c_longlong(steps), pointer(y), pointer(array_of(modes, (self.n,), "modes")),
            pointer(array_of(command, (self.n,), "command")),
        )  # fmt: skip
        if code != 0:
            raise StribeckError("fixed steps failed", STATUS[code], "take smaller steps")
        return y

    def _call(
        self, p: Floats, times: Floats, command: Floats, first: np.ndarray, samples: np.ndarray, states: Floats,
        modes: Floats | None, tolerance: float, log: np.ndarray | None, *, states_out: bool = False,
    ) -> tuple[Floats, Floats, Floats, np.ndarray]:  # fmt: skip
        p, times = array_of(p, (len(self.path.entries),), "p"), array_of(times, (len(times),), "times")
        command = array_of(command, (len(times), self.n), "command")
        y = array_of(states, (len(first), self.size), "state")
        mode = None if modes is None else array_of(np.atleast_2d(modes), (len(first), self.n), "modes")
        rows = int(samples.sum())
        signals, mode_out = np.full((rows, 6, self.n), np.nan), np.full((rows, self.n), np.nan)
        kept = np.full((rows, self.size), np.nan) if states_out else np.zeros((0, self.size))
        info = np.zeros((len(first), 4), dtype=np.int64)
        self.library.sb_windows(
            pointer(p), ctypes.c_double(tolerance), ctypes.c_double(BOUND), pointer(times), pointer(command),
            ctypes.c_longlong(len(times)), ctypes.c_longlong(len(first)), pointer(first), pointer(samples),
            pointer(y), pointer(mode), pointer(signals), pointer(mode_out),
            pointer(kept if kept.size else None), pointer(info), pointer(log),
            ctypes.c_longlong(0 if log is None else len(log)),
        )  # fmt: skip
        return signals, mode_out, kept, info


def array_of(values: Floats, shape: tuple[int, ...], name: str) -> Floats:
    """Return values as C wants them; raise `StribeckError` where their shape is another."""
    array = np.ascontiguousarray(values, dtype=np.float64)
    if array.shape != shape:
        raise StribeckError(f"{name} must have shape {shape}", str(array.shape))
    return array


def pointer(array: np.ndarray | None) -> ctypes.c_void_p:
    """Return the address of an array's data, or NULL."""
    return ctypes.c_void_p(None if array is None else array.ctypes.data)
