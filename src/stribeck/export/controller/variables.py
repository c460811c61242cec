"""The variables of a controller's FMU.

Their order mirrors ``c/controller/part.h`` and the head of ``sb_axis`` in ``control.h``.
"""

from __future__ import annotations

from collections.abc import Iterator

from stribeck.arm import Arm
from stribeck.export.structure import Structure, Unknown
from stribeck.export.units import Unit, unit_of
from stribeck.export.variable import Variable
from stribeck.simulate.axis import COURSES, Axis

CONSTANTS = tuple(f"reference.constant[{i + 1}]" for i in range(4))
# The doubles at the head of a joint's part of the loop: name, unit, what it is. The leakage is of
# gains of two units; what the constants of a reference are, its kind says.
NUMBERS: tuple[tuple[str, str | None, str], ...] = (
    ("kp", "N m/rad", "gain of the position error"),
    ("kv", "N m s/rad", "gain of the velocity error"),
    ("ki", "N m/(rad s)", "gain of the integrated position error"),
    ("inertia", "kg m^2", "feedforward of the reference's acceleration"),
    ("velocity_filter", "s", "time constant of the velocity's filter, 0 for none"),
    ("actuator_lag", "s", "not used: the lag belongs to the arm's FMU"),
    ("encoder_resolution", "rad", "resolution of the encoder, 0 for none"),
    ("torque_limit", "N m", "largest commanded torque"),
    ("compensation.ratio", "1", "compensation over true friction"),
    ("compensation.dead_band", "rad/s", "velocity that counts as zero"),
    ("compensation.slope", "1/s", "adaptive: weight of the error"),
    ("compensation.leakage", None, "adaptive: sigma-modification"),
    ("compensation.inner", "rad", "error within which robust or adaptive compensation rests"),
    ("compensation.amplitude", "N m", "dither: amplitude"),
    ("compensation.omega", "rad/s", "dither: angular frequency"),
    ("compensation.gain[1]", "N m/rad", "adaptive: gain of C0"),
    ("compensation.gain[2]", "N m/rad", "adaptive: gain of C1"),
    ("compensation.gain[3]", "N m s^2/rad^3", "adaptive: gain of C2"),
    *(
        (f"{side}.{name}", unit, f"{name} of the compensated friction")
        for side in ("friction", "friction.backward")
        for name, unit in (("C0", "N m"), ("C1", "N m"), ("C2", "N m s/rad"), ("alpha", "rad/s"))
    ),
    *((name, None, "ramp: start, rate; sine: centre, amplitude, rad/s, phase; others: start") for name in CONSTANTS),
)
_REFERENCE = {"line": ("rad", "rad/s"), "sine": ("rad", "rad", "rad/s", "rad")}  # of the constants in use; else rad
NOT_NEGATIVE = frozenset(
    (
        "kv",
        "ki",
        "velocity_filter",
        "encoder_resolution",
        "torque_limit",
        "compensation.dead_band",
        "compensation.inner",
    )
)
LEAST_VELOCITY = 1e-9  # rad/s, over which the Stribeck part falls: it is divided by
LARGEST = 1e300  # in place of an infinite limit, which XML cannot carry


def numbers_of(axis: Axis) -> list[float]:
    """Return the values of `NUMBERS` for one joint."""
    head = [float(getattr(axis, field[0])) for field in Axis._fields_[:15]]
    return [*head, *map(float, axis.gain), *map(float, axis.friction), *map(float, axis.reference)]


def least(key: str) -> float | None:
    """Return the least value that one of `NUMBERS` may take; None where the laws take any."""
    name = key.rpartition(".")[2]
    if name == "alpha":
        return LEAST_VELOCITY
    return 0.0 if key in NOT_NEGATIVE or name in ("C0", "C1", "C2") else None


def variables_of(arm: Arm, sample_time: float, axes: list[Axis]) -> tuple[Variable, ...]:
    """Return all variables in the order of their value references."""
    return tuple(
        Variable(name, vr, causality, variability, text, unit, initial, start, lower)
        for vr, (name, causality, variability, text, unit, initial, start, lower) in enumerate(
            _rows(arm, sample_time, axes)
        )
    )


def structure_of(variables: tuple[Variable, ...]) -> Structure:
    """Return what the outputs depend on: the torque on what came before, the reference on time and its constants."""
    outputs, initial = [], []
    for output in (v for v in variables if v.causality == "output"):
        key, joint = output.name.rstrip("]").split("[")
        prefix = f"joint[{joint}].reference.constant"
        constants = tuple(v.vr for v in variables if v.name.startswith(prefix))
        held = key == "tau"
        outputs.append(Unknown(output.vr, () if held else (0,)))
        initial.append(Unknown(output.vr, () if held else (0, *constants)))
    return Structure(tuple(outputs), (), (), tuple(initial))


def _unit(key: str, unit: str | None, axis: Axis, prismatic: bool) -> Unit | None:
    """Return the unit of one of `NUMBERS`, None where it has none of its own; a dither and a sine turn on any axis."""
    turns = key == "compensation.omega"
    if key in CONSTANTS:
        place, course = CONSTANTS.index(key), COURSES[axis.reference_kind]
        unit = dict(enumerate(_REFERENCE.get(course, ("rad",)))).get(place)
        turns = place >= 2
    return None if unit is None else unit_of(unit, prismatic=prismatic and not turns)


_Row = tuple[str, str, str, str, Unit | None, str, float | None, float | None]


def _rows(arm: Arm, sample_time: float, axes: list[Axis]) -> Iterator[_Row]:
    straight = arm.joints[0].kind == "prismatic"
    yield "time", "independent", "continuous", "time", unit_of("s"), "", None, None
    yield "sample_time", "parameter", "fixed", "time between samples", unit_of("s"), "exact", sample_time, None
    signals = (
        ("q", "rad", "input", "measured position"),
        ("dq", "rad/s", "input", "measured velocity, used where the loop says so"),
        ("tau", "N m", "output", "commanded torque, held from sample to sample"),
        ("q_ref", "rad", "output", "reference position"),
        ("dq_ref", "rad/s", "output", "reference velocity"),
    )
    for key, unit, causality, text in signals:
        for j, name in enumerate(arm.names, 1):
            variability = "discrete" if key == "tau" else "continuous"
            start = 0.0 if causality == "input" else None
            initial = "calculated" if causality == "output" else ""
            shown = unit_of(unit, prismatic=straight)
            yield f"{key}[{j}]", causality, variability, f"{text} of joint {name}", shown, initial, start, None
    for j, (name, axis) in enumerate(zip(arm.names, axes, strict=True), 1):
        for (key, own, text), value in zip(NUMBERS, numbers_of(axis), strict=True):
            value = min(value, LARGEST)
            yield (
                f"joint[{j}].{key}",
                "parameter",
                "tunable",
                f"{text} (joint {name})",
                _unit(key, own, axis, straight),
                "exact",
                value,
                least(key),
            )
