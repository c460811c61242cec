"""Many cases into a folder of answers, one whole file a case: what is done stays done, whatever happens."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from stribeck.blind.answer import Diagnoser, Files, answer_case, diagnosed, left_out_of
from stribeck.blind.farm import Farm, Processes
from stribeck.blind.files import ANSWER_SCHEMA, SCHEMA, SETTINGS, read_answer
from stribeck.blind.source import code_digest
from stribeck.errors import InputError
from stribeck.outputs import whole_file
from stribeck.textfile import read_whole
from stribeck.version import package_version
from stribeck.withheld.seal import digest_of_files, read_digest

Progress = Callable[[str], None]


def diagnose_cases(
    cases: Path,
    out: Path,
    *,
    farm: Farm | None = None,
    leave_out: Sequence[str] = (),
    diagnoser: Diagnoser = diagnosed,
    progress: Progress = lambda text: None,
) -> int:
    """Diagnose every case of a folder that has no answer yet; return how many cases now have one.

    An answer that tells of a failure, or of other files than the case holds now, counts as none.

    Parameters
    ----------
    cases : path
        What ``withheld record`` wrote. The key is not needed, and not looked for.
    out : path
        New folder, or one in which the same work was begun: ``settings.json`` and a file a case.
    farm : Farm or None
        Where to work; two processes here where None.
    leave_out : sequence of str
        Effects withheld from the library in all cases.
    diagnoser : callable
        See :func:`stribeck.blind.answer.answer_case`.
    progress : callable
        Told in words what is being done.

    Raises
    ------
    InputError
        When `cases` are none, or one of them is none, or `out` holds answers to other cases, of other settings or by
        other code, or damaged ones.
    """
    names = case_names(cases)
    digests = {name: _checked(cases, name) for name in names}  # before hours of work, not after
    library = library_without(leave_out)
    settings = {
        "schema": SCHEMA,
        "version": package_version(),
        "code": code_digest(),
        "digest": read_digest(cases),
        "cases": len(names),
        "leave_out": sorted(leave_out),
        "library": library,
    }
    _begin(out, settings)
    left = _left(out, digests, progress)
    work = partial(answer_case, diagnoser=diagnoser, leave_out=tuple(leave_out))
    done, failed = len(names) - len(left), 0
    for name, answer in (farm or Processes()).run(work, partial(case_files, cases), left):
        write_json(out / f"{name}.json", {"schema": ANSWER_SCHEMA, "case": name, **answer})
        done += 1
        failed += "error" in answer
        progress(f"{done} of {len(names)} cases diagnosed; {name}: {_in_words(answer)}")
    if failed:
        progress(f"{failed} of {len(names)} cases failed; the same command tries them again")
    return done


def case_names(cases: Path) -> list[str]:
    """Return the names of the case folders; raise `InputError` where there are none."""
    read_digest(cases)
    names = sorted(path.name for path in cases.glob("case_*") if path.is_dir())
    if not names:
        raise InputError(f"{cases}: holds no cases", "no folder case_*", "record some first")
    return names


def case_files(cases: Path, name: str) -> Files:
    """Return the files of one case, name to content."""
    try:
        return {path.name: read_whole(path, "record the cases anew") for path in sorted((cases / name).iterdir())}
    except OSError as error:
        raise InputError(f"{cases / name}: cannot be read", str(error.strerror), "record the cases anew") from None


def _checked(cases: Path, name: str) -> str:
    """Return the digest of a case's files; raise `InputError` for a folder that is no case."""
    files = case_files(cases, name)
    left_out_of(files, cases / name)
    return digest_of_files(files)


def _left(out: Path, digests: Mapping[str, str], progress: Progress) -> list[str]:
    """Return the cases, given with the digests of their files, that are to be diagnosed."""
    known = {name: read_answer(path) for name in digests if (path := out / f"{name}.json").exists()}
    again = [name for name, answer in known.items() if "error" in answer or answer["files"] != digests[name]]
    if len(known) > len(again):
        progress(f"{len(known) - len(again)} of {len(digests)} cases have their answers already")
    if again:
        progress(f"{', '.join(again)}: failed before, or had other files, and done again")
    return [name for name in digests if name not in known or name in again]


def library_without(leave_out: Sequence[str]) -> list[str]:
    """Return the names of the effects that are candidates; raise `InputError` for a name that is none."""
    from stribeck.effects.registry import registry

    known = registry()
    for name in leave_out:
        if name not in known:
            raise InputError("--leave-out: no such effect", name, f"use {', '.join(known)}")
    return [name for name in known if name not in leave_out]


def write_json(path: Path, content: Any) -> None:
    """Write JSON whole or not at all."""
    text = json.dumps(content, indent=1, allow_nan=False, ensure_ascii=False) + "\n"
    with whole_file(path) as part:
        part.write_text(text, encoding="utf-8")


def _begin(out: Path, settings: dict[str, Any]) -> None:
    path = out / SETTINGS
    if not path.exists():
        if out.exists() and (not out.is_dir() or any(out.iterdir())):
            raise InputError(f"{out}: not a folder of answers", f"no {SETTINGS}", "give a new folder")
        write_json(path, settings)
        return
    try:
        before = json.loads(read_whole(path, "give a new folder"))
        changed = [name for name in settings if before.get(name) != settings[name]]
    except (OSError, ValueError, AttributeError) as error:
        raise InputError(f"{path}: cannot be read", str(error), "give a new folder") from None
    if changed:
        what = f"{out}: was begun with other {' and other '.join(changed)}"
        raise InputError(what, str(before.get(changed[0])), "give a new folder: answers must not be mixed")


def _in_words(answer: dict[str, Any]) -> str:
    if "error" in answer:
        return f"failed, {answer['error']}"
    found = answer["diagnosis"]
    return ", ".join(found["named"]) or str(found["verdict"])
