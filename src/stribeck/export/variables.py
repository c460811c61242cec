"""The one table of an FMU's variables, from an arm's signal path: names, value references, units, start values.

The ranges of value references mirror ``c/arm/values.h``; both versions of the standard take their XML from this table.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

from stribeck.export.names import bounds, effect_prefix, parameter_description, parameter_name, starting
from stribeck.export.notes import limit_of
from stribeck.export.units import Unit, unit_of
from stribeck.export.variable import Variable
from stribeck.model.forward import Forward
from stribeck.model.layout import Entry


@dataclass(frozen=True)
class Table:
    """All variables of an FMU in the order of their value references, which start at 0 and leave no gap in a range.

    Attributes
    ----------
    forward : Forward
    variables : tuple of Variable
    base : dict of str to int
        First value reference of each range.
    constants : tuple of float
        Values of the range ``constant``.
    """

    forward: Forward
    variables: tuple[Variable, ...]
    base: dict[str, int]
    constants: tuple[float, ...] = field(default=())

    @property
    def indicators(self) -> tuple[int, ...]:
        """Joints with an event indicator: those whose friction is not a bristle."""
        return tuple(j for j, bristle in enumerate(self.forward.bristles) if not bristle)


RANGES = (
    "time", "tau", "q", "dq", "tau_friction", "sliding", "state", "rate", "indicator", "p", "q_start", "dq_start",
    "constant", "mode", "events",
)  # fmt: skip


def table_of(forward: Forward) -> Table:
    """Return the variables of an arm with the effects of its path."""
    constants = _constants(forward)
    n, size, count = forward.n, forward.size, len(forward.path.entries)
    lengths = dict.fromkeys(RANGES, n) | {"time": 1, "state": size, "rate": size, "p": count, "events": 1}
    lengths["constant"] = len(constants)
    base, total = {}, 0
    for name in RANGES:
        base[name], total = total, total + lengths[name]
    maker = _Maker(forward, base)
    values = tuple(value for *_, value in constants)
    return Table(forward, (*maker.signals(), *maker.states(), *maker.values(constants)), base, values)


def _constants(forward: Forward) -> list[tuple[str, str, str, float]]:
    """Return (name, unit, description, value) of what is built into the equations."""
    arm = forward.path.arm
    found = [("gravity[1]", "m/s^2", "gravity along the base frame's x axis", arm.gravity[0])]
    found.append(("gravity[2]", "m/s^2", "gravity along the base frame's y axis", arm.gravity[1]))
    for j, joint in enumerate(arm.joints, 1):
        found.append((f"joint[{j}].length", "m", f"length of the link of joint {joint.name}", joint.length))
    return found


class _Maker:
    """Makes the variables of one arm, range by range."""

    def __init__(self, forward: Forward, base: dict[str, int]) -> None:
        self.forward, self.base, self.path = forward, base, forward.path

    def _unit(self, text: str) -> Unit:
        return unit_of(text, prismatic=self.path.prismatic)

    def _joints(self) -> Iterator[tuple[int, str]]:
        yield from enumerate(self.path.arm.names)

    def signals(self) -> Iterator[Variable]:
        base = self.base
        yield Variable("time", 0, "independent", "continuous", "time", unit_of("s"))
        torque, angle, speed = self._unit("N m"), self._unit("rad"), self._unit("rad/s")
        for j, name in self._joints():
            limit = limit_of(self.path.arm.joints[j])
            text = f"commanded torque of joint {name}{f', not cut off at its limit of {limit}' if limit else ''}"
            yield Variable(f"tau[{j + 1}]", base["tau"] + j, "input", "continuous", text, torque, start=0.0)
        columns = (
            ("q", angle, "continuous", "position of joint {} as its sensor gives it"),
            ("dq", speed, "continuous", "velocity of joint {} as its sensor gives it"),
            ("tau_friction", torque, "continuous", "friction torque of joint {}, against the motion"),
            ("sliding", self._unit("1"), "discrete", "joint {} slides forward (1), backward (-1) or sticks (0)"),
        )
        for key, unit, variability, text in columns:
            for j, name in self._joints():
                kind = "continuous" if key == "sliding" and self.forward.bristles[j] else variability
                label = f"{key}[{j + 1}]"
                yield Variable(label, base[key] + j, "output", kind, text.format(name), unit, initial="calculated")

    def states(self) -> Iterator[Variable]:
        named = list(self._named_states())
        for i, (name, unit, text, jumps) in enumerate(named):
            yield Variable(
                name, self.base["state"] + i, "local", "continuous", text, self._unit(unit), "calculated", reinit=jumps
            )
        for i, (name, unit, text, _) in enumerate(named):
            rate, vr = self._unit(_rate(unit)), self.base["state"] + i
            text = f"time derivative: {text}"
            label = f"der({name})"
            yield Variable(
                label, self.base["rate"] + i, "local", "continuous", text, rate, "calculated", derivative_of=vr
            )
        for j, name in self._joints():
            if not self.forward.bristles[j]:
                text = f"changes sign where the mode of joint {name} ends"
                vr = self.base["indicator"] + j
                yield Variable(f"joint[{j + 1}].event_indicator", vr, "local", "continuous", text, None, "calculated")

    def _named_states(self) -> Iterator[tuple[str, str, str, bool]]:
        """Give name, unit, description and whether it may jump, in the order of y."""
        for j, name in self._joints():
            yield f"joint[{j + 1}].q", "rad", f"true position of joint {name} on the motor side", False
        for j, name in self._joints():
            jumps = not self.forward.bristles[j]
            yield f"joint[{j + 1}].dq", "rad/s", f"true velocity of joint {name} on the motor side", jumps
        for j in self.path.flexible:
            link = self.path.arm.names[j]
            yield f"link[{j + 1}].q", "rad", f"position of the link of joint {link}", False
            yield f"link[{j + 1}].dq", "rad/s", f"velocity of the link of joint {link}", False
        for k, place in enumerate(self.path.placed):
            for state in place.effect.states:
                unit = place.effect.state_units.get(state, "1")
                prefix = effect_prefix(self.forward, k)
                yield f"{prefix}.state.{state}", unit, f"{state}, a state of the effect {place.effect.name}", False

    def values(self, constants: list[tuple[str, str, str, float]]) -> Iterator[Variable]:
        base = self.base
        fixed = starting(self.forward)
        for i, entry in enumerate(self.path.entries):
            yield self._parameter(i, entry, "fixed" if i in fixed else "tunable")
        for key, unit, text in (("q_start", "rad", "position"), ("dq_start", "rad/s", "velocity")):
            for j, name in self._joints():
                what = f"initial {text} of joint {name} as its sensor gives it"
                label = f"{key}[{j + 1}]"
                yield Variable(label, base[key] + j, "parameter", "fixed", what, self._unit(unit), "exact", start=0.0)
        for i, (label, unit, what, value) in enumerate(constants):
            vr = base["constant"] + i
            yield Variable(label, vr, "local", "constant", what, unit_of(unit), "exact", start=value)
        for j, name in self._joints():
            if not self.forward.bristles[j]:
                text = f"mode of joint {name}: 1 and -1 slide, 0 sticks"
                yield Variable(
                    f"joint[{j + 1}].mode", base["mode"] + j, "local", "discrete", text, None, "calculated",
                    lower=-1, upper=1, real=False,
                )  # fmt: skip
        text = "changes of mode since the start"
        yield Variable("events", base["events"], "local", "discrete", text, None, "calculated", lower=0, real=False)

    def _parameter(self, i: int, entry: Entry, variability: str) -> Variable:
        lower, upper = bounds(self.forward, entry)
        return Variable(
            parameter_name(self.forward, entry), self.base["p"] + i, "parameter", variability,
            parameter_description(self.forward, entry), self._unit(entry.unit), "exact", entry.value,
            lower if math.isfinite(lower) else None, upper if math.isfinite(upper) else None,
        )  # fmt: skip


def _rate(unit: str) -> str:
    """Return the unit of a time derivative."""
    return f"{unit}^2" if unit.endswith("/s") else f"{unit}/s"
