"""What is worked out from a grid or from heights once, and kept while these are in use."""

from __future__ import annotations

from typing import Any
from weakref import WeakKeyDictionary, finalize

import numpy as np

from ..kernels import rays, ridge_tops, ridges
from ._world import Grid

CELLS_PER_BEAM = 36
"""A beam without a table takes as long as this many cells of making one."""
POSTS_PER_BEAM = 20
"""The same for a beam over heights, in posts."""
MOST_ENTRIES = 2**29
"""Tables of more bytes than this are not made: four to a cell, eight to a post."""

_NONE = rays.ConeArrays(free=np.zeros((0, 0), np.uint8))
_NONE.free.flags.writeable = False


class _Kept:
    """The table of a grid, and how many beams did without."""

    def __init__(self) -> None:
        self.beams = 0
        self.cones: rays.ConeArrays = _NONE


_cones: WeakKeyDictionary[Grid, _Kept] = WeakKeyDictionary()


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


class _KeptTops:
    """The table of heights, and how many beams did without."""

    def __init__(self, heights: Any) -> None:
        self.beams = 0
        self.size = int(heights.size)
        self.fits = 8 * self.size <= MOST_ENTRIES and not bool(np.isinf(heights).any())
        self.tops: ridge_tops.TopArrays = _NO_TOPS


_NO_TOPS = ridge_tops.empty_tops(0, 0, 0)
_tops: dict[int, _KeptTops] = {}


def tops_of(ground: ridges.GroundArrays, *, beams: int) -> ridge_tops.TopArrays:
    """How high ground is at most in windows; empty where it does not pay yet, as in `cones_of`.

    Args:
        ground: The heights as beams see them; the table goes when these go.
        beams: How many are to be cast now.
    """
    heights = ground.heights
    if heights.size == 0:
        return _NO_TOPS
    kept = _tops.get(id(heights))
    if kept is None:
        kept = _tops[id(heights)] = _KeptTops(heights)
        finalize(heights, _tops.pop, id(heights), None)
    kept.beams += beams
    if kept.fits and not len(kept.tops.coarse) and kept.beams * POSTS_PER_BEAM >= kept.size:
        made = ridge_tops.empty_tops(*heights.shape)
        ridge_tops.fill_tops(heights, ground.cell, made)
        for array in made:
            array.flags.writeable = False
        kept.tops = made
    return kept.tops
