"""Elevation models read and generated; rocks and craters; slope, steps and shaded relief."""

from ._elevation import Terrain
from ._hills import add_crater, hills
from ._reading import read_terrain
from ._relief import Planes, hillshade, ledge_height, planes_over, slope, slope_over, step_height
from ._rocks import Rocks, rock_cover, scatter_rocks, with_rocks

__all__ = [
    "Planes",
    "Rocks",
    "Terrain",
    "add_crater",
    "hills",
    "hillshade",
    "ledge_height",
    "planes_over",
    "read_terrain",
    "rock_cover",
    "scatter_rocks",
    "slope",
    "slope_over",
    "step_height",
    "with_rocks",
]
