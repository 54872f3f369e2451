"""Elevation models read and generated; rocks and craters; slope, steps and shaded relief."""

from ._elevation import Terrain
from ._hills import add_crater, hills
from ._reading import read_terrain
from ._relief import gradient_over, hillshade, ledge_height, slope, slope_over, step_height
from ._rocks import Rocks, rock_cover, scatter_rocks, with_rocks

__all__ = [
    "Rocks",
    "Terrain",
    "add_crater",
    "gradient_over",
    "hills",
    "hillshade",
    "ledge_height",
    "read_terrain",
    "rock_cover",
    "scatter_rocks",
    "slope",
    "slope_over",
    "step_height",
    "with_rocks",
]
