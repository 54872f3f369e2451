"""What is worked out from a grid or from heights once, and kept while these are in use."""

from __future__ import annotations

from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from ..kernels import rays, ridges
from ._world import Grid, Ground

CELLS_PER_BEAM = 36
"""A beam without a table takes as long as this many cells of making one."""
MOST_ENTRIES = 2**29
"""Tables of more bytes than this are not made: four to a cell, some more at the edges."""

_NONE = rays.ConeArrays(free=np.zeros((0, 0), np.uint8))
_FLAT = ridges.GroundArrays(
    heights=np.zeros((0, 0, 0), np.float32),
    cell=1.0,
    tops=np.zeros((0, 0), np.float32),
    levels=np.zeros(1, np.int64),
)
for _array in (_NONE.free, _FLAT.heights, _FLAT.tops):
    _array.flags.writeable = False


class _Kept:
    """The table of a grid, and how many beams did without."""

    def __init__(self) -> None:
        self.beams = 0
        self.cones: rays.ConeArrays = _NONE


_cones: WeakKeyDictionary[Grid, _Kept] = WeakKeyDictionary()
_grounds: WeakKeyDictionary[Ground, ridges.GroundArrays] = WeakKeyDictionary()


def cones_of(grid: Grid | None, *, beams: int) -> rays.ConeArrays:
    """Free distances of a grid; empty where there is no grid, or where they do not pay yet.

    They are made once the beams cast so far took as long as making them, so that a drive takes at
    most twice as long as if its length had been known. Readings are the same with and without.

    Args:
        grid: The grid of all worlds; held weakly.
        beams: How many are to be cast now.
    """
    if grid is None:
        return _NONE
    kept = _cones.setdefault(grid, _Kept())
    kept.beams += beams
    blocked: Any = grid.blocked if grid.blocked.ndim == 3 else grid.blocked[None]
    worth = kept.beams * CELLS_PER_BEAM >= blocked.size > 0
    if worth and not len(kept.cones.free):
        h, w = blocked.shape[1:]
        size = rays.table_size(h, w)
        if len(blocked) * size <= MOST_ENTRIES:
            free = np.empty((len(blocked), size), np.uint8)
            rays.free_cones(np.ascontiguousarray(blocked), free)
            free.flags.writeable = False
            kept.cones = rays.ConeArrays(free=free)
    return kept.cones


def ground_of(ground: Ground | None) -> ridges.GroundArrays:
    """Heights with the highest posts of their blocks, as `kernels.ridges` takes them."""
    if ground is None:
        return _FLAT
    kept = _grounds.get(ground)
    if kept is None:
        height: Any = ground.height if ground.height.ndim == 3 else ground.height[None]
        levels = ridges.levels_of(height.shape[1], height.shape[2])
        tops = np.empty((len(height), int(levels[-1])), np.float32)
        heights = np.ascontiguousarray(height)
        ridges.tops_of(heights, levels, tops)
        for array in (heights, tops):
            array.flags.writeable = False
        kept = ridges.GroundArrays(
            heights=heights, cell=float(ground.frame.cell), tops=tops, levels=levels
        )
        _grounds[ground] = kept
    return kept
