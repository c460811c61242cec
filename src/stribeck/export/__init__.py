"""FMUs: an arm as one file that simulation tools import on any platform."""

from stribeck.export.build import PLATFORMS
from stribeck.export.export import DEFAULT_FMI, export_fmu

__all__ = ["DEFAULT_FMI", "PLATFORMS", "export_fmu"]
