"""What stays the same during a search."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np

from stribeck.gap.records.prepare import Prepared

Progress = Callable[[str], None]
Known: TypeAlias = dict[tuple[str, str, int], dict[str, float]]  # values by law and joint
Vain: TypeAlias = dict[tuple[str, str, int], list[float]]  # N m rms at a joint, of which a law there took little


@dataclass(frozen=True)
class Asked:
    """How a diagnosis is to be made.

    ``seed`` is of all resampling, ``jobs`` the number of processes; the effects ``leave_out`` are no candidates;
    ``progress`` is told in words what is being done.
    """

    seed: int = 0
    jobs: int = 2
    leave_out: tuple[str, ...] = ()
    progress: Progress = lambda text: None


@dataclass(frozen=True)
class Setting:
    """What stays the same during a forward search; the first, ``stated`` effects of its base are the arm file's.

    One that is made ``anew`` starts from a model that differs by little from the one before. Which compliances were
    sought in ``vain`` is known to all that follow.
    """

    prepared: Prepared
    floor: np.ndarray
    seed: int
    pool: Any
    leave_out: tuple[str, ...]
    barred: frozenset[tuple[str, int]]
    progress: Progress
    stated: int = 0
    anew: bool = False
    vain: Vain = field(default_factory=dict)
