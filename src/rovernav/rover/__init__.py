"""The rover described: presets, its own files, and where it can stand."""

from ._model import Rover
from ._reading import presets, read_rover
from ._standing import Reason, Standing, standing

__all__ = ["Reason", "Rover", "Standing", "presets", "read_rover", "standing"]
