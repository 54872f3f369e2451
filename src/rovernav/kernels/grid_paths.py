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

DOWN = np.array([0, 0, 1, -1, 1, 1, -1, -1])
RIGHT = np.array([1, -1, 0, 0, 1, -1, 1, -1])
"""Rows and columns of the eight moves, the straight ones first."""

SURELY = 1.0 - 1e-7
"""Share of the lower bound that is used, so that no rounding makes a sum fall along a way."""


class Search(NamedTuple):
    """How to search; `how` makes one.

    Attributes:
        stride: Cells from one row to the next, the ring included.
        per: Slices of the queue per unit of cost.
        goal: Where to stop, or -1 to go everywhere.
        row: Row of the goal, the ring included.
        column: Column of the goal, the ring included.
        least: Cost per cell of the lower bound; 0 searches without one.
        corners: Whether a diagonal step may pass a blocked cell.
    """

    stride: int
    per: float
    goal: int
    row: int
    column: int
    least: float
    corners: bool


def how(stride: int, slice_: float, goal: int, least: float, *, corners: bool) -> Search:
    """How to search to a goal with slices of a width and cells that cost at least `least`."""
    row, column = divmod(goal, stride)
    bound = SURELY * least if goal >= 0 else 0.0
    return Search(stride, 1.0 / slice_, goal, row, column, bound, corners)


@kernel(inline=True)
def _bound(s: Search, row: int, column: int) -> float:
    """Octile distance to the goal times the least cost: no way is cheaper."""
    di, dj = abs(row - s.row), abs(column - s.column)
    return s.least * (max(di, dj) + (SQRT2 - 1.0) * min(di, dj))


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
        touched: Room for the cells whose `d` changed, for who wants to reset only those: the first
            item tells how many. A single item lists none.

    Returns:
        Number of cells taken out of the queue, or FULL.
    """
    now = _begin(d, seeds, q, s, touched)
    if now == FULL:
        return FULL
    best, taken = d[s.goal] if s.goal >= 0 else np.inf, 0
    while not is_empty(q) and now < best * s.per:
        cell = pop(q, now)
        if cell < 0:
            now += 1
            continue
        row, column = _place(cell, s)
        here, own = d[cell], np.float64(c[cell])
        if int((here + _bound(s, row, column)) * s.per) != now:
            continue  # it was lowered meanwhile, and taken from an earlier slice
        taken += 1
        for k in range(8):
            di, dj = DOWN[k], RIGHT[k]
            other = cell + di * s.stride + dj
            new, old = here + _length(c, cell, k, s) * (own + c[other]), d[other]
            bound = _bound(s, row + di, column + dj)
            if new < old and new + bound < best:
                d[other] = new
                best = new if other == s.goal else best
                then = int((new + bound) * s.per)
                if old == np.inf:
                    _list(touched, other)
                elif then != now and then == int((old + bound) * s.per):
                    continue  # it waits in that slice already
                if not push(q, then, other):
                    return FULL
    return taken


@kernel(inline=True)
def _length(c: Any, cell: int, k: int, s: Search) -> float:
    """Half the length of the k-th move from a cell; inf where it is not allowed."""
    if k < 4:
        return 0.5
    side, ahead = c[cell + RIGHT[k]], c[cell + DOWN[k] * s.stride]
    return 0.5 * SQRT2 if s.corners or (side < np.inf and ahead < np.inf) else np.inf


@kernel(inline=True)
def _place(cell: int, s: Search) -> tuple[int, int]:
    """Row and column of a cell, the ring included."""
    row = cell // s.stride
    return row, cell - row * s.stride


@kernel(inline=True)
def _list(touched: Any, cell: int) -> None:
    if touched.size > 1:
        touched[0] += 1
        touched[touched[0]] = cell


@kernel()
def _begin(d: Any, seeds: Any, q: Queue, s: Search, touched: Any) -> int:
    """Put the seeds into the queue; returns the first slice, or FULL."""
    clear(q)
    touched[0] = 0
    first = 2**62
    for k in range(seeds.size):
        row, column = _place(seeds[k], s)
        then = int((d[seeds[k]] + _bound(s, row, column)) * s.per)
        _list(touched, seeds[k])
        first = min(first, then)
        if not push(q, then, seeds[k]):
            return FULL
    return first


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
    cell, count = goal, 0
    while count < out.size:
        out[count] = cell
        count += 1
        best, came = d[cell], -1
        for k in range(8):
            other = cell + DOWN[k] * s.stride + RIGHT[k]
            step = _length(c, cell, k, s) * (np.float64(c[cell]) + c[other])
            if d[other] < best and d[other] + step <= d[cell]:
                best, came = d[other], other
        if came < 0:
            return count
        cell = came
    return FULL
