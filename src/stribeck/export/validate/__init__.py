"""Check FMUs, ours and others': description, binaries, sources, names, units, and a simulation."""

from stribeck.export.validate.check import Validation, check_fmu, validate_fmu

__all__ = ["Validation", "check_fmu", "validate_fmu"]
