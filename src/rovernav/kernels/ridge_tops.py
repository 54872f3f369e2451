"""How high ground is at most in windows ahead of each patch, packed for `ridge_lanes.march`.

Blocks are 2 x 2 patches. A window of n blocks is square, n + 1 blocks on a side: a beam that runs
along its columns more than across them touches no other patch until it leaves the n-th block,
whichever of the two axes its columns follow. It opens from its block to higher or lower indices on
either axis, so there are four of each. Near the ground a beam asks for the two patches of a column.

Heights are whole numbers of grains over the lowest post, rounded up.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ._jit import kernel
from .ridge_lanes import BLOCK, LEAPS

MOST = 65_000
"""Grains from the lowest post to the highest one, at most."""
FINEST = 1e-4
"""A grain is at least this share of a cell."""


class TopArrays(NamedTuple):
    """The table of each grid of heights.

    Attributes:
        coarse: One row for each grid (g, m), uint32: quadrants in the order up and right, up and
            left, down and right, down and left in indices; (0, 0) where no table is used.
        fine: One row for each grid (g, 2 (h + 1) (w + 1) + 1), uint16: the higher of each patch and
            the next one along y, then of each and the next one along x, and an unused entry.
        low: Lowest post of each grid (g,) [m].
        grain: (g,) [m].
    """

    coarse: Any
    fine: Any
    low: Any
    grain: Any


def empty_tops(g: int, h: int, w: int) -> TopArrays:
    """Room for the tables of g grids of h x w posts; with no grid, the table that is not used."""
    rows, columns = blocks_of(h, w) if g else (0, 0)
    fine = 2 * (h + 1) * (w + 1) + 1 if g else 0
    return TopArrays(
        coarse=np.empty((g, 4 * rows * columns), np.uint32),
        fine=np.empty((g, fine), np.uint16),
        low=np.empty(g),
        grain=np.empty(g),
    )


@kernel()
def fill_tops(heights: Any, c: float, out: TopArrays) -> None:
    """Make the tables of grids.

    Args:
        heights: Of each grid (g, h, w), float32 [m]; missing posts (NaN) do not count.
        c: Distance of posts [m].
        out: Written.
    """
    h, w = heights.shape[1], heights.shape[2]
    codes, patches = _codes(), np.empty((h + 1, w + 1), np.int32)
    rows, columns = blocks_of(h, w)
    windows = np.empty((len(LEAPS), rows, columns), np.int32)
    for g in range(heights.shape[0]):
        low, grain = _scale(heights[g], c)
        out.low[g], out.grain[g] = low, grain
        _patches(heights[g], low, grain, patches)
        for n in range(len(LEAPS)):
            _blocks(patches, windows[n])
            _widen(windows[n], LEAPS[n] + 1)
        for quadrant in range(4):
            first = quadrant * rows * columns
            down, left = quadrant >= 2, quadrant % 2 == 1
            _pack(windows, down, left, codes, out.coarse[g, first : first + rows * columns])
        _pairs(patches, out.fine[g])


@kernel()
def _blocks(patches: Any, out: Any) -> None:
    """The highest patch of each block."""
    for m in range(out.shape[0]):
        for n in range(out.shape[1]):
            out[m, n] = 0
    for i in range(patches.shape[0]):
        for j in range(patches.shape[1]):
            m, n = i // BLOCK, j // BLOCK
            out[m, n] = max(out[m, n], patches[i, j])


@kernel()
def _pairs(patches: Any, out: Any) -> None:
    """The higher of each patch and the next one along y, then along x; the last entry is 0."""
    rows, columns = patches.shape
    for i in range(rows):
        for j in range(columns):
            at = i * columns + j
            out[at] = max(patches[i, j], patches[min(i + 1, rows - 1), j])
            out[at + rows * columns] = max(patches[i, j], patches[i, min(j + 1, columns - 1)])
    out[out.size - 1] = 0


@kernel()
def _scale(heights: Any, c: float) -> tuple[float, float]:
    """The lowest post and the grain [m]; 0 without posts."""
    low, high = np.inf, -np.inf
    for i in range(heights.shape[0]):
        for j in range(heights.shape[1]):
            z = np.float64(heights[i, j])
            low, high = z if z < low else low, z if z > high else high
    low, high = (low, high) if low <= high else (0.0, 0.0)
    return low, max((high - low) / MOST, FINEST * c)


@kernel()
def blocks_of(h: int, w: int) -> tuple[int, int]:
    """Rows and columns of blocks of an (h, w) grid."""
    return (h + BLOCK) // BLOCK, (w + BLOCK) // BLOCK


@kernel()
def _codes() -> Any:
    """The code of every whole number below 2^16: the least s 2^e that is not below it."""
    out = np.empty(1 << 16, np.uint8)
    for number in range(1 << 16):
        e = 0
        while (number + (1 << e) - 1) >> e > 15:
            e += 1
        out[number] = (e << 4) | ((number + (1 << e) - 1) >> e)
    return out


@kernel()
def _patches(heights: Any, low: float, grain: float, out: Any) -> None:
    """The highest post of each patch, in grains."""
    h, w = heights.shape
    row = np.empty(w, np.int32)
    for i in range(h + 1):
        for j in range(w + 1):
            out[i, j] = 0
    for i in range(h):
        for j in range(w):
            z = np.float64(heights[i, j])
            row[j] = math.ceil((z - low) / grain) if z == z else 0
        for m in (i, i + 1):
            for j in range(w):
                out[m, j] = max(out[m, j], row[j])
                out[m, j + 1] = max(out[m, j + 1], row[j])


@kernel()
def _widen(window: Any, side: int) -> None:
    """The highest of `side` x `side` patches from each one to higher indices."""
    h, w = window.shape
    done = 1
    while done < side:
        by = min(done, side - done)
        for i in range(h - by):  # from low to high: what is read is as it was
            for j in range(w):
                window[i, j] = max(window[i, j], window[i + by, j])
        for i in range(h):
            for j in range(w - by):
                window[i, j] = max(window[i, j], window[i, j + by])
        done += by


@kernel()
def _pack(windows: Any, down: bool, left: bool, codes: Any, out: Any) -> None:
    """Entries of one quadrant; a window that would begin beyond the edge begins there."""
    h, w = windows.shape[1], windows.shape[2]
    near, middle, far = LEAPS
    for i in range(h):
        i0, i1, i2 = (max(i - near, 0), max(i - middle, 0), max(i - far, 0)) if down else (i, i, i)
        for j in range(w):
            j0, j1, j2 = (j, j, j)
            if left:
                j0, j1, j2 = max(j - near, 0), max(j - middle, 0), max(j - far, 0)
            top = windows[0, i0, j0]
            more = codes[max(windows[1, i1, j1] - top, 0)]
            most = codes[max(windows[2, i2, j2] - top, 0)]
            out[i * w + j] = np.uint32(top) | (np.uint32(more) << 16) | (np.uint32(most) << 24)
