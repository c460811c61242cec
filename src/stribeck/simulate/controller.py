"""The sampled controllers of a loop, compiled on their own."""

from __future__ import annotations

import ctypes
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stribeck.arm import Arm
from stribeck.compiler import build, load
from stribeck.simulate.axis import MEMORY, axes_of, check_mirrored, start_position
from stribeck.simulate.engine import Engine, path_of, pointer
from stribeck.simulate.loop import Loop
from stribeck.simulate.source import runtime_text

Floats = NDArray[np.float64]


def laws_source() -> str:
    """Return the control laws and references as C that stands alone."""
    return "#include <math.h>\n#include <string.h>\n" + runtime_text("control.h").replace('#include "solver.h"\n', "")


def controller_source() -> str:
    """Return the whole translation unit of the controllers' shared library."""
    export = "#ifdef _WIN32\n#define SB_EXPORT __declspec(dllexport)\n#else\n#define SB_EXPORT\n#endif\n"
    more = runtime_text("controller.h") + runtime_text("mirrored.h")
    return export + laws_source() + more.replace('#include "control.h"\n', "")


class Controller:
    """The sampled controllers of a loop in which every joint has one.

    Parameters
    ----------
    arm : Arm
        Nominal: its friction constants, limits and inertia are what the controllers know.
    loop : Loop
        Checked; sampled, with an entry for each joint.
    """

    def __init__(self, arm: Arm, loop: Loop) -> None:
        self.n, self.sample_time = arm.n, loop.sample_time
        self.start_position = start_position(arm, loop)
        self.axes, self._tables = axes_of(arm, loop, Engine(path_of(arm)).moved_inertia(self.start_position))
        self._memory = np.zeros(arm.n, MEMORY)
        self._first = True
        self._library.sb_controller_start(self.axes, ctypes.c_int(self.n), pointer(self._memory))

    @cached_property
    def _library(self) -> ctypes.CDLL:
        library = load(build(controller_source()))
        check_mirrored(library)
        return library

    def sample(self, time: float, q: Floats, dq: Floats) -> tuple[Floats, Floats]:
        """Return what the encoders give (n,), rad, and the torques (n,), N m, of the sample at a time.

        Parameters
        ----------
        time : float
            s; the instants must come in order, one sample time apart.
        q, dq : array (n,)
            Position, noise included, and velocity, rad and rad/s.
        """
        seen, rate = (np.array(value, dtype=np.float64, order="C") for value in (q, dq))
        torque = np.zeros(self.n)
        self._library.sb_controller_sample(
            self.axes, ctypes.c_int(self.n), pointer(self._memory), ctypes.c_double(time),
            ctypes.c_double(self.sample_time), ctypes.c_int(self._first), pointer(seen), pointer(rate),
            pointer(torque),
        )  # fmt: skip
        self._first = False
        return seen, torque

    def references(self, times: Floats) -> tuple[Floats, Floats]:
        """Return reference position and rate (M, n) at instants (M,), rad and rad/s."""
        position, rate = np.zeros((len(times), self.n)), np.zeros((len(times), self.n))
        self._library.sb_controller_references(
            self.axes, ctypes.c_int(self.n), pointer(times), ctypes.c_longlong(len(times)), pointer(position),
            pointer(rate),
        )  # fmt: skip
        return position, rate
