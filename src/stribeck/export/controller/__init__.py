"""A loop's sampled controllers as an FMU, and an SSP file that couples them to the arm's FMU."""

from stribeck.export.controller.export import export_controller
from stribeck.export.controller.system import export_system

__all__ = ["export_controller", "export_system"]
