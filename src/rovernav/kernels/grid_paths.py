"""Shortest paths from cell to cell of a grid, to the eight neighbours, by a bucket queue.

A step from a cell to a neighbour costs its length times the mean of the two cells' costs, which is
the line integral of the cost from centre to centre. Without corner cutting a diagonal step needs
both cells beside it (Sturtevant 2012).

Symbols: c cost per cell (inf where blocked), d cost from the seeds, h lower bound of the cost to
the goal. Grids are flat, with a ring of blocked cells around: neighbours need no bounds. Lengths
are in cells.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ._jit import kernel
from .buckets import Queue, clear, is_empty, pop, push

FULL = -1
"""What a search returns when its queue has no room left: begin anew with a larger one."""

SQRT2 = math.sqrt(2.0)

SURELY = 1.0 - 1e-7
"""Share of the lower bound that is used, so that no rounding makes a sum fall along a way."""


class Search(NamedTuple):
    """How to search.

    Attributes:
        stride: Cells from one row to the next, the ring included.
        slice: Cost that one slice of the queue spans.
        goal: Where to stop, or -1 to go everywhere.
        least: Cost per cell that no cell undercuts; 0 searches without a lower bound.
        corners: Whether a diagonal step may pass a blocked cell.
    """

    stride: int
    slice: float
    goal: int
    least: float
    corners: bool


@kernel(inline=True)
def _bound(s: Search, cell: int) -> float:
    """Octile distance to the goal times the least cost: no way is cheaper."""
    row, goal_row = cell // s.stride, s.goal // s.stride
    di = abs(row - goal_row)
    dj = abs((cell - row * s.stride) - (s.goal - goal_row * s.stride))
    return SURELY * s.least * (max(di, dj) + (SQRT2 - 1.0) * min(di, dj))


@kernel()
def search(c: Any, d: Any, seeds: Any, q: Queue, s: Search, touched: Any) -> int:
    """Lower `d` to the cost of the cheapest way from the seeds.

    With a goal it ends as soon as d[goal] is sure; other cells then hold upper bounds.

    Args:
        c: Cost per cell, float32, > 0, inf where blocked, with a blocked ring around; flat.
        d: Costs of the seeds, inf elsewhere, float64; changed.
        seeds: Cells to begin with.
        q: A queue; its ring spans the largest step and fall of the bound.
        s: How to search.
        touched: Room for the cells whose `d` changed, for who wants to reset only those; may be
            empty.

    Returns:
        Number of cells taken out of the queue, or FULL. touched[0] holds how many are listed.
    """
    moves = np.array([1, -1, s.stride, -s.stride])
    bounded = s.goal >= 0 and s.least > 0.0
    inverse = 1.0 / s.slice
    listed, listing = 1, touched.size > 1
    clear(q)
    now = np.int64(2**62)
    for k in range(seeds.size):
        cell = seeds[k]
        key = d[cell] + (_bound(s, cell) if bounded else 0.0)
        now = min(now, np.int64(key * inverse))
    for k in range(seeds.size):
        cell = seeds[k]
        key = d[cell] + (_bound(s, cell) if bounded else 0.0)
        if not push(q, np.int64(key * inverse), cell):
            return FULL  # more seeds than room: nothing has changed yet
        if listing:
            touched[listed] = cell
            listed += 1
    best = d[s.goal] if s.goal >= 0 else np.inf
    taken = 0
    while taken != FULL and not is_empty(q):
        cell = pop(q, now)
        if cell < 0:
            now += 1
            if now * s.slice >= best:
                break
            continue
        here = d[cell]
        key = here + (_bound(s, cell) if bounded else 0.0)
        if np.int64(key * inverse) != now or key >= best:
            continue  # it was lowered meanwhile, and taken from an earlier slice
        taken += 1
        own = np.float64(c[cell])
        for k in range(8):
            if k < 4:
                other = cell + moves[k]
                along = 0.5
            else:
                side, ahead = moves[k & 1], moves[2 + ((k >> 1) & 1)]
                other = cell + side + ahead
                along = 0.5 * SQRT2
                if not s.corners and not (c[cell + side] < np.inf and c[cell + ahead] < np.inf):
                    continue
            new = here + along * (own + c[other])
            old = d[other]
            if new < old:
                h = _bound(s, other) if bounded else 0.0
                if new + h >= best:
                    continue
                d[other] = new
                if listing and old == np.inf:
                    touched[listed] = other
                    listed += 1
                if other == s.goal:
                    best = new
                then = np.int64((new + h) * inverse)
                before = np.int64((old + h) * inverse) if old < np.inf else then + 1
                if (then != before or then == now) and not push(q, then, other):
                    taken = FULL
                    break
    if listing:
        touched[0] = listed - 1
    return taken


@kernel()
def walk_back(c: Any, d: Any, goal: int, s: Search, out: Any) -> int:
    """Cells of a cheapest way to `goal`, from the goal to a seed.

    Args:
        c: Cost per cell as in `search`.
        d: What `search` left.
        goal: Where the way ends; d[goal] is finite.
        s: How `search` went.
        out: Room for the cells, int64.

    Returns:
        Number of cells, or FULL where `out` is too short.
    """
    moves = np.array([1, -1, s.stride, -s.stride])
    cell, count = goal, 0
    while True:
        if count == out.size:
            return FULL
        out[count] = cell
        count += 1
        best, came = d[cell], np.int64(-1)
        own = np.float64(c[cell])
        for k in range(8):
            if k < 4:
                other = cell + moves[k]
                along = 0.5
            else:
                side, ahead = moves[k & 1], moves[2 + ((k >> 1) & 1)]
                other = cell + side + ahead
                along = 0.5 * SQRT2
                if not s.corners and not (c[cell + side] < np.inf and c[cell + ahead] < np.inf):
                    continue
            if d[other] + along * (own + c[other]) <= d[cell] and d[other] < best:
                best, came = d[other], other
        if came < 0:
            return count
        cell = came
