"""Whether recordings are told in other conventions than the arm file: turned the other way, exchanged, absolute.

No effect of an arm looks like that, and a search through all of them only takes long.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from stribeck.arm import Arm
from stribeck.effects.placing import stated_effects
from stribeck.gap.answer.commands import told_commands
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.records.regions import analysis_signals
from stribeck.identify.conditioning import Conditioned, condition
from stribeck.identify.residual import Residual
from stribeck.model.layout import values_of
from stribeck.model.path import SignalPath
from stribeck.run import Run

MUCH = 0.3  # of the torque, that the arm file's model must leave: values that are off leave less
ALIKE = 1.05  # times as much leaves another convention that is the same: a mirrored arm on a level stand
HALF = 0.5  # of it, which another convention must take away: no effect that an arm has is mistaken for one


@dataclass(frozen=True)
class Convention:
    """How else recordings may be meant: ``position`` and ``torque`` (n, n) of what is recorded, and in words."""

    text: str
    position: np.ndarray
    torque: np.ndarray

    def of(self, run: Run) -> Run:
        """Return a recording as it is meant."""
        return replace(run, q=run.q @ self.position.T, tau=run.tau @ self.torque.T, droop=None)


def conventions(arm: Arm) -> Iterator[Convention]:
    """Yield the conventions that are mistaken for another most often."""
    n, same = arm.n, np.eye(arm.n)
    for j, name in enumerate(arm.names):
        turned = same.copy()
        turned[j, j] = -1.0
        yield Convention(f"the position of {name} turned the other way", turned, same)
        yield Convention(f"the torque of {name} turned the other way", same, turned)
        if n > 1:
            yield Convention(f"position and torque of {name} turned the other way", turned, turned)
    for i, j in combinations(range(n), 2):
        order = np.arange(n)
        order[[i, j]] = j, i
        both = f"{arm.names[i]} and {arm.names[j]}"
        yield Convention(f"the torques of {both} exchanged", same, same[order])
        yield Convention(f"the positions of {both} exchanged", same[order], same)
        yield Convention(f"{both} exchanged", same[order], same[order])
    if n > 1:
        yield Convention("positions taken as angles against the base", same - np.eye(n, k=-1), same)


def told_recorded(prepared: Prepared, given: np.ndarray) -> list[str]:
    """Return what makes recordings doubtful beside the arm file: another convention, else another unit.

    Parameters
    ----------
    prepared : Prepared
    given : array (M, n)
        Residual of that model on the held-out runs, N m.
    """
    return told_conventions(prepared, given) or told_commands(prepared, given)


def told_conventions(prepared: Prepared, given: np.ndarray) -> list[str]:
    """Return a warning where the arm file's model fits recordings far better in another convention.

    Parameters
    ----------
    prepared : Prepared
    given : array (M, n)
        Residual of that model on the held-out runs, N m.
    """
    recorded = _part(given, prepared.held)
    if recorded < MUCH:
        return []
    arm = prepared.file_arm
    path = SignalPath(arm, [place for place in stated_effects(arm) if not place.effect.direct])
    p, found = values_of(path.entries), []
    for meant in conventions(arm):
        runs = [_as(meant, prepared, run) for run in prepared.held]
        found.append((_part(Residual(path, runs, ()).value(p), runs), meant.text))
    left = min(found)[0]
    if left > HALF * recorded:
        return []
    texts = " or ".join(text for part, text in found if part < ALIKE * left)
    return [
        f"with {texts}, the arm file's model leaves {left:.2g} times the torque, and as recorded {recorded:.2g}: check "
        "in which convention the recordings are"
    ]


def _as(meant: Convention, prepared: Prepared, run: Conditioned) -> Conditioned:
    """Return a run as it is meant; which joints brakes hold in it goes with their columns."""
    noise = np.abs(meant.position) @ run.noise
    own = condition(prepared.arm, meant.of(run.run), prepared.cutoff, noise, thin=True)
    return replace(own.as_recorded(run), braked=own.braked, undriven=own.undriven)


def _part(residual: np.ndarray, runs: Sequence[Conditioned]) -> float:
    """Return the root mean square of a residual (M, n) over each joint's commands, the largest where it has none."""
    command = np.sqrt(np.mean(analysis_signals(runs)["command"] ** 2, axis=0))
    over = np.where(command > 0.0, command, command.max())
    rms = np.sqrt(np.mean(residual**2, axis=0))
    return float(np.sqrt(np.mean((rms / over) ** 2))) if command.any() else 0.0
