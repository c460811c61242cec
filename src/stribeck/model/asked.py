"""Expressions that are asked for again: of the very same symbols they are the same, and take long to write down."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, Concatenate, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


def asked_once(method: Callable[Concatenate[Any, P], R]) -> Callable[Concatenate[Any, P], R]:
    """Return a method that gives what it gave before to the very same arguments: nothing may change that.

    The arguments are kept with it, so that no other object gets the place of one in memory.
    """
    kept = f"_asked_{method.__name__}"

    @wraps(method)
    def asked(self: Any, /, *args: P.args, **kwargs: P.kwargs) -> R:
        given = (*args, *kwargs.values())
        key = (len(args), *kwargs, *map(id, given))
        before: dict[Any, tuple[tuple[Any, ...], R]] = self.__dict__.setdefault(kept, {})
        if key not in before:
            before[key] = given, method(self, *args, **kwargs)
        return before[key][1]

    return asked
