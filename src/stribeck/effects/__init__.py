"""The library of effects: one file each, the registry that lists them, and what an effect of one's own is written with.

A law is a class of one of the stages below that states its parameters and overrides the hooks that it changes; listed
under the entry point group ``stribeck.effects`` it is a candidate, an entry of arm files and part of every export.
"""

from stribeck.model.effect import (
    ActuatorEffect,
    Along,
    Effect,
    ExternalEffect,
    FrictionEffect,
    RigidBodyEffect,
    SensingEffect,
    StandEffect,
    TransmissionEffect,
)
from stribeck.model.scale import Scale
from stribeck.model.values import Body, Expression, Parameter, Parameters, Signals, States

__all__ = [
    "ActuatorEffect", "Along", "Body", "Effect", "Expression", "ExternalEffect", "FrictionEffect", "Parameter",
    "Parameters", "RigidBodyEffect", "Scale", "SensingEffect", "Signals", "StandEffect", "States", "TransmissionEffect",
]  # fmt: skip
