"""The one list of effects, a line each; third parties add theirs through the entry point group ``stribeck.effects``.

Effects of one name are the laws of one family: an arm file or a diagnosis names the family and says the law.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from importlib.metadata import entry_points

from stribeck.arm import Arm, EffectEntry, unit_at
from stribeck.effects.actuator.actuator_lag import ActuatorLag
from stribeck.effects.actuator.actuator_lag_magnitude_optimum import ActuatorLagMagnitudeOptimum
from stribeck.effects.actuator.actuator_lag_two_poles import ActuatorLagTwoPoles
from stribeck.effects.actuator.cogging import Cogging
from stribeck.effects.actuator.cogging_two_waves import CoggingTwoWaves
from stribeck.effects.actuator.delay import Delay
from stribeck.effects.actuator.torque_dead_zone import TorqueDeadZone
from stribeck.effects.actuator.torque_dead_zone_threshold import TorqueDeadZoneThreshold
from stribeck.effects.actuator.torque_gain import TorqueGain
from stribeck.effects.actuator.torque_offset import TorqueOffset
from stribeck.effects.actuator.torque_ripple import TorqueRipple
from stribeck.effects.actuator.torque_ripple_two_waves import TorqueRippleTwoWaves
from stribeck.effects.actuator.torque_saturation import TorqueSaturation
from stribeck.effects.actuator.torque_saturation_back_emf import TorqueSaturationBackEmf
from stribeck.effects.actuator.torque_saturation_smooth import TorqueSaturationSmooth
from stribeck.effects.external.cable_spring import CableSpring
from stribeck.effects.external.cable_spring_hardening import CableSpringHardening
from stribeck.effects.external.contact import Contact
from stribeck.effects.external.contact_linear import ContactLinear
from stribeck.effects.external.contact_plane import ContactPlane
from stribeck.effects.external.contact_plane_linear import ContactPlaneLinear
from stribeck.effects.external.input_disturbance import InputDisturbance
from stribeck.effects.external.input_disturbance_harmonics import InputDisturbanceHarmonics
from stribeck.effects.friction.asymmetric_friction import AsymmetricFriction
from stribeck.effects.friction.dwell_time import DwellTime
from stribeck.effects.friction.dwell_time_ageing import DwellTimeAgeing
from stribeck.effects.friction.dwell_time_at_rest import DwellTimeAtRest
from stribeck.effects.friction.dwell_time_frozen import DwellTimeFrozen
from stribeck.effects.friction.frictional_lag import FrictionalLag
from stribeck.effects.friction.frictional_lag_delay import FrictionalLagDelay
from stribeck.effects.friction.frictional_lag_falling_part import FrictionalLagFallingPart
from stribeck.effects.friction.frictional_lag_whole_curve import FrictionalLagWholeCurve
from stribeck.effects.friction.history import History
from stribeck.effects.friction.history_in_time import HistoryInTime
from stribeck.effects.friction.history_running_in import HistoryRunningIn
from stribeck.effects.friction.history_thixotropy import HistoryThixotropy
from stribeck.effects.friction.load_dependent_friction import LoadDependentFriction
from stribeck.effects.friction.load_dependent_friction_directional import LoadDependentFrictionDirectional
from stribeck.effects.friction.load_dependent_friction_motor import LoadDependentFrictionMotor
from stribeck.effects.friction.load_dependent_friction_weight import LoadDependentFrictionWeight
from stribeck.effects.friction.negative_damping import NegativeDamping
from stribeck.effects.friction.negative_damping_gaussian import NegativeDampingGaussian
from stribeck.effects.friction.position_dependent_friction import PositionDependentFriction
from stribeck.effects.friction.position_dependent_friction_harmonics import PositionDependentFrictionHarmonics
from stribeck.effects.friction.presliding import Presliding
from stribeck.effects.friction.presliding_maxwell_slip import PreslidingMaxwellSlip
from stribeck.effects.friction.quadratic_damping import QuadraticDamping
from stribeck.effects.rigid_body.base_flexibility import BaseFlexibility
from stribeck.effects.rigid_body.base_flexibility_sliding import BaseFlexibilitySliding
from stribeck.effects.rigid_body.gravity_tilt import GravityTilt
from stribeck.effects.rigid_body.payload import Payload
from stribeck.effects.sensing.encoder_eccentricity import EncoderEccentricity
from stribeck.effects.sensing.encoder_eccentricity_two_waves import EncoderEccentricityTwoWaves
from stribeck.effects.sensing.encoder_offset import EncoderOffset
from stribeck.effects.sensing.encoder_quantisation import EncoderQuantisation
from stribeck.effects.sensing.time_shift import TimeShift
from stribeck.effects.sensing.time_shift_all_joints import TimeShiftAllJoints
from stribeck.effects.sensing.velocity_filter import VelocityFilter
from stribeck.effects.transmission.backlash import Backlash
from stribeck.effects.transmission.joint_flexibility import JointFlexibility
from stribeck.errors import InputError
from stribeck.model.effect import Effect, RigidBodyEffect, TransmissionEffect
from stribeck.model.layout import Placed

_OWN: tuple[type[Effect], ...] = (
    AsymmetricFriction,
    NegativeDamping,
    NegativeDampingGaussian,
    Presliding,
    PreslidingMaxwellSlip,
    FrictionalLag,
    FrictionalLagDelay,
    FrictionalLagFallingPart,
    FrictionalLagWholeCurve,
    DwellTime,
    DwellTimeAgeing,
    DwellTimeAtRest,
    DwellTimeFrozen,
    History,
    HistoryRunningIn,
    HistoryInTime,
    HistoryThixotropy,
    LoadDependentFriction,
    LoadDependentFrictionDirectional,
    LoadDependentFrictionMotor,
    LoadDependentFrictionWeight,
    PositionDependentFriction,
    PositionDependentFrictionHarmonics,
    QuadraticDamping,
    ActuatorLag,
    ActuatorLagTwoPoles,
    ActuatorLagMagnitudeOptimum,
    Delay,
    TorqueGain,
    TorqueOffset,
    TorqueSaturation,
    TorqueSaturationBackEmf,
    TorqueSaturationSmooth,
    TorqueDeadZone,
    TorqueDeadZoneThreshold,
    Cogging,
    CoggingTwoWaves,
    TorqueRipple,
    TorqueRippleTwoWaves,
    JointFlexibility,
    Backlash,
    EncoderEccentricity,
    EncoderEccentricityTwoWaves,
    EncoderOffset,
    EncoderQuantisation,
    VelocityFilter,
    TimeShift,
    TimeShiftAllJoints,
    Payload,
    GravityTilt,
    BaseFlexibility,
    BaseFlexibilitySliding,
    CableSpring,
    CableSpringHardening,
    Contact,
    ContactLinear,
    ContactPlane,
    ContactPlaneLinear,
    InputDisturbance,
    InputDisturbanceHarmonics,
)


@cache
def laws() -> Mapping[tuple[str, str], Effect]:
    """Return every known effect by name and law, the library's own first; the first law of a name is its default.

    An effect of another package may add a name, or a law of its own to a name that is known.
    """
    effects = {(kind.name, kind.law): kind() for kind in _OWN}
    for point in entry_points(group="stribeck.effects"):
        effect = point.load()()
        if effect.law or effect.name not in {name for name, _ in effects}:
            effects.setdefault((effect.name, effect.law), effect)
    return effects


@cache
def registry() -> Mapping[str, Effect]:
    """Return every family by name, as its first law, the library's own first."""
    families: dict[str, Effect] = {}
    for effect in laws().values():
        families.setdefault(effect.name, effect)
    return families


def effect_named(name: str, law: str | None = None, where: str = "") -> Effect:
    """Return one effect by its contract name, of the law given or the family's first; raise :class:`InputError`.

    Its message names the key ``effect`` or ``law``, with ``where`` they stand before it.
    """
    if name not in registry():
        raise InputError(f"{where}effect is not a known effect", repr(name), f"use one of: {', '.join(registry())}")
    if law is None:
        return registry()[name]
    if (name, law) not in laws():
        known = ", ".join(other for family, other in laws() if family == name and other)
        do = f"use one of: {known}" if known else "leave law out"
        raise InputError(f"{where}law is not a law of {name}", repr(law), do)
    return laws()[name, law]


def placed_effects(arm: Arm, source: str = "") -> tuple[Placed, ...]:
    """Return the effects of an arm, each at its joints, parameters checked.

    Parameters
    ----------
    arm : Arm
    source : str
        The file that it comes from, for the message; the arm's name where none is given.

    Raises
    ------
    InputError
        One line: the source, the key, what was found there and what to do.
    """
    source = source or f"arm {arm.name!r}"
    placed: list[Placed] = []
    for k, entry in enumerate(arm.effects):
        where = f"{source}: effects[{k}]"
        for joint in entry.joints:
            place = _place(arm, entry, joint, where)
            for other in placed:
                shared = set(place.joints(arm.n)) & set(other.joints(arm.n))
                if shared and other.effect.name == place.effect.name:
                    name = arm.names[min(shared)]
                    raise InputError(f"{where}: {place.effect.name} is given twice", name, "keep one law at a joint")
                both = isinstance(place.effect, TransmissionEffect) and isinstance(other.effect, TransmissionEffect)
                if both and other.joint == place.joint:
                    what = f"{where}: {place.effect.name} beside {other.effect.name}, two transmissions at one joint"
                    raise InputError(what, joint, "keep one of them")
            placed.append(place)
    return tuple(placed)


def _place(arm: Arm, entry: EffectEntry, joint: str, where: str) -> Placed:
    effect = effect_named(entry.effect, entry.law, f"{where}.")
    place = arm.names.index(joint)
    # a payload may hang on any link, and tilted gravity be stated at any joint; a base is under the first
    bound = effect.everywhere or (effect.whole_arm and not isinstance(effect, RigidBodyEffect))
    if bound and place not in effect.sites(arm.n):
        first = arm.names[effect.sites(arm.n)[0]]
        what = "holds at all joints and is" if effect.everywhere else "is of the whole arm and"
        raise InputError(f"{where}.joints: {effect.label} {what} given once", joint, f"give it at joint {first}")
    if bound and not effect.applies(arm, place):
        raise InputError(f"{where}: {effect.label} is no law for this kind of arm", arm.name, "give another law")
    given = dict(entry.parameters.get(joint, {}))
    _check_values(effect, given, arm.joints[place].kind, f"{where}.parameters.{joint}")
    return Placed(effect, place, given)


def _check_values(effect: Effect, given: Mapping[str, float], kind: str, where: str) -> None:
    known = {parameter.name for parameter in effect.parameters}
    for name in given:
        if name not in known:
            raise InputError(f"{where}.{name} is not a known key", "", f"use one of: {', '.join(sorted(known))}")
    for parameter in effect.parameters:
        value = given.get(parameter.name, parameter.null)
        if not parameter.lower <= value <= parameter.upper and value != parameter.null:
            bounds = f"{parameter.lower:g} to {parameter.upper:g} {unit_at(parameter.unit, kind)}"
            raise InputError(f"{where}.{parameter.name} is out of bounds", f"{value:g}", f"give {bounds}")
    for parameter in effect.parameters:
        if given and parameter.name not in given and not math.isfinite(parameter.null):
            what, do = f"{where}.{parameter.name} is missing", f"give it: without it there is no {effect.name}"
            raise InputError(what, "", do)


def entries_of(arm: Arm, placed: tuple[Placed, ...]) -> tuple[EffectEntry, ...]:
    """Return placed effects as arm-file entries, effects of one name and law gathered over joints."""
    grouped: dict[tuple[str, str], list[Placed]] = {}
    for place in placed:
        grouped.setdefault((place.effect.name, place.effect.law), []).append(place)
    return tuple(
        EffectEntry(
            name,
            tuple(arm.names[place.joint] for place in places),
            {arm.names[place.joint]: dict(place.values) for place in places},
            law or None,
        )
        for (name, law), places in grouped.items()
    )
