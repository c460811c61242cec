"""Maps of verdict and amplitude over grids of loop settings."""

from stribeck.loop.maps.grid import SETTINGS, Axes, check_axes
from stribeck.loop.maps.label import Map, Told, label_map

__all__ = ["SETTINGS", "Axes", "Map", "Told", "check_axes", "label_map"]
