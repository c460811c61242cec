"""An arm's FMU against the arm's own simulator, and any other FMU against itself."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stribeck.arm import Arm, unit_at
from stribeck.errors import StribeckError
from stribeck.export.validate.apart import Trial, held_inputs, simulate_apart
from stribeck.export.validate.opened import Opened
from stribeck.simulate import Engine, path_of

Floats = NDArray[np.float64]

_ALLOWED = {"CoSimulation": 1e-8, "ModelExchange": 1e-6}  # rad, over what the simulator's own tolerance is worth
_USUAL, _REFERENCE = 1e-8, 1e-10
# CVode's errors add up to a hundred times its own, and of some arms to far more: then it is asked for less
_TOLERANCES = {"CoSimulation": (_USUAL,), "ModelExchange": (1e-9, 1e-11)}
_STEP, _DURATION = 0.01, 2.0  # s


@dataclass(frozen=True)
class Deviation:
    """How far a simulated FMU lies from the arm's own simulator.

    Attributes
    ----------
    kind : str
        Interface type.
    position : float
        Largest difference of a joint position, in ``unit``.
    events : int
        Changes of a contact mode in the simulator's motion.
    allowed : float
        What a faithful FMU may come to: an arm that magnifies the errors of the simulator's own steps, as one with
        play does, magnifies those of the FMU as well.
    unit : str
        rad, or m of a prismatic axis.
    """

    kind: str
    position: float
    events: int
    allowed: float
    unit: str = "rad"


def trial_command(engine: Engine) -> tuple[Floats, Floats]:
    """Return instants (M,) and sampled torques (M, n), N m, that make every joint stick, break away and reverse.

    They swing about the torque that holds the arm where it starts: one that falls never sticks.
    """
    arm, n = engine.path.arm, engine.n
    times = _STEP * np.arange(round(_DURATION / _STEP) + 1, dtype=np.float64)
    level = np.array([max(j.friction.C0 + j.friction.C1, j.backward.C0 + j.backward.C1) for j in arm.joints])
    inertia = engine.moved_inertia(np.zeros(n))
    size = 1.6 * level + 2.0 * inertia  # the second part moves a joint without friction
    frequency = 0.7 + 0.45 * np.arange(n)  # Hz
    command: Floats = _holding(engine) + size * np.sin(2.0 * np.pi * frequency * times[:, None] + 0.4 * np.arange(n))
    return times, command


def _holding(engine: Engine) -> Floats:
    """Return the torque (n,) that holds the arm at its start, N m: what friction would have to, without any."""
    none = np.zeros(engine.n)
    friction = engine.forward.outputs(0.0, engine.start(engine.p, none), none, none, engine.p)[2]
    return -np.asarray(friction.full().ravel(), dtype=float)


def against_simulator(fmu: Opened, arm: Arm, kind: str, library: Path | None = None) -> Deviation:
    """Simulate an arm's FMU and the arm under the same sampled torques.

    Parameters
    ----------
    fmu : Opened
    arm : Arm
        The one that the FMU holds.
    kind : str
        ``CoSimulation`` or ``ModelExchange``.
    library : path or None
        The binary to use in place of the FMU's own.

    Raises
    ------
    StribeckError
        When one of the two cannot be simulated.
    """
    engine = Engine(path_of(arm))
    times, command = trial_command(engine)
    names = range(1, arm.n + 1)
    trial = Trial(
        folder=str(fmu.folder), kind=kind, stop=float(times[-1]), interval=_STEP, tolerance=_TOLERANCES[kind][0],
        outputs=tuple(f"q[{k}]" for k in names), start_values={f"{key}[{k}]": 0.0 for k in names for key in _START},
        library=None if library is None else str(library),
    )  # fmt: skip
    inputs = held_inputs(times, command, tuple(f"tau[{k}]" for k in names))
    start = engine.start(engine.p, np.zeros(arm.n), command=command[0])  # an FMU settles under its first input
    own, rough = (engine.run(engine.p, start, times, command, tolerance=given) for given in (_REFERENCE, _USUAL))
    for run in (own, rough):
        if not run.ok:
            raise StribeckError("the arm's own simulator did not reach the end", run.status)
    allowed, apart = _ALLOWED[kind] + _apart(rough.q, own.q), np.inf
    for tolerance in _TOLERANCES[kind]:
        got, position = simulate_apart(replace(trial, tolerance=tolerance), inputs)
        if len(got) != len(times) or not np.allclose(got, times, rtol=0.0, atol=1e-9):
            raise StribeckError("the simulation did not give the instants that were asked for", f"{len(got)} of them")
        apart = _apart(position, own.q)
        if apart <= allowed:
            break
    return Deviation(kind, apart, own.event_count, allowed, unit_at("rad", arm.joints[0].kind))


_START = ("q_start", "dq_start")


def _apart(one: Floats, other: Floats) -> float:
    return float(np.max(np.abs(one - other)))


def by_itself(fmu: Opened, kind: str, library: Path | None = None) -> list[str]:
    """Simulate an FMU of any model twice with its default experiment; return the problems."""
    start, stop, step = _experiment(fmu)
    # a foreign model may ask for hours; a thousand of its steps show whether it runs
    interval = step if step > 0.0 else (stop - start) / 500.0
    stop = min(stop, start + 1000.0 * interval)
    real = ("Real", "Float64")
    outputs = [v.name for v in fmu.description.modelVariables if v.causality == "output" and v.type in real]
    scalar = tuple(v.name for v in fmu.description.modelVariables if v.name in outputs and not v.dimensions)[:200]
    trial = Trial(
        folder=str(fmu.folder), kind=kind, start=start, stop=stop, interval=interval, outputs=scalar,
        library=None if library is None else str(library),
    )  # fmt: skip
    first, second = simulate_apart(trial), simulate_apart(trial)
    problems = []
    if first[0][-1] < stop - 1.001 * interval:  # a step that does not fit any more is left out
        problems.append(f"{kind} ended at {first[0][-1]:g} s instead of {stop:g} s")
    bad = [name for k, name in enumerate(scalar) if not np.isfinite(first[1][:, k]).all()]
    if bad:
        problems.append(f"{kind} gives values of {bad[0]} that are not finite")
    if first[1].shape != second[1].shape or first[1].tobytes() != second[1].tobytes():
        problems.append(f"{kind} gives another result when it is simulated a second time")
    return problems


def _experiment(fmu: Opened) -> tuple[float, float, float]:
    """Return start, stop and step (0 where there is none) of the default experiment, s."""
    experiment = fmu.description.defaultExperiment
    found: list[float] = []
    for name, usual in (("startTime", 0.0), ("stopTime", None), ("stepSize", 0.0)):
        text = getattr(experiment, name, None)
        try:
            value = found[0] + 1.0 if usual is None else usual
            found.append(value if text is None else float(text))
        except ValueError as error:
            raise StribeckError(f"DefaultExperiment: {name} is not a number", str(text)) from error
    start, stop, step = found
    if not (np.isfinite(found).all() and stop > start and step >= 0.0):
        raise StribeckError("DefaultExperiment makes no sense", f"{start:g} s to {stop:g} s in steps of {step:g} s")
    return start, stop, step
