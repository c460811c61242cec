"""The one list of effects, a line each; third parties add theirs through the entry point group ``stribeck.effects``.

Effects of one name are the laws of one family: an arm file or a diagnosis names the family and says the law.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib.metadata import entry_points

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
from stribeck.effects.declared import declared
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
from stribeck.effects.friction.history_heat import HistoryHeat
from stribeck.effects.friction.history_in_time import HistoryInTime
from stribeck.effects.friction.history_running_in import HistoryRunningIn
from stribeck.effects.friction.history_thixotropy import HistoryThixotropy
from stribeck.effects.friction.load_dependent_friction import LoadDependentFriction
from stribeck.effects.friction.load_dependent_friction_directional import LoadDependentFrictionDirectional
from stribeck.effects.friction.load_dependent_friction_motor import LoadDependentFrictionMotor
from stribeck.effects.friction.load_dependent_friction_net import LoadDependentFrictionNet
from stribeck.effects.friction.load_dependent_friction_weight import LoadDependentFrictionWeight
from stribeck.effects.friction.negative_damping import NegativeDamping
from stribeck.effects.friction.negative_damping_gaussian import NegativeDampingGaussian
from stribeck.effects.friction.position_dependent_friction import PositionDependentFriction
from stribeck.effects.friction.position_dependent_friction_harmonics import PositionDependentFrictionHarmonics
from stribeck.effects.friction.presliding import Presliding
from stribeck.effects.friction.presliding_elasto_plastic import PreslidingElastoPlastic
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
from stribeck.model.effect import Effect

_OWN: tuple[type[Effect], ...] = (
    AsymmetricFriction,
    NegativeDamping,
    NegativeDampingGaussian,
    Presliding,
    PreslidingMaxwellSlip,
    PreslidingElastoPlastic,
    FrictionalLag,
    FrictionalLagDelay,
    FrictionalLagFallingPart,
    FrictionalLagWholeCurve,
    DwellTime,
    DwellTimeAgeing,
    DwellTimeAtRest,
    DwellTimeFrozen,
    History,
    HistoryHeat,
    HistoryRunningIn,
    HistoryInTime,
    HistoryThixotropy,
    LoadDependentFriction,
    LoadDependentFrictionDirectional,
    LoadDependentFrictionMotor,
    LoadDependentFrictionNet,
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

    An effect of another package may add a name, or a law of its own to a name that is known. One that is declared
    wrongly raises :class:`InputError`, which names the package: what is left out would be missed by nobody.
    """
    effects = {(kind.name, kind.law): kind() for kind in _OWN}
    for point in entry_points(group="stribeck.effects"):
        effect = declared(point, effects)
        effects[effect.name, effect.law] = effect
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
