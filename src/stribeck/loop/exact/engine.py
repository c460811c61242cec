"""The engine of an arm for rounds of loops around it, and how the arm resists from place to place."""

from __future__ import annotations

import ctypes
from functools import cached_property
from importlib.resources import files

import numpy as np
from numpy.typing import NDArray

from stribeck.arm import Arm
from stribeck.compiler import build, load
from stribeck.loop.exact.wish import check_rounds
from stribeck.model.effect import ExternalEffect
from stribeck.simulate import Engine, path_of
from stribeck.simulate.axis import check_mirrored
from stribeck.simulate.source import library_source

Floats = NDArray[np.float64]

_SOMEWHERE, _SOME_RATE, _TURNED = 0.3, 0.7, (0.37, 1.1, 2.9)  # rad, rad/s: to see whether one place is as another


class RoundsEngine(Engine):
    """The engine of an arm, with the runtime of rounds.

    Parameters
    ----------
    arm : Arm
        With the effects of its file.
    """

    def __init__(self, arm: Arm) -> None:
        super().__init__(path_of(arm))
        self.arm = arm

    @cached_property
    def driven(self) -> bool:
        """Whether time itself moves the arm."""
        return self.forward.driven

    @cached_property
    def meets(self) -> bool:
        """Whether something stands around the arm, which it meets at one place and not at another."""
        return any(isinstance(place.effect, ExternalEffect) for place in self.path.placed)

    @cached_property
    def varies(self) -> tuple[bool, ...]:
        """Whether each joint (n) is resisted differently from place to place, as by gravity, a spring or a wall."""
        return tuple(self.meets or self._differs(j) for j in range(self.n))

    def _differs(self, j: int) -> bool:
        """Tell whether the arm moves, or is measured, differently where a joint has been turned on."""
        pose, rate, modes = np.full(self.n, _SOMEWHERE), np.full(self.n, _SOME_RATE), np.ones(self.n)

        def seen(turned: float) -> Floats:
            q = pose + turned * (np.arange(self.n) == j)
            state = self.start(self.p, q, rate)
            flow = self.forward.flow(0.0, state, modes, np.zeros(self.n), self.p)
            return np.concatenate([state[: self.n] - q, *(part.full().ravel() for part in flow)])

        here = seen(0.0)
        return any(not np.allclose(seen(turned), here, rtol=1e-9, atol=1e-12) for turned in _TURNED)

    @cached_property
    def rounds_library(self) -> ctypes.CDLL:
        """The compiled library."""
        text = (files("stribeck.loop.exact") / "c" / "rounds.h").read_text(encoding="utf-8")
        library = load(build(library_source(self.forward) + text))
        check_mirrored(library)
        check_rounds(library)
        return library
