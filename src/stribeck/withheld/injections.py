"""Hidden effects: from a name and physical parameters to what the plant does.

What the names leave open:

- friction acts on the motor side of a flexible joint or of backlash, where the encoder sits as well;
- ``presliding``: stiffness of the unloaded contact; it gives way along F (1 - exp(-stiffness x / F)), in closed loops;
- ``load_dependent_friction``: ratio of friction to the torque that the rotor passes on to the link (the command less
  friction and less the rotor's own inertia); where ``input`` is 1, to what enters (friction not taken off), where it
  is 2, to all that the motor gives, where it is 3, to what holds the link against gravity, where it is 4, to what dry
  friction leaves of all that the motor gives;
- ``frictional_lag``: of all friction, or, where ``drop`` is 1, of the part that falls with the speed alone;
- ``negative_damping``: falls as exp(-v / velocity), or, where ``squared`` is 1, as exp(-(v / velocity)^2);
- ``asymmetric_friction``: forward minus backward constants, the mean stays;
- ``history``: relative change of the level when as much friction power as `power` has flowed for long, or, where that
  is 0, when long time has passed; or, where `work` is given, when the contact is new: what is left of it falls to 1/e
  with that much work of friction, J, and the part `lost` of what is gone is back at the next recording;
- ``actuator_lag``: a pole, and where ``again`` is given another one behind it; where ``damping`` is, two that swing
  and are late by ``time`` at low frequency;
- ``torque_saturation``: the ``sharp``-er, the later u (1 + (u / limit)^sharp)^(-1 / sharp) bends; 0 is a corner;
- ``time_shift``: positive where the recorded position is late, q[i] being the position at t[i] - time;
- ``torque_dead_zone``: the torque below which nothing comes through, on either side; with a ``jump`` of 1 it all does
  beyond, of 0 what goes beyond;
- ``contact``: a stop of the joint, rad, where a ``damper`` may stand, N m s/rad; where the ``direction`` of its normal
  is given, a wall in the plane, m;
- ``torque_ripple``: relative, at the rotor's angle; ``cogging`` the same in N m;
- ``gravity_tilt``: change of gravity in the arm's plane, m/s^2; ``base_flexibility``: rocking about the first axis,
  rad, or about a foot at (foot_x, foot_y) from it, m; where the ``direction`` is given, sliding along it, m.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

from stribeck.arm import Arm
from stribeck.errors import StribeckError
from stribeck.withheld import special
from stribeck.withheld.plant import MAX_FRICTION_LAG, Plant, plant_of
from stribeck.withheld.special import Disturbance


class Injection(NamedTuple):
    """One hidden effect: its name, its joint, and parameters in SI units (those left out take their defaults)."""

    effect: str
    joint: str
    params: Mapping[str, float] = {}


@dataclass(frozen=True)
class Setup:
    """The plant with its hidden effects, and the disturbances that drive it, with their joints."""

    plant: Plant
    disturbances: tuple[tuple[int, Disturbance], ...] = ()


@dataclass(frozen=True)
class Rule:
    """How an effect enters the plant.

    Attributes
    ----------
    null : mapping
        Parameters at which the effect vanishes; its keys are the parameters that must be given.
    defaults : mapping
        Further parameters.
    fields : mapping or callable
        Parameter to field of the joint, or a function (plant, joint index, parameters) to the changed plant.
    disturbance : str or None
        Kind of the disturbance, for effects that are a signal.
    """

    null: Mapping[str, float]
    defaults: Mapping[str, float]
    fields: Mapping[str, str] | Callable[[Plant, int, Mapping[str, float]], Plant]
    disturbance: str | None = None

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of all parameters."""
        return (*self.null, *self.defaults)


def _same(*names: str) -> dict[str, str]:
    return {name: name for name in names}


_PERIODIC = {"amplitude": "{}_amplitude", "harmonic": "{}_harmonic", "phase": "{}_phase"}


def _periodic(prefix: str) -> dict[str, str]:
    return {name: field.format(prefix) for name, field in _PERIODIC.items()}


_NO_OVERTONE = {"overtone": 0.0, "overtone_phase": 0.0}


def _overtone(prefix: str) -> dict[str, str]:
    return {name: f"{prefix}_{name}" for name in _NO_OVERTONE}


# Effects that a library may hold. Units: N m, rad, s, kg, and their products.
KNOWN: dict[str, Rule] = {
    "asymmetric_friction": Rule({"C0": 0.0}, {"C1": 0.0, "C2": 0.0}, special.asymmetric),
    "negative_damping": Rule(
        {"amount": 0.0}, {"velocity": 0.1, "squared": 0.0},
        {"amount": "stribeck_torque", "velocity": "stribeck_velocity", "squared": "stribeck_squared"},
    ),
    "presliding": Rule({"stiffness": math.inf}, {"damping": 0.0}, special.presliding),
    "frictional_lag": Rule({"time": 0.0}, {"drop": 0.0}, {"time": "friction_lag", "drop": "friction_lag_drop"}),
    "dwell_time": Rule(
        {"rise": 0.0}, {"time": 2.0, "distance": 0.02},
        {"rise": "dwell_rise", "time": "dwell_time", "distance": "dwell_distance"},
    ),
    "history": Rule(
        {"change": 0.0}, {"time": 20.0, "power": 5.0, "work": 0.0, "lost": 0.0},
        {"change": "warm_change", "time": "warm_time", "power": "warm_power", "work": "wear_work", "lost": "wear_lost"},
    ),
    "position_dependent_friction": Rule(
        {"amplitude": 0.0}, {"harmonic": 1.0, "phase": 0.0, **_NO_OVERTONE}, _periodic("wave") | _overtone("wave")
    ),
    "load_dependent_friction": Rule({"ratio": 0.0}, {"input": 0.0}, {"ratio": "load_ratio", "input": "load_input"}),
    "quadratic_damping": Rule({"coefficient": 0.0}, {}, {"coefficient": "quadratic"}),
    "actuator_lag": Rule(
        {"time": 0.0}, {"again": 0.0, "damping": 0.0}, {"time": "lag", "again": "lag_again", "damping": "lag_damping"}
    ),
    "delay": Rule({"time": 0.0}, {}, {"time": "delay"}),
    "torque_gain": Rule({"gain": 1.0}, {}, _same("gain")),
    "torque_offset": Rule({"offset": 0.0}, {}, _same("offset")),
    "torque_saturation": Rule(
        {"limit": math.inf}, {"fade": 0.0, "sharp": 0.0},
        {"limit": "saturation", "fade": "saturation_fade", "sharp": "saturation_bend"},
    ),
    "torque_dead_zone": Rule({"width": 0.0}, {"jump": 0.0}, {"width": "dead_zone", "jump": "dead_zone_jump"}),
    "cogging": Rule(
        {"amplitude": 0.0}, {"harmonic": 12.0, "phase": 0.0, **_NO_OVERTONE},
        _periodic("cogging") | _overtone("cogging"),
    ),
    "torque_ripple": Rule(
        {"ratio": 0.0}, {"harmonic": 6.0, "phase": 0.0, **_NO_OVERTONE},
        {"ratio": "ripple_ratio", "harmonic": "ripple_harmonic", "phase": "ripple_phase", **_overtone("ripple")},
    ),
    "joint_flexibility": Rule({"stiffness": math.inf}, {"damping": math.nan}, special.flexible),
    "backlash": Rule({"gap": 0.0}, {"stiffness": math.nan, "damping": math.nan}, special.backlash),
    "encoder_eccentricity": Rule(
        {"amplitude": 0.0}, {"harmonic": 1.0, "phase": 0.0, **_NO_OVERTONE},
        {"amplitude": "eccentricity", "harmonic": "eccentricity_harmonic", "phase": "eccentricity_phase",
         **_overtone("eccentricity")},
    ),
    "encoder_offset": Rule({"offset": 0.0}, {}, {"offset": "encoder_offset"}),
    "encoder_quantisation": Rule({"resolution": 0.0}, {}, special.coarse),
    "velocity_filter": Rule({"time": 0.0}, {}, {"time": "velocity_lag"}),
    "time_shift": Rule({"time": 0.0}, {}, {"time": "time_shift"}),
    "payload": Rule({"mass": 0.0}, {"inertia": 0.0}, special.payload),
    "gravity_tilt": Rule({"x": 0.0, "y": 0.0}, {}, special.tilted),
    "base_flexibility": Rule(
        {"stiffness": math.inf},
        dict.fromkeys(("damping", "inertia", "mass", "direction", "foot_x", "foot_y"), math.nan),
        special.soft_base,
    ),
    "cable_spring": Rule(
        {"stiffness": 0.0}, {"rest": 0.0, "cubic": 0.0},
        {"stiffness": "cable_stiffness", "rest": "cable_rest", "cubic": "cable_cubic"},
    ),
    "contact": Rule(
        {"stiffness": 0.0},
        {"position": 0.5, "side": 1.0, "damping": 0.5, "exponent": 1.5, "damper": 0.0, "direction": math.nan},
        special.wall,
    ),
    "input_disturbance": Rule(
        {"noise": 0.0, "amplitude": 0.0}, {"bandwidth": 10.0, "frequency": 3.0, "phase": 0.0, "duty": 0.0}, {},
        "torque",
    ),
}  # fmt: skip

# Effects that no library holds, to see whether a diagnoser abstains.
UNKNOWN: dict[str, Rule] = {
    "supply_bang": Rule(
        {"torque": 0.0}, {"frequency": 7.0, "speed": 0.3}, {n: f"supply_{n}" for n in ("torque", "frequency", "speed")}
    ),
    "loaded_sticky_spot": Rule(
        {"torque": 0.0}, {"centre": 0.0, "width": 0.2, "load": 0.0},
        {n: f"sticky_{n}" for n in ("torque", "centre", "width", "load")},
    ),
    "friction_jumps": Rule({"change": 0.0}, {"rate": 1.0}, {}, "factor"),
    "tendon_coupling": Rule({"stiffness": 0.0}, {"ratio": 1.0, "slack": 0.0}, special.tendon),
    "hardening_gain": Rule({"change": 0.0}, {"torque": 10.0}, {"change": "hardening", "torque": "hardening_torque"}),
    "sloshing_mass": Rule(
        {"mass": 0.0}, dict.fromkeys(("arm", "length", "stiffness", "damping"), math.nan), special.sloshing
    ),
}  # fmt: skip

RULES: Mapping[str, Rule] = KNOWN | UNKNOWN


def null(effect: str, joint: str) -> Injection:
    """Return the effect at the values where it vanishes."""
    return Injection(effect, joint, dict(_rule(effect).null))


def assemble(arm: Arm, effects: Iterable[Injection]) -> Setup:
    """Return the plant of `arm` with `effects` put into it, in their order.

    Raises
    ------
    StribeckError
        For an effect, a joint or a parameter that the plant does not know, or a value that it cannot take.
    """
    setup = Setup(plant_of(arm))
    for item in effects:
        injection = Injection(*item)
        setup = _put(setup, injection, _joint_index(arm, injection.joint))
    return setup


def _put(setup: Setup, injection: Injection, k: int) -> Setup:
    rule = _rule(injection.effect)
    params = _complete(rule, injection)
    if injection.effect == "frictional_lag" and not 0.0 <= params["time"] <= MAX_FRICTION_LAG:
        raise StribeckError("frictional_lag time is out of range", str(params["time"]), f"0 to {MAX_FRICTION_LAG} s")
    if rule.disturbance:
        item = (k, Disturbance(rule.disturbance, params))
        return replace(setup, disturbances=(*setup.disturbances, item))
    if callable(rule.fields):
        return replace(setup, plant=rule.fields(setup.plant, k, params))
    values = {rule.fields[name]: value for name, value in params.items()}
    return replace(setup, plant=setup.plant.with_joint(k, **values))


def _complete(rule: Rule, injection: Injection) -> dict[str, float]:
    for name in injection.params:
        if name not in rule.parameters:
            raise StribeckError(
                f"{injection.effect} has no such parameter", name, f"it takes {', '.join(rule.parameters)}"
            )
    missing = [name for name in rule.null if name not in injection.params]
    if missing:
        raise StribeckError(f"{injection.effect} needs the parameter {missing[0]}", "", "give it")
    return {**rule.defaults, **injection.params}


def _rule(effect: str) -> Rule:
    if effect not in RULES:
        raise StribeckError("the plant has no such effect", effect, f"it has {', '.join(RULES)}")
    return RULES[effect]


def _joint_index(arm: Arm, joint: str) -> int:
    if joint not in arm.names:
        raise StribeckError("the arm has no such joint", joint, f"its joints are {', '.join(arm.names)}")
    return arm.names.index(joint)
