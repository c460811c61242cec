"""One joint's answer: the rest or the cycle on which its loop settles."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

Verdict = Literal["rest", "stick_slip", "hunting", "sliding_cycle", "chatter", "unbounded", "undetermined"]
VERDICTS: tuple[Verdict, ...] = get_args(Verdict)
WORDS: dict[str, str] = {"stick_slip": "stick-slip", "sliding_cycle": "a sliding cycle"}  # others are their own
STEADY, RIPPLE = "steady sliding", "a forced ripple"  # rest along a ramp; a sliding cycle that the arm's waves force
FORCED = "a forced motion"  # any cycle in time with a dither
STOPPED = {  # what ends a simulation, in words
    "unbounded": "it grows without bound",
    "too_many_events": "it sticks and slips too often to be followed further",
    "step_too_small": "its motion is too abrupt to be followed further",
    "too_many_steps": "its motion is too fast or too stiff to be followed further",
    "not_finite": "its motion is no longer a number",
}
CYCLES: frozenset[str] = frozenset({"stick_slip", "hunting", "sliding_cycle", "chatter"})


@dataclass(frozen=True)
class CycleTrace:
    """One period of a cycle, M instants.

    Attributes
    ----------
    time : array (M,)
        s from the period's begin.
    position : array (M,)
        Measured, less the reference, rad.
    velocity : array (M,)
        rad/s.
    stuck : array (M,) of bool
        Where the joint sticks.
    """

    time: Floats
    position: Floats
    velocity: Floats
    stuck: NDArray[np.bool_]


@dataclass(frozen=True)
class Cycle:
    """The long-term motion of one joint under its loop.

    Attributes
    ----------
    verdict : str
        ``rest`` (the error settles, on the way of a moving reference too); ``stick_slip`` (a cycle with sticking
        along a moving reference), ``hunting`` (the same about a fixed one), ``sliding_cycle`` (one that never sticks),
        ``chatter`` (a cycle of a few samples); ``unbounded``; ``undetermined`` (``status`` says why).
    amplitude : float or None
        Half the peak-to-peak measured position (of the error, where the reference moves), rad; None where there is no
        cycle. Where the motion repeats only after several rounds, as under a sampled controller, the mean over them.
    period : float or None
        s.
    peak_velocity : float or None
        rad/s.
    stick_fraction : float or None
        Share of the time stuck.
    multipliers : tuple of complex
        Eigenvalues of the return map's derivative, largest first; real ones are given as floats. Where a sampled loop
        repeats after several rounds, the size of one round's share; where it is not known to, mean rates of growth.
    stable : bool or None
        Whether all of them lie inside the unit circle; None without any. Where they do not, samples may still hold a
        lasting motion together: a joint that sticks lets go at one of them.
    steady_error : float or None
        Reference less measured position at rest, rad; None where it does not come to rest.
    status : str
        ``ok``, or what kept the method from more.
    trace : CycleTrace or None
        One period.
    basin : mapping
        Verdict from each start that was tried: ``own`` (the loop file's), ``small``, ``large``.
    left : bool
        Whether the joint is undetermined because it is left behind for good, which ``status`` says.
    """

    verdict: Verdict
    amplitude: float | None = None
    period: float | None = None
    peak_velocity: float | None = None
    stick_fraction: float | None = None
    multipliers: tuple[float | complex, ...] = ()
    stable: bool | None = None
    steady_error: float | None = None
    status: str = "ok"
    trace: CycleTrace | None = None
    basin: Mapping[str, Verdict] = field(default_factory=dict)
    left: bool = False

    @property
    def cycles(self) -> bool:
        """Whether it is a cycle."""
        return self.verdict in CYCLES
