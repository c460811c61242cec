"""Ctrl-C while IPOPT works: CasADi would take its exception for a trial step that failed, and go on."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from stribeck.stopping import answered


@contextmanager
def held_back(come: list[int]) -> Iterator[None]:
    """Hold Ctrl-C and a stop back while a solver runs, and deliver the first one after it.

    Parameters
    ----------
    come : list of int
        Takes the signals as they come: a solver that looks at it can end early.
    """
    if threading.current_thread() is not threading.main_thread():  # no other thread is ever interrupted
        yield
        return

    def note(number: int, frame: FrameType | None) -> None:
        come.append(number)

    try:
        with answered(note):
            yield
    finally:
        if come:
            signal.raise_signal(come[0])
