"""The ground of worlds as sensors see it, rocks on it; made once for each ground."""

from __future__ import annotations

import functools

import numpy as np

from ..core import F32
from ..kernels import ridges, rocks
from ._world import Ground, Rocks, Worlds


def seen(world: Worlds) -> ridges.GroundArrays:
    """The ground of all worlds, with the rocks that stand on it, as kernels look at it."""
    if world.ground is None:
        return _NOTHING
    return _raised(world.ground, world.rocks)


@functools.lru_cache(maxsize=4)  # grounds are frozen, and compared by identity
def _raised(ground: Ground, strewn: Rocks | None) -> ridges.GroundArrays:
    heights = ground.height if ground.height.ndim == 3 else ground.height[None]
    if strewn is not None:
        heights = _with_rocks(ground, strewn)
    heights = np.ascontiguousarray(heights)
    levels = ridges.levels_of(*ground.frame.shape)
    tops = np.empty((len(heights), levels[-1]), np.float32)
    for array in (heights, levels):
        array.flags.writeable = False
    ridges.tops_of(heights, levels, tops)
    tops.flags.writeable = False
    return ridges.GroundArrays(heights, float(ground.frame.cell), tops, levels)


def _with_rocks(ground: Ground, strewn: Rocks) -> F32:
    """Heights of each world (w, h, w), raised to the tops of its rocks."""
    cell, out = ground.frame.cell, []
    for i in range(len(strewn.offsets) - 1):
        rise = np.zeros(ground.frame.shape)
        place = strewn.of_world(i).place / (cell, cell, cell, 1.0)
        rocks.raise_rocks(np.ascontiguousarray(place), rise)
        out.append((ground.of_world(i).height + rise).astype(np.float32))
    return np.stack(out)


def _read_only(shape: tuple[int, ...], kind: type) -> np.ndarray:
    out = np.zeros(shape, kind)
    out.flags.writeable = False
    return out


_NOTHING = ridges.GroundArrays(
    _read_only((0, 0, 0), np.float32), 1.0, _read_only((0, 0), np.float32),
    _read_only((1,), np.int64),
)  # fmt: skip
