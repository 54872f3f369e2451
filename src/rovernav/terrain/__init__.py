"""Elevation models read, judged, written, made and refined; rocks and craters; slope and shade."""

from ._craters import Craters
from ._elevation import Terrain
from ._forms import Cliffs, Dunes, Pits
from ._hills import add_crater, hills
from ._making import Ground, Recipe, Relief
from ._measuring import measured
from ._metres import true_north
from ._occupancy import Occupancy, read_occupancy
from ._quality import Quality, quality
from ._raster import Raster, Window
from ._reading import open_raster, read_part, read_terrain
from ._recipes import read_recipe, recipe_data, recipe_of
from ._refining import Refined, refine
from ._relief import Planes, hillshade, ledge_height, planes_over, slope, slope_over, step_height
from ._rocks import RockField, Rocks, rock_count, rock_cover, scatter_rocks, with_rocks
from ._roughness import hurst_exponent, rms_slope, structure
from ._writing import write_geotiff, write_terrain

__all__ = [
    "Cliffs",
    "Craters",
    "Dunes",
    "Ground",
    "Occupancy",
    "Pits",
    "Planes",
    "Quality",
    "Raster",
    "Recipe",
    "Refined",
    "Relief",
    "RockField",
    "Rocks",
    "Terrain",
    "Window",
    "add_crater",
    "hills",
    "hillshade",
    "hurst_exponent",
    "ledge_height",
    "measured",
    "open_raster",
    "planes_over",
    "quality",
    "read_occupancy",
    "read_part",
    "read_recipe",
    "read_terrain",
    "recipe_data",
    "recipe_of",
    "refine",
    "rms_slope",
    "rock_count",
    "rock_cover",
    "scatter_rocks",
    "slope",
    "slope_over",
    "step_height",
    "structure",
    "true_north",
    "with_rocks",
    "write_geotiff",
    "write_terrain",
]
