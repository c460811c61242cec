"""The arm: one value, and one file format, for the nominal, the fitted and the corrected model."""

from stribeck.arm.doubts import doubtful_values
from stribeck.arm.file import arm_to_toml, load_arm, save_arm
from stribeck.arm.units import factors, is_unit, unit_at, with_unit
from stribeck.arm.values import Arm, EffectEntry, Friction, Joint, Tolerance

__all__ = [
    "Arm",
    "EffectEntry",
    "Friction",
    "Joint",
    "Tolerance",
    "arm_to_toml",
    "doubtful_values",
    "factors",
    "is_unit",
    "load_arm",
    "save_arm",
    "unit_at",
    "with_unit",
]
