"""The source that an answer depends on, as one number: a frozen method keeps it."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

# of the package: all that a diagnosis imports
PARTS = (
    "arm", "compiler", "effects", "errors", "gap", "grid", "identify", "mirrored", "model", "outputs", "quantum",
    "rounding", "run", "simulate", "stopping", "textfile", "version",
)  # fmt: skip
SUFFIXES = (".c", ".h", ".py")  # what is compiled has its say, too


@cache
def code_digest() -> str:
    """Return the SHA-256 of the package's source that has a say in an answer, as it is when first asked for."""
    total, root = hashlib.sha256(), Path(__file__).parents[1]
    parts = [path for part in PARTS for path in (root / part, root / f"{part}.py") if path.exists()]
    files = (file for part in parts for file in ([part] if part.is_file() else part.rglob("*")))
    for path in sorted(file for file in files if file.suffix in SUFFIXES):
        total.update(path.relative_to(root).as_posix().encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    return total.hexdigest()
