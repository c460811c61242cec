"""The symbols of a signal path: its parameters and states in one order each, and by name."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Sequence
from typing import Any

import casadi as ca
import numpy as np

from stribeck.arm import Arm
from stribeck.errors import StribeckError
from stribeck.model.effect import StandEffect, TransmissionEffect
from stribeck.model.layout import Placed, layout, rival, sole
from stribeck.model.values import Parameters, States


class Symbols:
    """All parameters and states of an arm with its effects, by name.

    Parameters
    ----------
    arm : Arm
        The nominal arm; its own ``effects`` entries are not read here.
    placed : sequence of Placed
        The effects, in the order in which their stage applies them.
    middles : sequence of float (n,), or None
        Of the joints' motions, about which the places of effects are bounded, rad.

    Raises
    ------
    StribeckError
        Two effects that share a place, as two transmissions of one joint.

    Attributes
    ----------
    entries : tuple of Entry
        The parameters, in the order of ``p``.
    p : casadi.SX (p, 1)
        Their symbols, physical values.
    flexible : tuple of int
        Joints whose link moves apart from its motor.
    x : casadi.SX (nx, 1)
        States: link position and velocity of each flexible joint, then the effects' states in order.
    """

    def __init__(self, arm: Arm, placed: Sequence[Placed] = (), middles: Sequence[float] | None = None) -> None:
        self.arm = arm
        self.placed = tuple(placed)
        for k, place in enumerate(placed):
            if other := rival(place.effect, place.joint, placed[:k]):
                what = f"{place.effect.name} beside {other.effect.name}, two of a kind ({sole(place.effect)})"
                raise StribeckError(what, arm.names[place.joint], "keep one of them")
        self.n = arm.n
        self.prismatic = arm.joints[0].kind == "prismatic"
        self.entries = layout(arm, placed, middles)
        self.p = ca.SX.sym("p", len(self.entries))
        self._index = {entry.key: i for i, entry in enumerate(self.entries)}
        self._each = ca.vertsplit(self.p) if self.entries else []  # to take one out of ``p`` costs more each time
        self._own = [
            {entry.name: self._each[i] for i, entry in enumerate(self.entries) if entry.owner == k}
            for k in range(len(self.placed))
        ]
        self.flexible = self._flexible()
        self.state_names = self._state_names()
        self.x = ca.SX.sym("x", len(self.state_names))

    @property
    def structure(self) -> Hashable:
        """What the expressions hold beside the symbols: equal of two paths, they have the same equations."""
        joints = tuple((joint.kind, joint.length, joint.backward != joint.friction) for joint in self.arm.joints)
        return self.arm.gravity, joints, tuple((place.effect, place.joint) for place in self.placed)

    def _flexible(self) -> tuple[int, ...]:
        return tuple(sorted(p.joint for p in self.placed if isinstance(p.effect, TransmissionEffect)))

    @property
    def rough(self) -> float:
        """Relative step over which a residual along the path is smooth; 0 where its derivatives are."""
        return max((e.effect.rough for e in self.placed if isinstance(e.effect, TransmissionEffect)), default=0.0)

    @property
    def shifts(self) -> tuple[int, ...]:
        """Indices of the parameters that move a recorded position in time, and with it every reversal of friction."""
        late = {k for k, place in enumerate(self.placed) if place.effect.delays == "position"}
        return tuple(i for i, entry in enumerate(self.entries) if entry.owner in late and entry.name == "time")

    def _state_names(self) -> tuple[str, ...]:
        links = [f"link[{j}].{what}" for j in self.flexible for what in ("position", "velocity")]
        own = [f"{k}.{state}" for k, place in enumerate(self.placed) for state in place.effect.states]
        return tuple(links + own)

    def owned_by(self, names: Collection[str]) -> dict[int, float]:
        """Return which parameters (by index) the placed effects of some names have, and the null value of each."""
        own = {k: place.effect for k, place in enumerate(self.placed) if place.effect.name in names}
        null = {(k, one.name): one.null for k, effect in own.items() for one in effect.parameters}
        return {i: null[entry.owner, entry.name] for i, entry in enumerate(self.entries) if entry.owner in own}

    def without(self, names: Collection[str], p: np.ndarray) -> np.ndarray:
        """Return parameter values (p,) with which the effects of some names are not there."""
        gone = self.owned_by(names) if names else {}
        if not gone:
            return p
        p = p.copy()
        p[list(gone)] = list(gone.values())
        return p

    def parameter(self, key: str) -> ca.SX:
        """Return the symbol of one parameter by its key."""
        return self._each[self._index[key]]

    def parameters(self, k: int) -> Parameters:
        """Return the symbols of the k-th placed effect by parameter name."""
        return dict(self._own[k])

    def states(self, k: int, x: Any) -> States:
        """Return the k-th placed effect's states by name, out of the state vector ``x``."""
        prefix = f"{k}."
        return {name.removeprefix(prefix): x[i] for i, name in enumerate(self.state_names) if name.startswith(prefix)}

    def state_index(self, name: str) -> int:
        """Return the place of a state in ``x``."""
        return self.state_names.index(name)

    def at(self, joint: int, kind: type[Any]) -> list[tuple[int, Any]]:
        """Return (number, effect) of the placed effects of one kind at a joint."""
        here = [(k, place.effect) for k, place in enumerate(self.placed) if joint in place.joints(self.n)]
        return [(k, effect) for k, effect in here if isinstance(effect, kind)]

    def constants(self, joint: int, direction: float) -> Parameters:
        """Return the Tustin constants' symbols of a joint for one direction of motion."""
        name = self.arm.names[joint]
        side = "backward" if direction < 0 and f"{name}.backward.C0" in self._index else "friction"
        return {key: self.parameter(f"{name}.{side}.{key}") for key in ("C0", "C1", "C2", "alpha")}

    @property
    def sliding(self) -> tuple[int, StandEffect] | None:
        """Number and effect of the stand that slides, if there is one."""
        found = [(k, place.effect) for k, place in enumerate(self.placed) if isinstance(place.effect, StandEffect)]
        return found[0] if found else None

    @property
    def stand_rows(self) -> tuple[int, ...]:
        """Places in ``x`` of that stand's position and velocity; empty on firm ground."""
        found = self.sliding
        return () if found is None else tuple(self.state_index(f"{found[0]}.{name}") for name in found[1].states)
