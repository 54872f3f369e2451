"""Coarse grids out of fine ones, and back.

Symbols: c cost per cell (h, w), inf where blocked; k cells to a side of a block; blocks at the
north and east edge may be smaller.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ._jit import kernel


@kernel()
def pool(c: Any, k: int, out: Any) -> None:
    """Write the mean cost of the free cells of each block to `out`; inf where none is free."""
    h, w = c.shape
    total = np.empty(out.shape[1])
    count = np.empty(out.shape[1], np.int64)
    for block in range(out.shape[0]):
        total[:] = 0.0
        count[:] = 0
        for i in range(block * k, min(h, (block + 1) * k)):
            for j in range(w):
                here = c[i, j]
                if here < np.inf:
                    total[j // k] += here
                    count[j // k] += 1
        for j in range(out.shape[1]):
            out[block, j] = total[j] / count[j] if count[j] > 0 else np.inf


@kernel()
def unpool(c: Any, chosen: Any, k: int, ring: int, out: Any) -> None:
    """Write the costs of all cells in chosen blocks to `out`, which is inf elsewhere.

    Args:
        c: Cost per cell (h, w).
        chosen: 1 for the blocks to take.
        k: Cells to a side of a block.
        ring: Cells around the grid in `out`.
        out: A grid (h + 2 ring, w + 2 ring) of inf.
    """
    h, w = c.shape
    for block in range(chosen.shape[0]):
        for other in range(chosen.shape[1]):
            if chosen[block, other]:
                left, right = other * k, min(w, (other + 1) * k)
                for i in range(block * k, min(h, (block + 1) * k)):
                    for j in range(left, right):
                        out[i + ring, j + ring] = c[i, j]


@kernel()
def parts(reason: Any, k: int, out: Any, count: Any) -> None:
    """Tell the largest piece of free cells in each block from smaller ones.

    Cells belong together that share a side.

    Args:
        reason: 0 for free cells (h, w), else a small number: why not.
        k: Cells to a side of a block.
        out: Written, (h, w): 0 where not free, 2 in the largest piece of a block, 1 in others.
        count: Written, one row of blocks after the other: cells of each number (blocks, numbers).
    """
    h, w = reason.shape
    across = (w + k - 1) // k
    stack = np.empty(k * k, np.int64)
    for block in range(count.shape[0]):
        south, west = block // across * k, block % across * k
        north, east = min(h, south + k), min(w, west + k)
        numbers = count[block]
        numbers[:] = 0
        for i in range(south, north):
            for j in range(west, east):
                numbers[reason[i, j]] += 1
                out[i, j] = 2 if reason[i, j] == 0 else 0
        free = numbers[0]
        if 0 < free < (north - south) * (east - west):
            _largest(out, (south, north, west, east), free, stack)


@kernel()
def _largest(out: Any, edges: tuple[int, int, int, int], free: int, stack: Any) -> None:
    """Make 2 into 1 within a block but for its largest piece."""
    south, north, west, east = edges
    best, first = 0, -1
    left = free
    for i in range(south, north):
        for j in range(west, east):
            if out[i, j] == 2 and left > 0:
                size = _filled(out, edges, (i, j), (2, 3), stack)
                left -= size
                if size > best:
                    best, first = size, i * out.shape[1] + j
    for i in range(south, north):
        for j in range(west, east):
            if out[i, j] > 0:
                out[i, j] = 1
    if first >= 0:
        place = (first // out.shape[1], first % out.shape[1])
        _filled(out, edges, place, (1, 2), stack)


@kernel()
def _filled(
    out: Any,
    edges: tuple[int, int, int, int],
    place: tuple[int, int],
    change: tuple[int, int],
    stack: Any,
) -> int:
    """Change one number into another in the piece around a cell; returns how many cells it has."""
    south, north, west, east = edges
    old, new = change
    wide = out.shape[1]
    stack[0], waiting, size = place[0] * wide + place[1], 1, 0
    out[place[0], place[1]] = new
    while waiting > 0:
        waiting -= 1
        i, j = stack[waiting] // wide, stack[waiting] % wide
        size += 1
        for way in range(4):
            a = i + (1 if way == 0 else -1 if way == 1 else 0)
            b = j + (1 if way == 2 else -1 if way == 3 else 0)
            if south <= a < north and west <= b < east and out[a, b] == old:
                out[a, b] = new
                stack[waiting] = a * wide + b
                waiting += 1
    return size
