"""Files from others: read whole within a bound; small ones of text parsed as TOML, and fitted strictly to a type."""

from __future__ import annotations

import difflib
import json
import re
import stat
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

from stribeck.errors import InputError

LARGEST_TEXT_FILE = 1 << 20
"""Bytes; a file of parameters larger than this is taken for a mistake."""
LARGEST_FILE = 1 << 28
"""Bytes; of any other file that is read whole: a recording of hours is smaller."""
DEEPEST_KEY = 100  # names joined by dots; the parser's time grows with the square of their number
_NO_KEY = re.compile(  # texts and comments; without an end, to that of the file or the line
    r"""
    "{3} (?: \\.? | [^\\] )*? (?: "{3,5} | \Z )
    | '{3} .*? (?: '{3,5} | \Z )
    | " (?: \\. | [^"\\\n] )* "?
    | ' [^'\n]* '?
    | \# [^\n]*
    """,
    re.DOTALL | re.VERBOSE,
)

_T = TypeVar("_T")

# Pydantic's error types, in our words; {} takes the bound from the error's context.
_WORDS = {
    "greater_than": "must be greater than {gt}",
    "greater_than_equal": "must not be less than {ge}",
    "less_than_equal": "must not be greater than {le}",
    "finite_number": "must be finite",
    "float_type": "must be a number",
    "int_type": "must be a whole number",
    "string_type": "must be text in quotes",
    "string_too_short": "must not be empty",
    "string_too_long": "must have at most {max_length} characters",
    "string_pattern_mismatch": "must be a name like {pattern}",
    "bool_type": "must be true or false",
    "literal_error": "must be {expected}",
    "too_short": "must have at least {min_length} entries",
    "too_long": "must have at most {max_length} entries",
    "tuple_type": "must be an array",
    "list_type": "must be an array",
    "dict_type": "must be a table",
    "dataclass_type": "must be a table",
}


def explain_unreadable(path: Path, error: OSError) -> InputError:
    """Word an operating system's refusal (no such file, a folder, no permission) as an input error."""
    return InputError(
        f"{path}: cannot be read", (error.strerror or str(error)).lower(), "give the path of a readable file"
    )


def check_regular(path: Path, do: str) -> None:
    """Raise `InputError` for a pipe, which would be waited for without end, or a device; `do` says what to give.

    Raises
    ------
    OSError
        Where there is nothing.
    """
    mode = path.stat().st_mode
    if not stat.S_ISREG(mode) and not stat.S_ISDIR(mode):  # a folder is told as one when it is opened
        raise InputError(f"{path}: is not a regular file", "", do)


def read_whole(path: Path, do: str) -> bytes:
    """Return the content of a regular file of at most 256 MiB.

    Parameters
    ----------
    path : path
    do : str
        What to do about a file that is none, or larger.

    Raises
    ------
    InputError
        For any other file.
    OSError
        Where it cannot be read.
    """
    check_regular(path, do)
    with path.open("rb") as stream:
        content = stream.read(LARGEST_FILE + 1) if path.stat().st_size <= LARGEST_FILE else None
    if content is None or len(content) > LARGEST_FILE:
        raise InputError(f"{path}: is too large", f"more than {LARGEST_FILE >> 20} MiB", do)
    return content


def load_toml(path: Path) -> dict[str, Any]:
    """Read a TOML file of at most 1 MiB.

    Raises
    ------
    InputError
        When the file cannot be read, is too large, is not UTF-8 or is not TOML.
    """
    try:
        with path.open("rb") as stream:
            raw = stream.read(LARGEST_TEXT_FILE + 1)
    except OSError as error:
        raise explain_unreadable(path, error) from error
    if len(raw) > LARGEST_TEXT_FILE:
        raise InputError(
            f"{path}: too large for a parameter file", "more than 1 MiB", "give the TOML file, not a recording"
        )
    try:
        text = raw.decode("utf-8")
        if any(part.count(".") > DEEPEST_KEY for part in re.split("[=,{\n]", _NO_KEY.sub("", text))):
            raise ValueError(f"a key of more than {DEEPEST_KEY} names")
        return tomllib.loads(text)
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not a text file in UTF-8", f"byte {error.start}", "give a TOML file") from error
    except (ValueError, RecursionError) as error:  # tomllib's own error is a ValueError
        raise InputError(f"{path}: not valid TOML", str(error), "correct the file at that place") from error


def check_schema(data: dict[str, Any], schema: str, source: str) -> dict[str, Any]:
    """Return `data` without its ``schema`` entry, which must be `schema`."""
    found = data.get("schema")
    if found != schema:
        what = f"{source}: schema is missing" if found is None else f"{source}: schema must be {schema!r}"
        raise InputError(what, "" if found is None else repr(found), f'write schema = "{schema}" at the top')
    return {key: value for key, value in data.items() if key != "schema"}


def structure(
    data: Mapping[str, Any], adapter: TypeAdapter[_T], source: str, moved: Mapping[str, str] | None = None
) -> _T:
    """Fit plain data to the type of `adapter`.

    Parameters
    ----------
    data : mapping
        As parsed.
    adapter : pydantic.TypeAdapter
        Of the type to build.
    source : str
        The file, for the message.
    moved : mapping, optional
        Key of the type -> key in the file, where they differ.

    Raises
    ------
    InputError
        One line for the first mismatch: its key path as ``joints[1].mass``, the value and what is wrong with it.
    """
    try:
        return adapter.validate_python(data)
    except ValidationError as error:
        details = error.errors(include_url=False)
        # An unknown key is usually the misspelling of one that is then reported missing: say that one first.
        first = next((d for d in details if d["type"] == "unexpected_keyword_argument"), details[0])
        key = _key_path((moved or {}).get(str(part), part) for part in first["loc"])
        raise _explain(first, f"{source}: {key}", adapter) from error


def _key_path(location: Iterable[int | str]) -> str:
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in location)
    return text.removeprefix(".")


def _explain(detail: Any, where: str, adapter: TypeAdapter[_T]) -> InputError:
    kind = detail["type"]
    if kind == "unexpected_keyword_argument":
        return InputError(f"{where} is not a known key", "", _suggest(str(detail["loc"][-1]), adapter))
    if kind == "missing":
        return InputError(f"{where} is missing", "", "add it")
    words = _WORDS.get(kind, detail["msg"]).format(**detail.get("ctx", {}))
    return InputError(f"{where} {words}", _show(detail["input"]), "correct the value")


def _suggest(key: str, adapter: TypeAdapter[_T]) -> str:
    names = {name.casefold(): name for name in _declared_names(adapter.json_schema())}
    near = difflib.get_close_matches(key.casefold(), names, n=1, cutoff=0.5)
    return f"did you mean {names[near[0]]!r}?" if near else "remove it"


def _declared_names(schema: dict[str, Any]) -> list[str]:
    tables = [schema, *schema.get("$defs", {}).values()]
    return sorted({name for table in tables for name in table.get("properties", {})})


def _show(value: Any) -> str:
    return json.dumps(value, default=str, ensure_ascii=False)
