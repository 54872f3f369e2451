"""Ground and rocks of worlds made ready for one rover's wheels."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core import F32, F64, SettingError
from ..kernels.body import GroundArrays
from ..kernels.rocks import raise_rocks
from ..rover import Rover, surface
from ..terrain import Terrain
from ._world import Ground, Rocks, Worlds

FLAT_ROCK = 0.1
"""Rocks lower than this share of a wheel's radius are left out."""


def footing(worlds: Worlds, rover: Rover) -> GroundArrays:
    """The ground of `worlds` as the kernels of bodies take it.

    Rocks that the wheels climb are part of the ground that they rest on, those that fit under the
    belly of the ground below it; higher ones are obstacles.

    Raises:
        SettingError: The rover has no wheels, or rocks are too small for the ground's cells.
    """
    rocks, ground = worlds.rocks, worlds.ground
    place, offsets = _obstacles(rocks, rover, len(worlds.offsets))
    if ground is None:
        if rocks is not None:
            _refuse_without_ground(rocks, rover)
        return GroundArrays(_NONE, _NONE4, _NONE, _NONE, 1.0, 0.0, place, offsets)
    layers = len(worlds.offsets) - 1 if rocks is not None or ground.height.ndim == 3 else 1
    h, w = ground.frame.shape
    wheel, below, step = (np.empty((layers, h, w), np.float32) for _ in range(3))
    gradient = np.empty((layers, 2, h, w), np.float32)
    for i in range(layers):
        bare = ground.of_world(i)
        own = None if rocks is None else rocks.of_world(i).place
        on = surface(_terrain(bare, own, rover, rover.max_step), rover)
        wheel[i], gradient[i], step[i] = on.wheel, on.gradient, on.step
        below[i] = on.ground if own is None else _terrain(bare, own, rover, np.inf).height
    return GroundArrays(
        wheel, gradient, below, step, float(ground.frame.cell), float(ground.offset), place, offsets
    )


def _terrain(ground: Ground, rocks: F64 | None, rover: Rover, highest: float) -> Terrain:
    """Ground with those of its rocks set onto it that are no higher than `highest` [m]."""
    height: F32 = ground.height
    if rocks is not None and len(rocks):
        on = rocks[(rocks[:, 3] <= highest) & (rocks[:, 3] >= FLAT_ROCK * rover.wheel_radius)]
        if highest < np.inf:
            _check_fine(on, ground.frame.cell)
        rise = np.zeros(ground.frame.shape)
        cells = on / (ground.frame.cell, ground.frame.cell, ground.frame.cell, 1.0)
        raise_rocks(np.ascontiguousarray(cells), rise)
        height = (height + rise).astype(np.float32)
    return Terrain(
        frame=ground.frame, height=height, offset=ground.offset, name="world", source="a world"
    )


def _check_fine(rocks: F64, cell: float) -> None:
    """Raise unless each rock is at least two cells wide; the grid would widen narrower ones."""
    smallest = float(np.min(rocks[:, 2], initial=np.inf))
    if smallest < cell:
        raise SettingError(
            f"rocks of {2.0 * smallest:.3g} m are too small for ground with cells of {cell:.3g} m: "
            f"a rock that wheels drive over needs two cells; give finer ground (Ground.finer), "
            "or leave such rocks out"
        )


def _obstacles(rocks: Rocks | None, rover: Rover, ends: int) -> tuple[F64, Any]:
    """Rocks that block the rover somewhere, and where each world's begin."""
    if rocks is None:
        return np.empty((0, 4)), np.zeros(ends, np.int64)
    high = rocks.place[:, 3] > min(rover.max_step, rover.clearance)
    before = np.concatenate([[0], np.cumsum(high)])
    return np.ascontiguousarray(rocks.place[high]), before[rocks.offsets].astype(np.int64)


def _refuse_without_ground(rocks: Rocks, rover: Rover) -> None:
    high, least = rocks.place[:, 3], FLAT_ROCK * rover.wheel_radius
    if ((high >= least) & (high <= max(rover.max_step, rover.clearance))).any():
        raise SettingError(
            "rocks that a rover can drive over need ground to stand on; give the worlds a ground, "
            "level if you like"
        )


_NONE: Any = np.zeros((0, 0, 0), np.float32)
_NONE4: Any = np.zeros((0, 2, 0, 0), np.float32)
