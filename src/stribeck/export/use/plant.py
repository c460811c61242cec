"""An FMU as a plant: driven with fmpy, one communication step at a time."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
from fmpy.simulation import instantiate_fmu
from numpy.typing import NDArray

from stribeck.arm import load_arm
from stribeck.effects.placing import placed_effects
from stribeck.errors import InputError, StribeckError
from stribeck.export.code import RING
from stribeck.export.validate.opened import ARM, Opened, opened
from stribeck.simulate.around import Reading

Floats = NDArray[np.float64]


class FmuPlant:
    """A Co-Simulation FMU with the contract's variables.

    It must have ``tau[k]`` and ``q[k]``; ``dq[k]``, ``sliding[k]``, ``tau_friction[k]``, ``q_start[k]`` and
    ``dq_start[k]`` are used where it has them.

    Parameters
    ----------
    fmu : Opened
        Kept open as long as the plant is used.
    n : int
        Joints.
    tolerance : float
        Told to the FMU.
    """

    def __init__(self, fmu: Opened, n: int, *, tolerance: float = 1e-8) -> None:
        self._fmu, self.n, self._tolerance = fmu, n, tolerance
        _check_runs(fmu, n)
        self._numbers = {v.name: v.valueReference for v in fmu.description.modelVariables}
        self._instance: Any = None
        self._late = _late(fmu)

    @property
    def shows_velocity(self) -> bool:
        """Whether it has the outputs ``dq``."""
        return "dq[1]" in self._numbers

    def most_steps(self, sample_time: float) -> int:
        """Return the number of steps that a sample time (s) may be cut into: as many changes as its delay takes in."""
        return max(RING // (math.ceil(self._late / sample_time) + 2), 1)

    def start(self, q: Floats) -> Reading:
        """Begin at rest at time 0 in a position (n,), rad; raise `InputError` where the FMU cannot start there."""
        if "q_start[1]" not in self._numbers and q.any():
            raise InputError(
                f"{self._fmu.source}: the loop starts elsewhere than at 0, and the FMU has no q_start[1]",
                f"{q[q != 0.0][0]:g} rad",
                "start the loop at 0",
            )
        with _speaking(self._fmu.source):
            self._begin(q)
        return self._read()

    def step(self, time: float, step: float, torque: Floats) -> Reading:
        """Go on from a time (s) by a step (s) under a torque (n,), N m, that is held."""
        with _speaking(self._fmu.source):
            self._set("tau", torque)
            done = self._instance.doStep(currentCommunicationPoint=time, communicationStepSize=step)
        if done is not None and done[2] and done[3] < time + step * (1.0 - 1e-9):
            raise StribeckError(f"{self._fmu.source}: the FMU ended a step early", f"at {done[3]:g} s")
        return self._read()

    def close(self) -> None:
        """End the simulation. An FMU that has failed may refuse to terminate: that is no news by then."""
        if self._instance is not None:
            with suppress(Exception):
                self._instance.terminate()
            self._instance.freeInstance()
            self._instance = None

    def _begin(self, q: Floats) -> None:
        self.close()
        self._instance = _loaded(self._fmu)
        if self._fmu.version == 2:
            self._instance.setupExperiment(tolerance=self._tolerance, startTime=0.0)
            self._place(q)
            self._instance.enterInitializationMode()
        else:
            self._place(q)
            self._instance.enterInitializationMode(tolerance=self._tolerance, startTime=0.0)
        self._set("tau", np.zeros(self.n))
        self._instance.exitInitializationMode()

    def _place(self, q: Floats) -> None:
        if "q_start[1]" in self._numbers:
            self._set("q_start", q)
        if "dq_start[1]" in self._numbers:
            self._set("dq_start", np.zeros(self.n))

    def _set(self, name: str, values: Floats) -> None:
        numbers = [self._numbers[f"{name}[{k + 1}]"] for k in range(self.n)]
        write = self._instance.setReal if self._fmu.version == 2 else self._instance.setFloat64
        write(numbers, [float(value) for value in values])

    def _get(self, name: str) -> Floats:
        if any(f"{name}[{k + 1}]" not in self._numbers for k in range(self.n)):
            return np.full(self.n, np.nan)
        numbers = [self._numbers[f"{name}[{k + 1}]"] for k in range(self.n)]
        read = self._instance.getReal if self._fmu.version == 2 else self._instance.getFloat64
        return np.array(read(numbers), dtype=np.float64)

    def _read(self) -> Reading:
        with _speaking(self._fmu.source):
            reading = Reading(self._get("q"), self._get("dq"), self._get("sliding"), self._get("tau_friction"))
        for values, what in ((reading.q, "position"), (reading.dq, "velocity")):
            told = what == "position" or self.shows_velocity
            if told and not np.isfinite(values).all():
                raise StribeckError(f"{self._fmu.source}: the FMU gives a {what} that is not finite")
        return reading


@contextmanager
def fmu_plant(path: Path | str, n: int, *, tolerance: float = 1e-8) -> Iterator[FmuPlant]:
    """Open an FMU as a plant of n joints; its binary runs in this process."""
    here = os.getcwd()
    with opened(path) as fmu:
        plant = FmuPlant(fmu, n, tolerance=tolerance)
        try:
            yield plant
        finally:
            plant.close()
            os.chdir(here)


def joints_of(fmu: Opened) -> int:
    """Return the number of joints that an FMU has by its inputs ``tau[k]``."""
    names = {v.name for v in fmu.description.modelVariables if v.causality == "input"}
    n = 0
    while f"tau[{n + 1}]" in names:
        n += 1
    return n


def _late(fmu: Opened) -> float:
    """Return the longest time, s, that an arm inside an FMU may keep a command under way; 0 where none says so."""
    with suppress(InputError):
        placed = placed_effects(load_arm(fmu.folder / ARM)) if fmu.ours else []
        return sum(place.values.get("time", 0.0) for place in placed if place.effect.delays)
    return 0.0


def _check_runs(fmu: Opened, n: int) -> None:
    if fmu.description is None:
        raise InputError(f"{fmu.source}: its description makes no sense", fmu.problems[0], "see stribeck validate-fmu")
    if fmu.version not in (2, 3):
        raise InputError(f"{fmu.source}: an FMU of another version", fmu.description.fmiVersion, "export FMI 2 or 3")
    if "CoSimulation" not in fmu.kinds:
        raise InputError(f"{fmu.source}: not for Co-Simulation", ", ".join(fmu.kinds), "export it for Co-Simulation")
    if joints_of(fmu) != n:
        what = f"{fmu.source}: the FMU must have the inputs tau[1] to tau[{n}]"
        raise InputError(what, f"{joints_of(fmu)} of that form", "give the FMU of this arm")
    outputs = {v.name for v in fmu.description.modelVariables if v.causality == "output"}
    for k in range(n):
        if f"q[{k + 1}]" not in outputs:
            raise InputError(f"{fmu.source}: the FMU has no output q[{k + 1}]", "", "name its outputs as the arm's FMU")


def _loaded(fmu: Opened) -> Any:
    """Return an instance of an FMU; raise `InputError` where its binary does not even give one."""
    try:
        return instantiate_fmu(str(fmu.folder), fmu.description, "CoSimulation")
    except Exception as error:
        why = fmu.inside(str(error.__context__ or error))  # the linker's words, which fmpy repeats
        raise InputError(f"{fmu.source}: cannot be loaded", why, "export it for this platform") from error


@contextmanager
def _speaking(source: str) -> Iterator[None]:
    """Put what fmpy raises into one line of ours."""
    try:
        yield
    except StribeckError:
        raise
    except Exception as error:
        raise StribeckError(f"{source}: the FMU failed", str(error) or type(error).__name__) from error
