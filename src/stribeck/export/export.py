"""Export an arm as an FMU: one file for Model Exchange and Co-Simulation on every platform."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib.resources import files
from pathlib import Path

from stribeck.arm import Arm, arm_to_toml
from stribeck.errors import InputError
from stribeck.export.archive import write_archive
from stribeck.export.build import binary, platforms_named
from stribeck.export.code import sources
from stribeck.export.documents import Description, render
from stribeck.export.structure import structure_of
from stribeck.export.universal import universal
from stribeck.export.variables import Table, table_of
from stribeck.model.forward import Forward
from stribeck.simulate.engine import path_of

DEFAULT_FMI = 2
"""FMI 2.0: every tool that imports FMUs takes it in both kinds; FMI 3.0 only the newest do."""


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
    if fmi not in (2, 3):
        raise InputError("unknown version of FMI", str(fmi), "use 2 or 3")
    if Path(out).suffix != ".fmu":
        raise InputError(f"{out}: not the name of an FMU", Path(out).suffix or "no suffix", "let it end in .fmu")
    targets = platforms_named(platforms)
    description, texts = describe(arm, fmi)
    content: dict[str, bytes | str] = {**documents(description, fmi)}
    content |= {f"sources/{name}": text for name, text in texts.items()}
    built: dict[str, list[bytes]] = {}
    for platform in targets:
        progress(f"building for {platform.name}")
        folder = platform.fmi2 if fmi == 2 else platform.name
        library = binary(texts, f"fmi{fmi}.c", description.identifier, platform)
        built.setdefault(f"binaries/{folder}/{description.identifier}{platform.suffix}", []).append(library)
    content |= {name: universal(libraries) for name, libraries in built.items()}
    write_archive(content, Path(out))
    return description.only_steps


def describe(arm: Arm, fmi: int) -> tuple[Description, dict[str, str]]:
    """Return what describes an arm's FMU, and its sources by file name."""
    path = path_of(arm)
    forward = Forward(path)
    _check_delays(forward)
    table = table_of(forward)
    only_steps = _only_steps(table)
    token, texts = sources(table, only_steps, fmi)
    return Description(arm, table, structure_of(table), token, only_steps), texts


def documents(description: Description, fmi: int) -> dict[str, bytes | str]:
    """Return the files of an FMU apart from sources and binaries."""
    folder = files("stribeck.export")
    icon = (folder / "icon.png").read_bytes()
    found: dict[str, bytes | str] = {
        "modelDescription.xml": render(f"fmi{fmi}.xml", description, fmi),
        "documentation/index.html": render("index.html", description, fmi),
        "resources/arm.toml": arm_to_toml(description.arm),
    }
    for name in ("license.txt", "fmi-headers.txt"):
        found[f"documentation/licenses/{name}"] = (folder / "licenses" / name).read_text(encoding="utf-8")
    if fmi == 2:
        return found | {"model.png": icon}
    return found | {
        "sources/buildDescription.xml": render("buildDescription.xml", description, fmi),
        "terminalsAndIcons/terminalsAndIcons.xml": render("terminalsAndIcons.xml", description, fmi),
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
