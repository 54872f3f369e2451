"""What was sensed, kept: where something was met, and the heights of the ground."""

from ._elevation import Elevation, ElevationMapper, Look, View, aimed, view
from ._local import LocalMap, LocalMapper, bearing

__all__ = [
    "Elevation",
    "ElevationMapper",
    "LocalMap",
    "LocalMapper",
    "Look",
    "View",
    "aimed",
    "bearing",
    "view",
]
