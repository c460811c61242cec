"""What the FMU of an arm and that of a controller have in common: the standard's functions, the token, the archive."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from importlib.resources import files
from pathlib import Path

import fmpy
from joblib import Parallel, delayed

from stribeck.errors import InputError
from stribeck.export.build import Platform, binary
from stribeck.export.universal import universal

FUNCTIONS = ("bare.h", "instance.h", "blob.h", "both.h")
_HEADERS = {2: ("TypesPlatform", "FunctionTypes", "Functions"), 3: ("PlatformTypes", "FunctionTypes", "Functions")}


def check_version(fmi: int) -> None:
    """Raise `InputError` for a version of the standard that is not known."""
    if fmi not in _HEADERS:
        raise InputError("unknown version of FMI", str(fmi), "use 2 or 3")


def stamped(model: str, part: Mapping[str, str], fmi: int) -> tuple[str, dict[str, str]]:
    """Return the token of a model and the files of its ``sources`` folder, by name.

    Parameters
    ----------
    model : str
        The generated ``model.h`` but for its last lines: the token and the end of its guard.
    part : mapping of str to str
        ``part.h`` and what it includes, by file name.
    fmi : int
        2 or 3.

    Notes
    -----
    The token is a digest of everything that is compiled, so that an XML cannot go with another's binary.
    """
    found = {name: runtime(name) for name in (*FUNCTIONS, f"fmi{fmi}.c")} | dict(part)
    found |= {f"fmi{fmi}{kind}.h": _standard(f"fmi{fmi}{kind}.h") for kind in _HEADERS[fmi]}
    digest = hashlib.sha256("\0".join([model, *(found[name] for name in sorted(found))]).encode()).hexdigest()
    token = f"{{{digest[:8]}-{digest[8:12]}-{digest[12:16]}-{digest[16:20]}-{digest[20:32]}}}"
    found["model.h"] = f'{model}#define FM_TOKEN "{token}"\n#endif\n'
    return token, dict(sorted(found.items()))


def compiled(
    texts: Mapping[str, str],
    identifier: str,
    fmi: int,
    platforms: Iterable[Platform],
    progress: Callable[[str], None] = lambda text: None,
) -> dict[str, bytes | str]:
    """Return sources and binaries by their name in the archive.

    Parameters
    ----------
    texts : mapping of str to str
        The sources by file name.
    identifier : str
        The model identifier, which names the binaries.
    fmi : int
        2 or 3.
    platforms : iterable of Platform
    progress : callable
        Told what is being built.
    """
    built: dict[str, list[bytes]] = {}
    wanted = tuple(platforms)
    pool = Parallel(n_jobs=-1, backend="threading", return_as="generator")  # the work is the compiler's, not Python's
    libraries = pool(delayed(binary)(texts, f"fmi{fmi}.c", identifier, platform) for platform in wanted)
    for platform in wanted:
        progress(f"building for {platform.name}")
        folder = platform.fmi2 if fmi == 2 else platform.name
        library = next(libraries)
        built.setdefault(f"binaries/{folder}/{identifier}{platform.suffix}", []).append(library)
    content: dict[str, bytes | str] = {f"sources/{name}": text for name, text in texts.items()}
    return content | {name: universal(libraries) for name, libraries in built.items()}


@cache
def runtime(name: str) -> str:
    """Return one file of the runtime, such as ``both.h`` or ``arm/part.h``."""
    return (files("stribeck.export") / "c" / name).read_text(encoding="utf-8")


@cache
def _standard(name: str) -> str:
    """Return a header of the standard; they come with fmpy, each with its licence in it."""
    return (Path(fmpy.__file__).parent / "c-code" / name).read_text(encoding="utf-8")
