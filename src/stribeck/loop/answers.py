"""What an analysis of a loop says: every method's answer for every joint, as frozen values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stribeck.loop.cycle import Cycle
from stribeck.loop.describing import Root
from stribeck.loop.linear import KpMax, Margins
from stribeck.loop.maps import Map
from stribeck.loop.ripple import Passage, forced_by
from stribeck.simulate import Closed, JointLoop

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Method:
    """One method's answer beside the others.

    Attributes
    ----------
    status : str
        ``ok``; ``not_applicable``, ``sticks``, ``not_converged`` and others, for which ``why`` gives the reason.
    cycle : bool or None
        Whether it finds a cycle; None where it has no answer.
    trusted : bool
        Whether its answer can be relied on here.
    why : str
        The reason for that, in words.
    amplitude, period : float or None
        rad and s; None where it has none.
    amplitude_error, period_error : float or None
        Relative to the exact cycle; None where there is none to compare with.
    stable : bool or None
        As the method itself says.
    """

    status: str
    cycle: bool | None
    trusted: bool
    why: str
    amplitude: float | None = None
    period: float | None = None
    amplitude_error: float | None = None
    period_error: float | None = None
    stable: bool | None = None


@dataclass(frozen=True)
class Nyquist:
    """What the describing function's intersections are read from.

    Attributes
    ----------
    omega : array (F,)
        rad/s, up to the Nyquist frequency.
    response : array (F,) of complex
        The linear part with the compensation's share, rad/(N m s).
    speed : array (V,)
        Amplitudes, rad/s.
    inverse : array (V,) of complex
        -1/N of the friction.
    roots : tuple of Root
    """

    omega: Floats
    response: Complex
    speed: Floats
    inverse: Complex
    roots: tuple[Root, ...]


@dataclass(frozen=True)
class Branch:
    """Cycles along one setting.

    Attributes
    ----------
    setting : str
        ``k`` or ``kp``.
    values : array (K,)
        1, or N m/rad.
    cycles : tuple of K Cycle
        Exact ones.
    predicted : array (K,)
        Amplitude by the describing function, rad; nan where it has none.
    """

    setting: str
    values: Floats
    cycles: tuple[Cycle, ...]
    predicted: Floats


@dataclass(frozen=True)
class Locus:
    """Poles of a joint's linear loop against its Kp, friction left out, the other loops closed.

    Attributes
    ----------
    gains : array (G,)
        N m/rad.
    poles : array (G, P) of complex
        1/s of a continuous loop; z of a sampled one.
    own : array (P,) of complex
        With the loop's own Kp.
    sample_time : float
        s; 0 is continuous.
    """

    gains: Floats
    poles: Complex
    own: Complex
    sample_time: float


@dataclass(frozen=True)
class JointAnswer:
    """All that is found for one joint.

    Attributes
    ----------
    joint, kind : str
        Its name, and ``revolute`` or ``prismatic``.
    entry : JointLoop
        Its part of the loop file.
    kv, ratio : float
        Derivative gain in force, N m s/rad, and k, which is 0 without compensation.
    inertia : float
        That the joint moves in the pose in which the loop works, the others held, kg m^2.
    cycle : Cycle
        The exact answer, or the simulation's where there is none.
    methods : mapping
        ``describing_function``, ``harmonic_balance``, ``shooting``, ``simulation``.
    k_critical : float or None
        Smallest k at which the loop does not come to rest, 0 where it does not without compensation either; at larger
        ones it may again. None where no k makes it cycle, or where the compensation is not on the measured velocity.
    k_why : str
        Which of them it is, or that the search failed, where it is None.
    fold_velocity : float or None
        Along a ramp: the speed in its direction over which the joint, released from standstill, no longer sticks
        again, rad/s.
    kp_max : KpMax
    margins : Margins
        Friction left out, the other loops closed.
    nyquist : Nyquist or None
    branch : Branch or None
    map : Map or None
    locus : Locus or None
    passages : tuple of Passage
        What may force its motion: dithers, and what the ramps of the loop lead its joints past.
    notes : tuple of str
        What a reader must know before trusting the rest.
    """

    joint: str
    kind: str
    entry: JointLoop
    kv: float
    ratio: float
    inertia: float
    cycle: Cycle
    methods: Mapping[str, Method]
    k_critical: float | None
    fold_velocity: float | None
    kp_max: KpMax
    margins: Margins
    nyquist: Nyquist | None = None
    branch: Branch | None = None
    map: Map | None = None
    notes: tuple[str, ...] = ()
    locus: Locus | None = None
    k_why: str = ""
    passages: tuple[Passage, ...] = ()

    @property
    def forced(self) -> Passage | None:
        """What forces the joint's motion; None where that is a cycle of the loop's own, or none."""
        return forced_by(self.cycle.verdict, self.cycle.period, self.passages)

    @property
    def passes(self) -> tuple[Passage, ...]:
        """What its own dither or ramp may force on the joint."""
        return tuple(each for each in self.passages if each.joint == self.joint)

    @property
    def kp(self) -> float:
        """N m/rad."""
        return self.entry.kp


@dataclass(frozen=True)
class Analysis:
    """The analysis of a loop around an arm.

    Attributes
    ----------
    arm : str
        Its name.
    sample_time, duration : float
        Of the loop file, s.
    seed : int
        Of the encoder noise.
    joints : tuple of JointAnswer
        The controlled ones.
    motion : Closed
        A simulation from the loop's own start; over several periods, and so longer than the loop file says.
    indices : tuple of int
        Of the joints in the arm.
    """

    arm: str
    sample_time: float
    duration: float
    seed: int
    joints: tuple[JointAnswer, ...]
    motion: Closed
    indices: tuple[int, ...]
