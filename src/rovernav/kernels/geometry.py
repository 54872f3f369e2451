"""Segments against boxes and grids, closed sets both: touching counts as meeting.

Symbols: a, b ends of a segment, t in [0, 1] the place on it, box = (x0, y0, x1, y1).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ._jit import kernel

MISS = 2.0
"""What the `first_*` kernels return where nothing is met: beyond the segment's end at t = 1."""


@kernel()
def first_box(ax: float, ay: float, bx: float, by: float, box: Any) -> float:
    """Smallest t at which the segment lies in the closed box, or MISS (Liang and Barsky 1984)."""
    t0, t1 = 0.0, 1.0
    for axis in range(2):
        start, delta = (ax, bx - ax) if axis == 0 else (ay, by - ay)
        low, high = box[axis], box[axis + 2]
        if delta == 0.0:
            if start < low or start > high:
                return MISS
        else:
            near, far = (low - start) / delta, (high - start) / delta
            if near > far:
                near, far = far, near
            t0, t1 = max(t0, near), min(t1, far)
    return t0 if t0 <= t1 else MISS


@kernel()
def first_boxes(
    ax: float, ay: float, bx: float, by: float, boxes: Any, first: int, last: int
) -> float:
    """Smallest t at which the segment meets one of boxes[first:last], or MISS."""
    best = MISS
    for k in range(first, last):
        best = min(best, first_box(ax, ay, bx, by, boxes[k]))
    return best


@kernel(inline=True)
def _is_blocked(blocked: Any, row: int, column: int) -> bool:
    inside = 0 <= row < blocked.shape[0] and 0 <= column < blocked.shape[1]
    return inside and blocked[row, column] != 0


@kernel()
def first_cell(ax: float, ay: float, bx: float, by: float, blocked: Any) -> float:
    """Smallest t at which the segment touches a blocked cell of a grid of unit cells, or MISS.

    A grid walk (Amanatides and Woo 1987) that never skips: through a corner it looks at both
    neighbours. Cells beyond the grid are free. Coordinates are in cells.
    """
    row, column = int(np.floor(ay)), int(np.floor(ax))
    if _touches(blocked, ax, ay):
        return 0.0
    dx, dy = bx - ax, by - ay
    sx, sy = (1 if dx > 0 else -1), (1 if dy > 0 else -1)
    tx = ((column + 1 if dx > 0 else column) - ax) / dx if dx != 0 else np.inf
    ty = ((row + 1 if dy > 0 else row) - ay) / dy if dy != 0 else np.inf
    step_x = abs(1.0 / dx) if dx != 0 else np.inf
    step_y = abs(1.0 / dy) if dy != 0 else np.inf
    steps = int(abs(np.floor(bx) - column) + abs(np.floor(by) - row)) + 4
    for _ in range(steps):
        t = min(tx, ty)
        if t > 1.0:
            return MISS
        through_x, through_y = tx == t, ty == t
        if through_x and through_y:  # a corner: the two cells beside it touch the segment too
            if _is_blocked(blocked, row, column + sx) or _is_blocked(blocked, row + sy, column):
                return t
        if through_x:
            column += sx
            tx += step_x
        if through_y:
            row += sy
            ty += step_y
        if _is_blocked(blocked, row, column) or _beside(blocked, ax + t * dx, ay + t * dy, dx, dy):
            return t
    return MISS


@kernel(inline=True)
def _touches(blocked: Any, x: float, y: float) -> bool:
    """Whether the point lies in a blocked cell or on the edge of one."""
    row, column = int(np.floor(y)), int(np.floor(x))
    west, south = x == column, y == row
    return (
        _is_blocked(blocked, row, column)
        or (west and _is_blocked(blocked, row, column - 1))
        or (south and _is_blocked(blocked, row - 1, column))
        or (west and south and _is_blocked(blocked, row - 1, column - 1))
    )


@kernel(inline=True)
def _beside(blocked: Any, x: float, y: float, dx: float, dy: float) -> bool:
    """For a segment that runs along a grid line: whether it touches a cell on either side."""
    return (dx == 0.0 or dy == 0.0) and _touches(blocked, x, y)


@kernel()
def segment_point(ax: float, ay: float, bx: float, by: float, x: float, y: float) -> float:
    """Distance from the point (x, y) to the segment."""
    dx, dy = bx - ax, by - ay
    length2 = dx * dx + dy * dy
    t = 0.0
    if length2 > 0.0:
        t = min(1.0, max(0.0, ((x - ax) * dx + (y - ay) * dy) / length2))
    return np.hypot(ax + t * dx - x, ay + t * dy - y)


@kernel()
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


@kernel()
def closest_cell(points: Any, blocked: Any, reach: Any, out: Any) -> None:
    """Distance from each segment of a path to the nearest blocked unit cell.

    Args:
        points: The path (k, 2), in cells.
        blocked: The grid (h, w).
        reach: For each segment (k-1,), a radius around its start that surely holds the cell [cells].
        out: Distances (k-1,) [cells]; inf where nothing is blocked within reach.
    """
    box = np.empty(4)
    for k in range(points.shape[0] - 1):
        ax, ay, bx, by = points[k, 0], points[k, 1], points[k + 1, 0], points[k + 1, 1]
        best = np.inf
        low_row, high_row = (
            max(0, int(ay - reach[k])),
            min(blocked.shape[0] - 1, int(ay + reach[k])),
        )
        low, high = max(0, int(ax - reach[k])), min(blocked.shape[1] - 1, int(ax + reach[k]))
        for row in range(low_row, high_row + 1):
            for column in range(low, high + 1):
                if blocked[row, column]:
                    box[0], box[1], box[2], box[3] = column, row, column + 1, row + 1
                    best = min(best, segment_box(ax, ay, bx, by, box))
        out[k] = best
