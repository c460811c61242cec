"""Use FMUs: stand one in for the robot in a control loop."""

from stribeck.export.use.plant import FmuPlant, fmu_plant
from stribeck.export.use.simulate import load_fmu_loop, simulate_fmu

__all__ = ["FmuPlant", "fmu_plant", "load_fmu_loop", "simulate_fmu"]
