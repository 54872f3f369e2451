"""rovernav: all layers, and where the rover can stand alone."""

from __future__ import annotations

from typing import Any

from harness.model import Trial

from . import task


def _ready(size: int) -> tuple[Any, Any]:
    from rovernav.core import Frame
    from rovernav.rover import read_rover
    from rovernav.terrain import Terrain

    z = task.heights(size)
    frame = Frame(cell=task.CELL, shape=z.shape)
    terrain = Terrain(frame=frame, height=z, offset=0.0, name="ground", source="generated")
    return terrain, read_rover("perseverance")


def whole(size: int) -> Trial:
    """`hazards`: eight layers."""
    from rovernav.rover import hazards

    terrain, rover = _ready(size)
    return task.calls(lambda: float(hazards(terrain, rover).blocked.sum()))


def standing_alone(size: int) -> Trial:
    """`standing`: slope, steps and forbidden ground."""
    from rovernav.rover import standing

    terrain, rover = _ready(size)
    return task.calls(lambda: float(standing(terrain, rover).blocked.sum()))
