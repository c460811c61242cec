"""What to hide in which case: drawn in advance, in an order that tells nothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stribeck.errors import InputError
from stribeck.withheld.injections import KNOWN, RULES, UNKNOWN
from stribeck.withheld.severity import SHARES

LEVELS = tuple(SHARES)
JOINTS = (1, 2, 2, 2)  # of the arms, drawn from
DISTURBED = 3  # every third case without an effect is shaken by coloured torque noise
SMOOTH = 0.1  # of the cases without negative damping: a joint without falling friction, which would give that away
LEFT_OUT = 3  # names that a case with its effect left out withholds from the library, the true one among them
SEVERAL = (3, 4, 5)  # effects of a case that has several, in turn
CLASH = frozenset({"encoder_offset", "torque_saturation"})  # one shows only under gravity, the other without


@dataclass(frozen=True)
class Order:
    """How many cases of which kind to record.

    Attributes
    ----------
    single, pairs : int
        Cases with one effect, and with two.
    none : int
        Cases without an effect; coloured torque noise shakes every third of them.
    unknown : int
        Cases with an effect that no library holds.
    left_out : int
        Cases whose effect is withheld from the library, beside two names that are not there.
    effects, levels : tuple of str
        Drawn from, in turn.
    joints : tuple of int
        Numbers of joints, drawn from.
    several : int
        Cases with three to five effects, as worn arms have them.
    """

    single: int = 0
    pairs: int = 0
    none: int = 0
    unknown: int = 0
    left_out: int = 0
    effects: tuple[str, ...] = tuple(KNOWN)
    levels: tuple[str, ...] = LEVELS
    joints: tuple[int, ...] = JOINTS
    several: int = 0

    @property
    def total(self) -> int:
        """Number of cases."""
        return self.single + self.pairs + self.none + self.unknown + self.left_out + self.several

    def checked(self) -> Order:
        """Return the order itself; raise `InputError` for what cannot be recorded."""
        for name in self.effects:
            if name not in RULES:
                raise InputError("--effects: the plant has no such effect", name, f"it has {', '.join(RULES)}")
        for level in self.levels:
            if level not in LEVELS:
                raise InputError("--levels: no such level", level, f"use {', '.join(LEVELS)}")
        for count in self.joints:
            if not 1 <= count <= 4:
                raise InputError("--joints: the plant has 1 to 4 joints", str(count), "use 1 to 4")
        if self.total < 1:
            options = "--cases, --none, --unknown, --pairs, --left-out or --several"
            raise InputError("no cases to record", "0", f"give {options}")
        if self.pairs and len(self.effects) < 2:
            raise InputError("--pairs need two effects", ", ".join(self.effects), "give more --effects")
        if self.several and len(self.effects) <= max(SEVERAL):
            what = f"--several need {max(SEVERAL) + 1} effects to draw from"
            raise InputError(what, ", ".join(self.effects), "give more --effects")
        return self


@dataclass(frozen=True)
class Plan:
    """One case to record: what `cases.make_case` takes, its `kind`, and what the library is to do without."""

    kind: str
    effects: tuple[str, ...] = ()
    level: str = "clear"
    joints: int = 2
    disturbed: bool = False
    smooth: bool = False
    leave_out: tuple[str, ...] = ()


def plans(order: Order, rng: np.random.Generator) -> tuple[Plan, ...]:
    """Return the cases of an order, shuffled; effects and levels are spread evenly.

    Parameters
    ----------
    order : Order
        Checked.
    rng : numpy.random.Generator
        Draws what goes together, joints, decoys and the order.
    """
    one, other, level = order.effects, tuple(UNKNOWN), order.levels
    cases = [Plan("single", (_in_turn(one, i),), _level(level, i, len(one))) for i in range(order.single)]
    cases += [Plan("unknown", (_in_turn(other, i),), _level(level, i, len(other))) for i in range(order.unknown)]
    cases += [Plan("pair", _drawn(one, 2, rng), _level(level, i, 1)) for i in range(order.pairs)]
    cases += [Plan("none", disturbed=i % DISTURBED == 2) for i in range(order.none)]
    cases += [_left_out(i, order, rng) for i in range(order.left_out)]
    for i in range(order.several):
        names = _drawn(one, SEVERAL[i % len(SEVERAL)], rng)
        cases.append(Plan("several", names, _level(level, i, len(SEVERAL))))
    cases = [_placed(case, order.joints, rng) for case in cases]
    return tuple(cases[i] for i in rng.permutation(len(cases)))


def _in_turn(names: Sequence[str], i: int) -> str:
    return names[i % len(names)]


def _level(levels: Sequence[str], i: int, each: int) -> str:
    """Return the level of case `i`, effects coming in rounds of `each`: every effect meets all levels in turn."""
    shift = i // each if each % len(levels) == 0 else 0
    return levels[(i + shift) % len(levels)]


def _drawn(names: Sequence[str], count: int, rng: np.random.Generator) -> tuple[str, ...]:
    """Return so many different names, that go together where there is a choice."""
    while True:
        drawn = tuple(str(name) for name in rng.choice(names, count, replace=False))
        if not set(drawn) >= CLASH or len(names) == count:
            return drawn


def _left_out(i: int, order: Order, rng: np.random.Generator) -> Plan:
    true = _in_turn(order.effects, i)
    others = [name for name in KNOWN if name != true]
    names = [true, *rng.choice(others, LEFT_OUT - 1, replace=False)]
    shuffled = tuple(str(names[k]) for k in rng.permutation(len(names)))
    return Plan("left_out", (true,), _level(order.levels, i, len(order.effects)), leave_out=shuffled)


def _placed(plan: Plan, joints: Sequence[int], rng: np.random.Generator) -> Plan:
    """Return the plan with a number of joints, and with a smooth joint now and then."""
    count = int(rng.choice(joints))
    count = max(2, count) if "tendon_coupling" in plan.effects else count
    return replace(plan, joints=count, smooth=bool(rng.random() < SMOOTH))
