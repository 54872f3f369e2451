"""Pictures, movies and pages of drives, trainings and ground, drawn without a window.

Nothing here loads the plotting library before a picture is asked for.
"""

from ._drive import draw_drive
from ._layers import draw_layer
from ._movie import draw_movie
from ._page import write_page
from ._paper import draw_paper_figure
from ._profile import draw_profile
from ._raster import data_uri, png
from ._relief import WHY, relief_pixels
from ._route import draw_route, draw_trip
from ._stage import Moment, Place, Stage
from ._surface import Surface, surface_of
from ._sweep import draw_sweep
from ._terrain import draw_terrain
from ._training import draw_training
from ._words import PALETTE, end_words
from ._worlds import draw_worlds

__all__ = [
    "PALETTE",
    "WHY",
    "Moment",
    "Place",
    "Stage",
    "Surface",
    "data_uri",
    "draw_drive",
    "draw_layer",
    "draw_movie",
    "draw_paper_figure",
    "draw_profile",
    "draw_route",
    "draw_sweep",
    "draw_terrain",
    "draw_training",
    "draw_trip",
    "draw_worlds",
    "end_words",
    "png",
    "relief_pixels",
    "surface_of",
    "write_page",
]
