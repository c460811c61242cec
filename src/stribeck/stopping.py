"""Ctrl-C and a batch system's stop: an exception, and a note of it, for an exception alone may be lost.

CasADi clears those that are raised while it converts arguments, and what it was asked goes on as if nothing had been.
"""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Never

_come: list[int] = []


@contextmanager
def answered(handler: Callable[[int, FrameType | None], object]) -> Iterator[None]:
    """Let a handler answer Ctrl-C and a stop in the block, and then whatever did before."""
    before = [(number, signal.signal(number, handler)) for number in (signal.SIGINT, signal.SIGTERM)]
    try:
        yield
    finally:
        for number, earlier in before:
            signal.signal(number, earlier)


@contextmanager
def stoppable() -> Iterator[None]:
    """End the block by `KeyboardInterrupt` when the program is asked to stop, at the latest at `stop_if_asked`."""
    _come.clear()
    with answered(_stop):
        yield


def stop_if_asked() -> None:
    """Raise `KeyboardInterrupt` if the program has been asked to stop: before anything is written for good."""
    if _come:
        raise KeyboardInterrupt


def _stop(number: int, frame: FrameType | None) -> Never:
    _come.append(number)
    raise KeyboardInterrupt
