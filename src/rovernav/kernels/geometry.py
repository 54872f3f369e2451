"""Segments against boxes and grids, closed sets both: touching counts as meeting.

What is met is decided by comparisons and by the side of the line on which corners lie, never by a
quotient or a running sum. So nothing that a segment touches is missed, a segment meets the same
from either end, and the last cell of a long walk is as exact as the first; what passes within a few
roundings (4e-16 of the coordinates) counts as touched too.

Symbols: a, b ends of a segment, t in [0, 1] the place on it, box = (x0, y0, x1, y1).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ._jit import kernel

MISS = 2.0
"""What the `first_*` kernels return where nothing is met: beyond the segment's end at t = 1."""

_SURE, _TINY = 4e-16, 1e-300
"""A side is sure beyond this share of its terms, and this much (Shewchuk 1997, section 4.1)."""


@kernel(inline=True)
def side_of(ax: float, ay: float, bx: float, by: float, x: float, y: float) -> float:
    """Above 0 where (x, y) is surely left of the line from a to b, below 0 right, else 0."""
    p, q = (ax - x) * (by - y), (ay - y) * (bx - x)
    return p - q if abs(p - q) > _SURE * (abs(p) + abs(q)) + _TINY else 0.0


@kernel(bare=True)
def first_box(ax: float, ay: float, bx: float, by: float, box: Any) -> float:
    """Smallest t at which the segment lies in the closed box, or MISS; MISS if not finite."""
    x0, y0, x1, y1 = box[0], box[1], box[2], box[3]
    dx, dy = bx - ax, by - ay
    # | rather than `or`: no branches, twice as fast
    apart = (max(ax, bx) < x0) | (min(ax, bx) > x1) | (max(ay, by) < y0) | (min(ay, by) > y1)
    if apart or not (abs(dx) + abs(dy) < np.inf):
        return MISS
    left, right = (x0, x1) if dy > 0.0 else (x1, x0)
    top, bottom = (y1, y0) if dx > 0.0 else (y0, y1)
    if side_of(ax, ay, bx, by, left, top) < 0.0 or side_of(ax, ay, bx, by, right, bottom) > 0.0:
        return MISS
    tx = ((x0 if dx > 0.0 else x1) - ax) / dx if dx != 0.0 else 0.0
    ty = ((y0 if dy > 0.0 else y1) - ay) / dy if dy != 0.0 else 0.0
    return min(1.0, max(0.0, tx, ty))


@kernel(bare=True)
def first_boxes(
    ax: float, ay: float, bx: float, by: float, boxes: Any, first: int, last: int
) -> float:
    """Smallest t at which the segment meets one of boxes[first:last], or MISS."""
    best = MISS
    for k in range(first, last):
        best = min(best, first_box(ax, ay, bx, by, boxes[k]))
    return best


@kernel(bare=True)
def first_cell(ax: float, ay: float, bx: float, by: float, blocked: Any) -> float:
    """Smallest t at which the segment touches a blocked cell of a grid of unit cells, or MISS.

    The smallest t of `first_box` over the blocked cells, whatever the order in which they are
    looked at. Goes through the grid's columns along the segment, and in each through the rows that
    the segment can touch there. Coordinates are in cells; cells beyond the grid are free.
    """
    dx, dy = bx - ax, by - ay
    if not abs(dx) + abs(dy) < np.inf:
        return MISS
    slack = 2e-15 * (abs(ay) + abs(by))  # more than the rounding of ya and yb
    first, last = _touched(min(ax, bx), max(ax, bx), blocked.shape[1])
    best = MISS
    for n in range(last - first + 1):
        column = first + n if dx >= 0.0 else last - n
        ya, yb = ay, by
        if dx != 0.0:
            ya += min(1.0, max(0.0, (column - ax) / dx)) * dy
            yb = ay + min(1.0, max(0.0, (column + 1 - ax) / dx)) * dy
        south, north = _touched(min(ya, yb) - slack, max(ya, yb) + slack, blocked.shape[0])
        for m in range(north - south + 1):
            row = south + m if dy >= 0.0 else north - m
            if blocked[row, column]:
                cell = (float(column), float(row), column + 1.0, row + 1.0)
                best = min(best, first_box(ax, ay, bx, by, cell))
                if best <= 1.0:
                    break
        # nothing in a later column is met before its own side; along a side there is none later
        if best <= 1.0 and dx != 0.0 and best <= (column + (dx > 0.0) - ax) / dx:
            break
    return best


@kernel(inline=True)
def _touched(low: float, high: float, count: int) -> tuple[int, int]:
    """First and last of `count` unit cells in a row that touch [low, high]; none: last < first."""
    first = min(max(np.ceil(low) - 1.0, 0.0), float(count))
    return int(first), int(min(max(np.floor(high), -1.0), count - 1.0))


@kernel(bare=True)
def segment_point(ax: float, ay: float, bx: float, by: float, x: float, y: float) -> float:
    """Distance from the point (x, y) to the segment."""
    dx, dy = bx - ax, by - ay
    length2 = dx * dx + dy * dy
    t = 0.0
    if length2 > 0.0:
        t = min(1.0, max(0.0, ((x - ax) * dx + (y - ay) * dy) / length2))
    return np.hypot(ax + t * dx - x, ay + t * dy - y)


@kernel(bare=True)
def segment_box(ax: float, ay: float, bx: float, by: float, box: Any) -> float:
    """Distance from the segment to the closed box; 0 where they meet."""
    if first_box(ax, ay, bx, by, box) <= 1.0:
        return 0.0
    best = min(_point_box(ax, ay, box), _point_box(bx, by, box))
    for x in (box[0], box[2]):
        for y in (box[1], box[3]):
            best = min(best, segment_point(ax, ay, bx, by, x, y))
    return best


@kernel(inline=True)
def _point_box(x: float, y: float, box: Any) -> float:
    return np.hypot(max(box[0] - x, x - box[2], 0.0), max(box[1] - y, y - box[3], 0.0))


@kernel(bare=True)
def closest_cell(segments: Any, blocked: Any, reach: Any, least: Any) -> float:
    """Distance from the nearest of many segments to the blocked unit cell nearest to it.

    Args:
        segments: Ends ax, ay, bx, by of each (m, 4), in cells; those that are sure to be far come
            last.
        blocked: The grid (h, w).
        reach: For each segment (m,), a radius around its start that surely holds that cell.
        least: For each segment (m,), what its distance is at least, rising.

    Returns:
        The distance; inf where nothing is blocked within reach.
    """
    best = np.inf
    for k in range(segments.shape[0]):
        if least[k] > best:
            break
        ax, ay, bx, by = segments[k, 0], segments[k, 1], segments[k, 2], segments[k, 3]
        far = min(reach[k], best + np.hypot(bx - ax, by - ay))
        south, north = _touched(ay - far, ay + far, blocked.shape[0])
        west, east = _touched(ax - far, ax + far, blocked.shape[1])
        for row in range(south, north + 1):
            for column in range(west, east + 1):
                if blocked[row, column]:
                    cell = (float(column), float(row), column + 1.0, row + 1.0)
                    best = min(best, segment_box(ax, ay, bx, by, cell))
    return best
