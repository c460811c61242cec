"""Export an arm as an FMU: one file for Model Exchange and Co-Simulation on every platform."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib.resources import files
from pathlib import Path

from stribeck.arm import Arm, arm_to_toml
from stribeck.errors import InputError
from stribeck.export.archive import write_archive
from stribeck.export.build import platforms_named
from stribeck.export.code import sources
from stribeck.export.documents import Description, identifier_of, render
from stribeck.export.notes import notes_of
from stribeck.export.shared import check_version, compiled
from stribeck.export.structure import structure_of
from stribeck.export.variables import Table, table_of
from stribeck.model.forward import Forward
from stribeck.simulate.engine import path_of

DEFAULT_FMI = 2
"""FMI 2.0: every tool that imports FMUs takes it in both kinds; FMI 3.0 only the newest do."""
STOP_TIME, STEP_SIZE = 5.0, 0.01  # s, of the default experiment


def export_fmu(
    arm: Arm,
    out: Path,
    *,
    fmi: int = DEFAULT_FMI,
    platforms: Sequence[str] | None = None,
    progress: Callable[[str], None] = lambda text: None,
) -> str:
    """Write an arm, with the effects of its file, as an FMU.

    Parameters
    ----------
    arm : Arm
        Nominal or corrected.
    out : path
        The file to write, whole or not at all.
    fmi : int
        2 or 3, the version of the standard.
    platforms : sequence of str or None
        Such as ``x86_64-linux``; all seven where None.
    progress : callable
        Told what is being built.

    Returns
    -------
    str
        Why the FMU has no Model Exchange; empty where it has.

    Raises
    ------
    InputError
        When the version or a platform is not known, or a parameter asks for what no FMU can do.
    """
    check_version(fmi)
    if Path(out).suffix != ".fmu":
        raise InputError(f"{out}: not the name of an FMU", Path(out).suffix or "no suffix", "let it end in .fmu")
    targets = platforms_named(platforms)
    description, table, texts = describe(arm, fmi)
    content = documents(description, table, fmi) | compiled(texts, description.identifier, fmi, targets, progress)
    write_archive(content, Path(out))
    return description.only_steps


def describe(arm: Arm, fmi: int) -> tuple[Description, Table, dict[str, str]]:
    """Return what describes an arm's FMU, the table of its variables, and its sources by file name."""
    forward = Forward(path_of(arm))
    _check_delays(forward)
    table = table_of(forward)
    only_steps = _only_steps(table)
    token, texts = sources(table, only_steps, fmi)
    summary = f"{arm.name}: {arm.n} joint{'s' if arm.n > 1 else ''} with true stiction"
    description = Description(
        arm.name, summary, token, identifier_of(arm.name), table.variables, structure_of(table), only_steps,
        STOP_TIME, arm.sample_time or STEP_SIZE,
    )  # fmt: skip
    return description, table, texts


def documents(description: Description, table: Table, fmi: int) -> dict[str, bytes | str]:
    """Return the files of an arm's FMU apart from sources and binaries."""
    folder = files("stribeck.export")
    icon = (folder / "icon.png").read_bytes()
    forward = table.forward
    arm = forward.path.arm
    bristles = [name for name, bristle in zip(arm.names, forward.bristles, strict=True) if bristle]
    page = render(
        "index.html", description, fmi, arm=arm, effects=forward.path.placed, bristles=bristles, notes=notes_of(forward)
    )
    found: dict[str, bytes | str] = {
        "modelDescription.xml": render(f"fmi{fmi}.xml", description, fmi),
        "documentation/index.html": page,
        "resources/arm.toml": arm_to_toml(arm),
    }
    for name in ("license.txt", "fmi-headers.txt"):
        found[f"documentation/licenses/{name}"] = (folder / "licenses" / name).read_text(encoding="utf-8")
    if fmi == 2:
        return found | {"model.png": icon}
    return found | {
        "sources/buildDescription.xml": render("buildDescription.xml", description, fmi),
        "terminalsAndIcons/terminalsAndIcons.xml": render("terminalsAndIcons.xml", description, fmi, arm=arm),
        "terminalsAndIcons/icon.png": icon,
    }


def _only_steps(table: Table) -> str:
    """Say why the model cannot be exchanged: past inputs, which the importer does not keep."""
    forward = table.forward
    names = [_plain(forward.path.arm.names[joint]) for joint, _ in forward.delays]
    if not names:
        return ""
    joints = " and ".join(dict.fromkeys(names))
    return f"the pure delay at joint {joints} needs past inputs, which Model Exchange cannot carry: use Co-Simulation"


def _plain(name: str) -> str:
    """Return a name as it may stand in a string of C."""
    return "".join(c if c.isprintable() and c not in '"\\\\?%' else "_" for c in name)


def _check_delays(forward: Forward) -> None:
    entries = forward.path.entries
    for joint, place in forward.delays:
        if entries[place].value < 0.0:
            what = f"effect of joint {forward.path.arm.names[joint]}: {entries[place].key} looks ahead in time"
            raise InputError(what, f"{entries[place].value:g} s", "an FMU sees no future input: give 0 or more")
