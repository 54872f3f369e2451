"""The cost of a path: the line integral of the cost per cell along its straight pieces.

Every planner is judged by these functions, and so is what others have planned. Cells are closed:
a path that touches a blocked cell, be it at a corner, costs infinitely much, as a drive would end
there. A piece that runs along the border of two cells pays for the dearer one. Coordinates are in
cells, x along the columns and y along the rows; beyond the grid everything is blocked.

Symbols: a, b ends of a piece, c cost per cell (h, w), inf where blocked.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ._jit import kernel

NEAR = 1e-9
"""Cells within this distance [cells] of a piece count as touched."""


@kernel()
def piece(ax: float, ay: float, bx: float, by: float, c: Any) -> float:
    """Cost of the straight piece from a to b; inf where it touches something or leaves the grid."""
    h, w = c.shape
    in_x = (ax >= 0.0) & (ax <= w) & (bx >= 0.0) & (bx <= w)  # False for NaN
    if not in_x & (ay >= 0.0) & (ay <= h) & (by >= 0.0) & (by <= h):
        return np.inf
    dx, dy = bx - ax, by - ay
    steep = abs(dy) > abs(dx)
    if steep:  # x runs along the longer side, whichever that is
        ax, ay, bx, by, dx, dy, h, w = ay, ax, by, bx, dy, dx, w, h
    if dx < 0.0:
        ax, ay, bx, by, dx, dy = bx, by, ax, ay, -dx, -dy
    length = np.hypot(dx, dy)
    first, last = _cells(ax, bx, w)
    per = 1.0 / dx if dx > 0.0 else 0.0
    slope = dy * per
    total = 0.0
    for column in range(first, last + 1):
        x0, x1 = max(ax, float(column)), min(bx, column + 1.0)
        y0, y1 = ay + (x0 - ax) * slope, ay + (x1 - ax) * slope
        low, high = min(y0, y1), max(y0, y1)
        south, north = _cells(low, high, h)
        share = max(x1 - x0, 0.0) * per
        flat = high - low <= 2.0 * NEAR
        dearest = 0.0
        for row in range(south, north + 1):
            here = np.float64(c[column, row] if steep else c[row, column])
            if not here < np.inf:
                return np.inf
            if flat:
                dearest = max(dearest, here)
            else:
                within = max(min(high, row + 1.0) - max(low, float(row)), 0.0)
                total += here * share * (within / (high - low))
        if flat:
            total += dearest * share
    return total * length


@kernel(inline=True)
def _cells(low: float, high: float, count: int) -> tuple[int, int]:
    """First and last of `count` cells in a row that touch [low, high], as far as there are any."""
    first = max(int(np.floor(low - NEAR)), 0)
    return min(first, count - 1), min(int(np.floor(high + NEAR)), count - 1)


@kernel()
def pieces(points: Any, c: Any, out: Any) -> None:
    """Write the cost of each piece of a path (k, 2) to `out` (k-1,)."""
    for k in range(points.shape[0] - 1):
        out[k] = piece(points[k, 0], points[k, 1], points[k + 1, 0], points[k + 1, 1], c)


@kernel()
def span(c: Any) -> tuple[float, float, int]:
    """Smallest and largest cost below inf, and the first cell (flat) that is not above 0, or -1."""
    least, most = np.inf, 0.0
    h, w = c.shape
    for i in range(h):
        for j in range(w):
            here = c[i, j]
            if not here > 0.0:
                return least, most, i * w + j
            if here < np.inf:
                least = min(least, here)
                most = max(most, here)
    return least, most, -1


@kernel()
def fan_out(x: float, y: float, reach: int, c: Any, out: Any) -> None:
    """Cost of the straight pieces from (x, y) to the middles of the cells around.

    Args:
        x: Where they begin.
        y: As `x`.
        reach: Cells on either side.
        c: Cost per cell (h, w), inf where blocked.
        out: Costs (2 reach + 1, 2 reach + 1), the cell of (x, y) in the middle; inf beyond the
            grid.
    """
    h, w = c.shape
    row, column = min(int(y), h - 1), min(int(x), w - 1)
    for i in range(row - reach, row + reach + 1):
        for j in range(column - reach, column + reach + 1):
            cost = np.inf
            if 0 <= i < h and 0 <= j < w:
                cost = piece(x, y, j + 0.5, i + 0.5, c)
            out[i - row + reach, j - column + reach] = cost


@kernel(inline=True)
def across(points: Any, k: int, step: float) -> tuple[float, float]:
    """A step across the path at its point k; none at the ends."""
    if 0 < k < points.shape[0] - 1:
        dx, dy = points[k + 1, 0] - points[k - 1, 0], points[k + 1, 1] - points[k - 1, 1]
        size = np.hypot(dx, dy)
        if size > 0.0:
            return -dy / size * step, dx / size * step
    return 0.0, 0.0
