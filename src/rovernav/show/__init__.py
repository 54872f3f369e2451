"""Pictures of drives, trainings and ground: PNG files, drawn without a window.

Nothing here loads the plotting library before a picture is asked for.
"""

from ._drive import draw_drive
from ._layers import draw_layer
from ._paper import draw_paper_figure
from ._profile import draw_profile
from ._relief import WHY, relief_pixels
from ._route import draw_route, draw_trip
from ._sweep import draw_sweep
from ._terrain import draw_terrain
from ._training import draw_training
from ._words import PALETTE, end_words
from ._worlds import draw_worlds

__all__ = [
    "PALETTE",
    "WHY",
    "draw_drive",
    "draw_layer",
    "draw_paper_figure",
    "draw_profile",
    "draw_route",
    "draw_sweep",
    "draw_terrain",
    "draw_training",
    "draw_trip",
    "draw_worlds",
    "end_words",
    "relief_pixels",
]
