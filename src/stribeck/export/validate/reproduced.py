"""Whether an arm's FMU is, byte for byte, what this version exports from the arm file inside it."""

from __future__ import annotations

import tempfile
import zipfile
from pathlib import Path

import fmpy

from stribeck.arm import Arm
from stribeck.errors import StribeckError
from stribeck.export import PLATFORMS, export_fmu
from stribeck.export.validate.opened import Opened
from stribeck.version import package_version


def reproduction(fmu: Opened, arm: Arm) -> tuple[list[str], list[str]]:
    """Export the arm again, for this platform, and compare every file.

    Returns
    -------
    problems, skipped : lists of str
        Both empty where every file is the same; binaries of other platforms are not looked at.
    """
    here = next((one for one in PLATFORMS if one.name == fmpy.platform_tuple), None)
    tool = f"stribeck {package_version()}"
    if fmu.description.generationTool != tool:
        return [], [f"reproduction: exported by {fmu.description.generationTool}, this is {tool}"]
    if here is None:
        return [], [f"reproduction: {fmpy.platform_tuple} is no platform of an export"]
    with tempfile.TemporaryDirectory(prefix="stribeck.again.") as name:
        again = Path(name) / "again.fmu"
        try:
            export_fmu(arm, again, fmi=fmu.version, platforms=[here.name])
        except StribeckError as error:
            return [f"the arm inside cannot be exported again: {error}"], []
        with zipfile.ZipFile(again) as archive:
            made = {entry: archive.read(entry) for entry in archive.namelist()}
    own = f"binaries/{here.fmi2 if fmu.version == 2 else here.name}/"
    held = any(file.startswith(own) for file in fmu.files)
    problems = []
    for file, data in made.items():
        if file.startswith(own) and not held:
            continue
        if file not in fmu.files:
            problems.append(f"{file} is missing, which this version exports")
        elif (fmu.folder / file).read_bytes() != data:
            problems.append(f"{file} differs from what this version exports from the arm inside")
    foreign = [file for file in fmu.files if file not in made and not file.startswith("binaries/")]
    return [*problems, *(f"{file} is not what this version exports" for file in foreign)], []
