"""Export a loop's sampled controllers as an FMU for Co-Simulation."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from stribeck.arm import Arm
from stribeck.errors import InputError
from stribeck.export.archive import write_archive
from stribeck.export.build import platforms_named
from stribeck.export.controller.code import sources
from stribeck.export.controller.variables import structure_of, variables_of
from stribeck.export.documents import Description, render
from stribeck.export.shared import check_version, compiled
from stribeck.export.variable import Variable
from stribeck.simulate import Engine, Loop, check_loop, path_of
from stribeck.simulate.axis import axes_of, start_position

IDENTIFIER = "controller"


def export_controller(
    arm: Arm, loop: Loop, out: Path, *, fmi: int = 2, platforms: Sequence[str] | None = None
) -> tuple[Variable, ...]:
    """Write the sampled controllers of a loop, references included, as an FMU.

    Parameters
    ----------
    arm : Arm
        Nominal: what the controllers know.
    loop : Loop
        Sampled, with a controller for each joint.
    out : path
        The file to write, whole or not at all.
    fmi : int
        2 or 3.
    platforms : sequence of str or None
        As in `stribeck.export.export_fmu`.

    Returns
    -------
    tuple of Variable
        Those of the FMU: inputs ``q[k]``, ``dq[k]``, outputs ``tau[k]``, ``q_ref[k]``, ``dq_ref[k]``, parameters.

    Raises
    ------
    InputError
        For what a controller cannot carry: continuous control, clamped joints, a drive's lag, the encoder's noise.

    Notes
    -----
    A communication step from t to t + h takes the samples in [t, t + h) from the inputs at its beginning. So a master
    that steps the controller first, then the arm, loses no time; one that steps both at once delays every torque by
    one communication step.
    """
    check_version(fmi)
    targets = platforms_named(platforms)
    description, texts = describe(arm, loop, fmi)
    content = compiled(texts, IDENTIFIER, fmi, targets)
    content["modelDescription.xml"] = render(f"fmi{fmi}.xml", description, fmi)
    if fmi == 3:
        content["sources/buildDescription.xml"] = render("buildDescription.xml", description, fmi)
    write_archive(content, Path(out))
    return description.variables


def describe(arm: Arm, loop: Loop, fmi: int) -> tuple[Description, dict[str, str]]:
    """Return what describes the FMU of a loop's controllers, and its sources by file name."""
    check_controller(arm, loop)
    inertia = Engine(path_of(arm)).moved_inertia(start_position(arm, loop))
    array, kept = axes_of(arm, loop, inertia)
    axes = [array[j] for j in range(arm.n)]
    tables = {entry.joint: table for entry, table in zip(loop.joints, kept, strict=True)}
    token, texts = sources(loop.sample_time, axes, [tables[name] for name in arm.names], fmi)
    variables = variables_of(arm, loop.sample_time, axes)
    description = Description(
        f"controller of {arm.name}", f"sampled controllers, every {loop.sample_time:g} s", token, IDENTIFIER,
        variables, structure_of(variables), "a sampled controller has no continuous states", loop.duration,
        loop.sample_time, integrates=False,
    )  # fmt: skip
    return description, texts


def check_controller(arm: Arm, loop: Loop) -> None:
    """Raise `InputError` where a loop's controllers cannot be an FMU."""
    check_loop(loop, arm)
    if loop.sample_time == 0.0:
        raise InputError("a continuous controller is no FMU of ours", "sample_time = 0", "give a sample_time above 0")
    free = [name for name in arm.names if name not in {entry.joint for entry in loop.joints}]
    if free:
        raise InputError("a controller FMU cannot hold a joint still", free[0], "give that joint a controller")
    for entry in loop.joints:
        if entry.actuator_lag > 0.0:
            do = "put the effect actuator_lag into the arm file"
            raise InputError("a drive's lag belongs to the arm's FMU", f"joint {entry.joint}", do)
        if entry.encoder_noise > 0.0:
            raise InputError("a controller FMU makes no noise", f"joint {entry.joint}", "set encoder_noise = 0")
