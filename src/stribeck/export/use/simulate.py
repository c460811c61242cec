"""A loop file around an FMU."""

from __future__ import annotations

from pathlib import Path

from stribeck.arm import Arm, load_arm
from stribeck.errors import InputError
from stribeck.export.use.plant import fmu_plant
from stribeck.export.validate.opened import ARM, opened
from stribeck.simulate import Closed, read_loop
from stribeck.simulate.around import close_around
from stribeck.simulate.loop import Loop


def simulate_fmu(fmu: Path | str, arm: Arm, loop: Loop, *, tolerance: float = 1e-8) -> Closed:
    """Simulate a sampled control loop around an FMU that stands in for an arm.

    Parameters
    ----------
    fmu : path
        Of a Co-Simulation FMU with the contract's variable names. Its binary runs in this process.
    arm : Arm
        Nominal: what the controllers know, and the names of the joints.
    loop : Loop
        Checked against the arm; sampled, with a controller for each joint.
    tolerance : float
        Told to the FMU.

    Raises
    ------
    InputError
        When the file is no FMU, cannot take the loop, or the loop cannot be closed from outside.
    """
    with fmu_plant(fmu, arm.n, tolerance=tolerance) as plant:
        return close_around(plant, arm, loop)


def arm_inside(fmu: Path | str) -> Arm:
    """Return the arm that an FMU of this package carries; raise `InputError` where it carries none."""
    with opened(fmu) as held:
        if not held.ours:
            raise InputError(f"{fmu}: the FMU holds no arm file", "", "give one: stribeck simulate --fmu FILE ARM LOOP")
        try:
            return load_arm(held.folder / ARM)
        except InputError as error:
            raise InputError(f"{fmu}: {held.inside(error.what)}", error.found, error.do) from error


def load_fmu_loop(fmu: Path | str, arm: Path | None, loop: Path) -> tuple[Arm, Loop, tuple[str, ...], tuple[str, ...]]:
    """Return the nominal arm, from its file or from inside the FMU, and what :func:`read_loop` returns."""
    nominal = arm_inside(fmu) if arm is None else load_arm(arm)
    return nominal, *read_loop(loop, nominal)
