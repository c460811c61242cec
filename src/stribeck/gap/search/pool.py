"""Processes that try candidates side by side; the recordings that all of them need are sent to each of them once.

What a process works out along them, it then knows for its next task, too.
"""

from __future__ import annotations

import warnings
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from types import TracebackType
from typing import Any

import joblib

from stribeck.gap.records.prepare import Prepared

Task = tuple[Callable[..., Any], tuple[Any, ...], dict[str, Any]]  # as joblib.delayed makes them

SENT = 2  # that are kept: tasks that are asked for together are along one or two


class Pool:
    """As :class:`joblib.Parallel`, a context; with one job, tasks are done where they are asked for.

    Recordings are known by their place: each task's are among its positional arguments.

    Parameters
    ----------
    jobs : int
    """

    def __init__(self, jobs: int) -> None:
        self._jobs, self._parallel = jobs, joblib.Parallel(n_jobs=jobs)
        self._sent: deque[tuple[Prepared, _Sent]] = deque()
        self._count = 0

    def __enter__(self) -> Pool:
        self._folder = TemporaryDirectory(prefix="stribeck.", ignore_cleanup_errors=True)
        self._parallel.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            self._parallel.__exit__(kind, error, trace)
        finally:
            self._folder.cleanup()

    def __call__(self, tasks: Iterable[Task]) -> list[Any]:
        """Return the results of all tasks, in their order."""
        if self._jobs == 1:
            return [work(*values, **named) for work, values, named in tasks]
        sent = ((work, [self._of(value) for value in values], named) for work, values, named in tasks)
        with warnings.catch_warnings():
            # what was compiled for a long arm fills a process, which then makes room for another: no news to a reader
            warnings.filterwarnings("ignore", "A worker stopped")
            return list(self._parallel(joblib.delayed(_done)(*task) for task in sent))

    def _of(self, value: object) -> object:
        """Return what stands for recordings in a task: of all that were sent, the last few are kept."""
        if not isinstance(value, Prepared):
            return value
        for known, sent in self._sent:
            if known is value:
                return sent
        self._count += 1
        sent = _Sent(str(Path(self._folder.name) / str(self._count)))
        joblib.dump(value, sent.path)
        self._sent.append((value, sent))
        if len(self._sent) > SENT:
            Path(self._sent.popleft()[1].path).unlink()
        return sent


@dataclass(frozen=True)
class _Sent:
    """Recordings that lie in a file of the pool's own folder, which no other user can read."""

    path: str


@lru_cache(maxsize=1)
def _read(sent: _Sent) -> object:
    return joblib.load(sent.path)


def _done(work: Callable[..., Any], values: list[object], named: dict[str, Any]) -> object:
    return work(*(_read(value) if isinstance(value, _Sent) else value for value in values), **named)
