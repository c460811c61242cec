"""Everything that is checked of one FMU, and what was left out."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

import fmpy

from stribeck.arm import Arm, load_arm
from stribeck.effects.placing import placed_effects
from stribeck.effects.registry import laws, registry
from stribeck.errors import StribeckError
from stribeck.export.validate.binaries import binary_problems, platform_folders
from stribeck.export.validate.compare import Deviation, against_simulator, by_itself
from stribeck.export.validate.declared import declaration_problems, unitless
from stribeck.export.validate.opened import ARM, Opened, opened
from stribeck.export.validate.reproduced import reproduction
from stribeck.export.validate.sources import build_sources

MOST_JOINTS = 8  # the search for contact modes triples with each joint


@dataclass(frozen=True)
class Validation:
    """What was found.

    Attributes
    ----------
    problems : tuple of str
        One line each.
    skipped : tuple of str
        What was not checked, and why.
    deviations : tuple of Deviation
        Of the interface types that were simulated against the arm's own simulator.
    facts : tuple of str
        What it is: version, interface types, platforms.
    """

    problems: tuple[str, ...]
    skipped: tuple[str, ...]
    deviations: tuple[Deviation, ...]
    facts: tuple[str, ...]


def validate_fmu(path: Path | str, *, run: bool = True) -> list[str]:
    """Return the problems of an FMU; see `check_fmu`."""
    return list(check_fmu(path, run=run).problems)


def check_fmu(path: Path | str, *, run: bool = True) -> Validation:
    """Check an FMU of this package or of any other origin.

    Parameters
    ----------
    path : path
    run : bool
        Simulate it too. That runs the binary that came with it, in a process of its own with bounded time and memory,
        which keeps accidents away and not malice: leave it out for a file that you do not trust. Sources that are not
        those of an export from here are compiled only then, too.

    Raises
    ------
    InputError
        When the file is no FMU, or would do harm when it is unpacked or read.
    """
    with opened(path) as fmu:
        if fmu.description is None:
            return Validation(fmu.problems, ("everything after the description",), (), ())
        found, skipped, deviations = [*fmu.problems], list[str](), list[Deviation]()
        problems, left = binary_problems(fmu)
        found += problems
        skipped += left
        arm = _arm(fmu, found)
        if arm is not None:
            declared = declaration_problems(fmu, arm)
            found += declared
            if any("is missing" in problem for problem in declared):
                skipped.append("comparison with a simulator: the arm inside is not that of the FMU")
                arm = None
            elif arm.n > MOST_JOINTS:
                skipped.append(
                    f"comparison with a simulator: it is made for up to {MOST_JOINTS} joints, these are {arm.n}"
                )
                arm = None
        else:
            why = "the arm inside cannot be used" if fmu.ours else f"the FMU holds no {ARM}"
            skipped.append(f"names of the contract, comparison with a simulator: {why}")
        bare = unitless(fmu)
        if bare:
            text = f"{len(bare)} of the real variables without a unit, {bare[0]} among them"
            (found if fmu.ours else skipped).append(text)
        again, left = ([], ["reproduction: there is no arm to build it of"]) if arm is None else reproduction(fmu, arm)
        found += again
        skipped += left
        with tempfile.TemporaryDirectory(prefix="stribeck.build.") as name:
            library = Path(name) / "built.so"
            if again or left or (run and not _held(fmu)):  # else the sources are those that have just been built
                problems, left = build_sources(fmu, library if run else None)
                found += problems
                skipped += left
            if run:
                deviations = _run(fmu, arm, library if library.exists() else None, found, skipped)
                if deviations and not any(one.events for one in deviations):
                    skipped.append("stiction: no joint stuck or broke away in the motion that was compared")
            else:
                skipped.append("simulation: not asked for")
        return Validation(tuple(found), tuple(skipped), tuple(deviations), _facts(fmu))


def _arm(fmu: Opened, found: list[str]) -> Arm | None:
    """Return the arm that an FMU holds; a file that cannot be read, or not be made a model of here, is a problem."""
    if not fmu.ours:
        return None
    try:
        arm = load_arm(fmu.folder / ARM)
        for entry in arm.effects:
            if entry.effect not in registry() or (entry.law and (entry.effect, entry.law) not in laws()):
                label = f"{entry.effect}/{entry.law}" if entry.law else entry.effect
                found.append(
                    f"{ARM} has the effect {label}, which is not installed here: the arm is left out of account"
                )
                return None
        placed_effects(arm, ARM)
    except StribeckError as error:
        found.append(fmu.inside(str(error)))
        return None
    return arm


def _run(fmu: Opened, arm: Arm | None, built: Path | None, found: list[str], skipped: list[str]) -> list[Deviation]:
    """Simulate every interface type, with the binary of this platform and with the one built from the sources."""
    deviations = []
    if fmu.version not in (2, 3):
        skipped.append(f"simulation of FMI {fmu.description.fmiVersion}")
        return []
    held = _held(fmu)
    libraries = [None] * held + ([built] if built and (not held or fmu.ours) else [])
    if not libraries:
        found.append(f"it could not be run on this machine: no binary in {_here(fmu)} and none built from sources")
    for kind in fmu.kinds:
        for library in libraries:
            origin = "" if library is None else " built from the sources"
            try:
                if arm is None:
                    found += [problem + origin for problem in by_itself(fmu, kind, library)]
                    continue
                deviation = against_simulator(fmu, arm, kind, library)
            except StribeckError as error:
                found.append(str(error) + origin)
                continue
            if not deviation.position <= deviation.allowed:
                apart = f"{deviation.position:.2g} {deviation.unit}, more than {deviation.allowed:.2g}"
                found.append(f"{kind}{origin} departs from the arm's own simulator by {apart}")
            if library is None or not held:
                deviations.append(deviation)
    return deviations


def _here(fmu: Opened) -> str:
    """Return the folder of this machine's binary."""
    return f"binaries/{fmpy.platform if fmu.version == 2 else fmpy.platform_tuple}/"


def _held(fmu: Opened) -> bool:
    """Return whether it holds a binary for this machine."""
    return any(file.startswith(_here(fmu)) for file in fmu.files)


def _facts(fmu: Opened) -> tuple[str, ...]:
    kinds = " and ".join(fmu.kinds) or "no interface type that can be simulated"
    platforms = ", ".join(platform_folders(fmu)) or "none"
    made = fmu.description.generationTool or "a tool that does not say its name"
    return (f"FMI {fmu.description.fmiVersion}, {kinds}, by {made}", f"binaries: {platforms}")
