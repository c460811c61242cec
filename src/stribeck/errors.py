"""One base error for everything the package can say in one line: what, the value found, what to do."""

from __future__ import annotations

WARNING = "warning: "  # with which a text about what is being done begins that is to stay in sight
_LONGEST_FOUND = 160


class StribeckError(Exception):
    """An error whose text is one line.

    Parameters
    ----------
    what : str
        What is wrong and where (file, row or key).
    found : str
        The value that was found; shortened when long.
    do : str
        What the reader can do about it.
    """

    def __init__(self, what: str, found: str = "", do: str = "") -> None:
        self.what, self.found, self.do = _one_line(what), _shorten(_one_line(found)), _one_line(do)
        text = f"{self.what}: found {self.found}" if self.found else self.what
        super().__init__(f"{text}; {self.do}" if self.do else text)


class InputError(StribeckError):
    """The input or the arguments are wrong: exit status 2."""


def _one_line(text: str) -> str:
    """Collapse white space and control characters, which come from the user's file, to single spaces."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


def _shorten(text: str) -> str:
    return text if len(text) <= _LONGEST_FOUND else text[: _LONGEST_FOUND - 3] + "..."
