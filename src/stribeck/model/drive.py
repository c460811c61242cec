"""What drives a cut path: the recorded signals of one sample."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import casadi as ca

PAST = ("recordings", "recorded", "travelled", "lead", "led")
RATES = ("position_rate", "velocity_rate", "acceleration_rate", "flutter_rate", "command_rate")
DRIVE = (
    "time",
    "position",
    "velocity",
    "acceleration",
    "flutter",
    "command",
    *RATES,
    "resting",
    "sliding",
    "velocity_sd",
    "instant",
    *PAST,
)


@dataclass(frozen=True)
class Drive:
    """The recorded signals of all joints at one sample, each (n, 1) symbolic but ``time`` (1, 1).

    ``flutter`` is noise in the acceleration that is too fast for the analysis: no residual shows it.
    ``command`` is the command averaged over the sample before and after, as zero-order hold implies. The rates are time
    derivatives of signals that an effect delays, zero for others: those of the curves that are read off, from sample to
    sample, so that they differ a little from ``velocity`` and ``acceleration``. ``resting`` is 1 where the joint surely
    rests, ``sliding`` is the part of the motion that is surely no noise, ``velocity_sd`` the uncertainty of the
    velocity, ``instant`` the time to either side for which a sample stands. What was before: how many recordings, how
    long they were and how far the joint had gone in them; then the same two of this recording, where only a part of it
    is here.
    """

    time: Any
    position: Any
    velocity: Any
    acceleration: Any
    flutter: Any
    command: Any
    position_rate: Any
    velocity_rate: Any
    acceleration_rate: Any
    flutter_rate: Any
    command_rate: Any
    resting: Any
    sliding: Any
    velocity_sd: Any
    instant: Any
    recordings: Any
    recorded: Any
    travelled: Any
    lead: Any
    led: Any

    @staticmethod
    def symbols(n: int, suffix: str = "") -> Drive:
        """Return fresh symbols."""
        return Drive(*[ca.SX.sym(f"{name}{suffix}", 1 if name == "time" else n) for name in DRIVE])

    @property
    def stacked(self) -> Any:
        """All signals, one column (1 + 19 n, 1)."""
        return ca.vertcat(*[getattr(self, name) for name in DRIVE])

    def at(self, **changes: Any) -> Drive:
        """Return a copy with some signals replaced."""
        return replace(self, **changes)
