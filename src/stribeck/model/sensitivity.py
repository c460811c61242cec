"""States that are carried along a recording together with their derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Sensitivity:
    """States (nx, 1), the parameters that count, and the states' derivatives by them (nx, number of parameters)."""

    states: Any
    parameters: tuple[int, ...]
    columns: Any
