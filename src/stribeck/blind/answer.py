"""One case: from its files to the diagnoser's answer, with nothing else at hand."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from stribeck.arm import Arm, arm_to_toml, load_arm
from stribeck.blind.files import Names, checked, parse_json
from stribeck.blind.source import code_digest
from stribeck.errors import InputError
from stribeck.run import Run, load_run
from stribeck.withheld.seal import CASE_SCHEMA, digest_of_files

Files: TypeAlias = dict[str, bytes]
NOTE = "case.json"
Diagnoser: TypeAlias = Callable[[Arm, Sequence[Run], Sequence[str]], Mapping[str, Any]]


@dataclass(frozen=True)
class _Note:
    leave_out: Names


def diagnosed(arm: Arm, runs: Sequence[Run], leave_out: Sequence[str]) -> dict[str, Any]:
    """Return the answer of this package: ``diagnosis`` (as in ``diagnosis.json``), ``retuned`` and ``corrected`` arms.

    Parameters
    ----------
    arm : Arm
        The nominal arm.
    runs : sequence of Run
    leave_out : sequence of str
        Effects that are no candidates.
    """
    from stribeck.effects.registry import registry
    from stribeck.gap import diagnose
    from stribeck.gap.answer.files import diagnosis_json

    found = diagnose(arm, runs, seed=0, jobs=1, leave_out=[name for name in leave_out if name in registry()])
    return {
        "diagnosis": diagnosis_json(found),
        "retuned": arm_to_toml(found.models["retuned"]),
        "corrected": arm_to_toml(found.models["corrected"]),
    }


def answer_case(files: Files, diagnoser: Diagnoser = diagnosed, leave_out: Sequence[str] = ()) -> dict[str, Any]:
    """Return the answer to one case; a failure is an answer like others, not the end of the batch.

    Parameters
    ----------
    files : dict of str to bytes
        ``arm.toml``, ``case.json`` and the runs. Contents, not paths: a process elsewhere has no use for those.
    diagnoser : callable
        (arm, runs, effects left out) to ``diagnosis``, ``retuned`` and ``corrected``.
    leave_out : sequence of str
        Effects withheld from the library, beside those that the case asks to withhold.

    Returns
    -------
    dict
        The diagnoser's, or ``error``; with ``files`` (digest of what was read), ``leave_out``, ``code`` (digest of the
        source), ``seconds`` and ``processor_seconds``.
    """
    started, busy = time.perf_counter(), time.process_time()
    without = sorted({*leave_out, *left_out_of(files)})
    try:
        arm, runs = _loaded(files)
        answer = dict(diagnoser(arm, runs, without))
    except Exception as error:
        answer = {"error": f"{type(error).__name__}: {error}"}
    spent = {
        "seconds": round(time.perf_counter() - started, 3),
        "processor_seconds": round(time.process_time() - busy, 3),
    }
    read = {"files": digest_of_files(files), "leave_out": without}
    return {**answer, **read, "code": code_digest(), **spent}


def left_out_of(files: Files, case: Path = Path()) -> tuple[str, ...]:
    """Return the names that a `case`, known by its folder, asks to withhold from the library."""
    if NOTE not in files:
        raise InputError(f"{case}: not a sealed case", f"no {NOTE}", "remove it, or record the cases anew")
    note = parse_json(files[NOTE], case / NOTE, CASE_SCHEMA, "not the note of a sealed case; record the cases anew")
    return tuple(checked(note, _Note, case / NOTE)["leave_out"])


def _loaded(files: Files) -> tuple[Arm, list[Run]]:
    with tempfile.TemporaryDirectory(prefix="stribeck-") as name:
        folder = Path(name)
        for file, content in files.items():
            (folder / Path(file).name).write_bytes(content)
        arm = load_arm(folder / "arm.toml")
        return arm, [load_run(path, arm.n, arm.kinds) for path in sorted(folder.glob("run_*.csv"))]
