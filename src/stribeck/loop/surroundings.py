"""What lies around a joint's loop: the branch of its cycles, and the map of verdicts, the other joints held."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stribeck.arm import Arm
from stribeck.errors import InputError
from stribeck.loop.answers import Branch, Locus
from stribeck.loop.approximate import predicted_amplitudes
from stribeck.loop.exact.branch import Parameter, continue_through
from stribeck.loop.exact.engine import RoundsEngine
from stribeck.loop.exact.rounds import Rounds
from stribeck.loop.linear import Assembly, root_locus
from stribeck.loop.linear.controller import derivative_gain, tuned_inertia
from stribeck.loop.linear.gains import MOST_STATES
from stribeck.loop.linear.operating import pose
from stribeck.loop.maps import Map, Told, label_map
from stribeck.loop.maps.cells import fits
from stribeck.loop.maps.grid import Axes
from stribeck.simulate import JointLoop, Loop

Floats = NDArray[np.float64]

BRANCH = 13  # values along a branch
LOCUS, LARGE = 160, 40  # gains of a root locus; states from which on it has fewer
MOST_CELLS = 100_000  # of a joint's map; a sampled loop takes a minute or two for so many
SLOW, SLOW_WINDING = (9, 7), (5, 4)  # cells of a map that the quick kernel cannot take; and an integral winds up in it
WINDING = (25, 13, 7)  # cells of a map, and values of a branch, where an integral winds up for minutes of motion


@dataclass(frozen=True)
class Grid:
    """Cells of a joint's map.

    Attributes
    ----------
    across : int
        Values of k, or of what stands in for it.
    up : int
        Values of Kp.
    wanted : bool
        Whether there is a map at all.
    """

    across: int = 61
    up: int = 31
    wanted: bool = True

    def __post_init__(self) -> None:
        if self.wanted and not (min(self.across, self.up) >= 2 and self.across * self.up <= MOST_CELLS):
            found, do = f"{self.across} x {self.up}", f"give 2x2 at least, and at most {MOST_CELLS} cells in all"
            raise InputError("the map's grid is empty or too large", found, do)


def grid_of(text: str) -> Grid:
    """Return the grid that a user writes as ``61x31``, or as ``none``.

    Raises
    ------
    InputError
        When it is neither, or the grid is empty or too large.
    """
    if text.strip().lower() == "none":
        return Grid(wanted=False)
    parts = text.lower().split("x")
    if len(parts) != 2 or not all(part.strip().isdecimal() for part in parts):
        raise InputError("--grid must be two numbers of cells", repr(text), "write it as 61x31, or none")
    return Grid(int(parts[0]), int(parts[1]))


def alone(arm: Arm, loop: Loop, joint: str) -> Loop:
    """Return the loop of one joint, the others held in the pose in which the loop works.

    Its kv is the number in force: critical damping is that of the pose in which the whole loop starts.
    """
    held = dict(zip(arm.names, pose(arm, loop), strict=True))
    entry = _entry(loop, joint)
    kv = derivative_gain(entry, entry.kp, float(tuned_inertia(arm, loop)[arm.names.index(joint)]))
    clamp = {name: q for name, q in held.items() if name != joint}
    return replace(loop, joints=(replace(entry, kv=kv),), clamp=clamp)


def branch_of(engine: RoundsEngine, loop: Loop, joint: str, highest: float | None) -> Branch:
    """Return a joint's cycles, the others held, over k where it compensates on the measured velocity, else over Kp.

    Parameters
    ----------
    engine : RoundsEngine
        Of the arm.
    loop : Loop
    joint : str
    highest : float or None
        Largest Kp of the linear loop, N m/rad.
    """
    entry = _entry(loop, joint)
    setting = _setting(entry)
    count = WINDING[2] if entry.ki > 0.0 else BRANCH
    values = _ratios(entry, count) if setting == "k" else _gains(entry, count, highest)
    own = entry.compensation.ratio if setting == "k" else entry.kp
    values = np.sort(np.append(values[~np.isclose(values, own)], own))
    changed = [alone(engine.arm, _with(loop, entry, setting, float(value)), joint) for value in values]
    cycles = continue_through(engine, changed[::-1], joint)[::-1]  # downwards, to where cycles end
    return Branch(setting, values, tuple(cycles), predicted_amplitudes(engine.arm, changed, joint))


def map_of(
    engine: RoundsEngine, loop: Loop, joint: str, grid: Grid, highest: float | None, told: Told = lambda share: None
) -> Map:
    """Return the map of a joint over Kp and what matters most beside it: k, the ramp's velocity, Ki or damping.

    A loop that the quick kernel cannot take has a coarse map, by shooting; one with an integral, which may wind up for
    minutes between two slips, has fewer cells too.

    Parameters
    ----------
    engine : RoundsEngine
        Of the arm.
    loop : Loop
    joint : str
    grid : Grid
        Cells at most.
    highest : float or None
        Largest Kp of the linear loop, N m/rad.
    told : callable
        Is given the share of the cells that are done, now and then.
    """
    entry, single = _entry(loop, joint), alone(engine.arm, loop, joint)
    rounds, j = Rounds(engine, single), engine.arm.names.index(joint)
    slow, winding = bool(fits(rounds, joint)), entry.ki > 0.0
    quick = WINDING[:2] if winding else (grid.across, grid.up)
    most = quick if not slow else SLOW_WINDING if winding else SLOW
    across, up = min(grid.across, most[0]), min(grid.up, most[1])
    name, values = _across(entry, across)
    axes = {"kp": _gains(entry, up, highest), name: values}
    if entry.kv is None and name != "zeta":  # kv follows Kp, at the damping ratio in force
        axes["zeta"] = np.array([rounds.axes[j].kv / (2.0 * np.sqrt(entry.kp * rounds.inertia[j]))])
    return _plane(label_map(engine.arm, single, joint, axes, told=told))


def _plane(found: Map) -> Map:
    """Return a map over its first two axes, the only ones with more than one value."""
    axes, arrays = Axes(found.axes.names[:2], found.axes.values[:2]), ("codes", "amplitude", "period", "stick_fraction")
    return replace(found, axes=axes, **{name: getattr(found, name).reshape(axes.shape) for name in arrays})


def locus_of(assembly: Assembly, joint: str, highest: float | None) -> Locus | None:
    """Return the poles of a joint's loop against its Kp, from an eighth of its own to beyond the largest one.

    None where a long delay makes them too many.
    """
    if assembly.plant.nstates > MOST_STATES:
        return None
    count = LOCUS // max(assembly.plant.nstates // LARGE, 1)
    kp = assembly.entries[assembly.index(joint)].kp
    gains = np.geomspace(kp / 8.0, 8.0 * kp if highest is None else max(1.5 * highest, 2.0 * kp), count)
    return Locus(gains, np.array(root_locus(assembly, joint, gains)), assembly.poles(joint), assembly.sample_time)


def _setting(entry: JointLoop) -> Parameter:
    return "k" if entry.compensation.kind == "feedback" else "kp"


def _across(entry: JointLoop, count: int) -> tuple[str, Floats]:
    velocity = entry.reference.velocity if entry.reference.kind == "ramp" else 0.0
    if entry.compensation.kind == "feedback":
        return "k", _ratios(entry, count)
    if velocity != 0.0:
        return "velocity", np.geomspace(0.1 * velocity, 10.0 * velocity, count)
    if entry.ki > 0.0:
        return "ki", np.geomspace(0.1 * entry.ki, 10.0 * entry.ki, count)
    return "zeta", np.linspace(0.05, 1.5, count)


def _ratios(entry: JointLoop, count: int) -> Floats:
    k = entry.compensation.ratio
    return np.linspace(min(0.6, 0.8 * k), max(1.6, 1.2 * k), count)


def _gains(entry: JointLoop, count: int, highest: float | None) -> Floats:
    """Return gains around the loop's own, up to where the linear loop turns unstable."""
    top = 8.0 * entry.kp if highest is None else min(8.0 * entry.kp, 1.1 * max(highest, entry.kp))
    return np.geomspace(entry.kp / 8.0, top, count)


def _with(loop: Loop, entry: JointLoop, setting: str, value: float) -> Loop:
    """Return the loop with one joint's k or Kp replaced."""
    law = replace(entry.compensation, ratio=value)
    changed = replace(entry, kp=value) if setting == "kp" else replace(entry, compensation=law)
    return replace(loop, joints=tuple(changed if other is entry else other for other in loop.joints))


def _entry(loop: Loop, joint: str) -> JointLoop:
    return next(entry for entry in loop.joints if entry.joint == joint)
