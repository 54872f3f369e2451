"""The rover described: presets, its own files, where it can stand, how, and what driving costs."""

from ._bound import Bound, bound
from ._chassis import Chassis
from ._hazards import Hazards, Layer, hazards
from ._mobility import Mobility
from ._model import Rover
from ._reading import presets, read_rover
from ._settle import Pose, Settled, Surface, settle, surface
from ._soils import Soil, read_soil, soils
from ._standing import Reason, Standing, standing
from ._steering import Steering
from ._traction import DriveCost, cheapest, drive_cost, drive_table

__all__ = [
    "Bound",
    "Chassis",
    "DriveCost",
    "Hazards",
    "Layer",
    "Mobility",
    "Pose",
    "Reason",
    "Rover",
    "Settled",
    "Soil",
    "Standing",
    "Steering",
    "Surface",
    "bound",
    "cheapest",
    "drive_cost",
    "drive_table",
    "hazards",
    "presets",
    "read_rover",
    "read_soil",
    "settle",
    "soils",
    "standing",
    "surface",
]
