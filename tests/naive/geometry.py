"""Segments, boxes and grids in exact rational arithmetic; slow."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction as Q

import numpy as np

Point = Sequence[float] | np.ndarray
Box = Sequence[float]


def first_box(a: Point, b: Point, box: Box) -> Q | None:
    """Smallest t at which the closed segment a-b lies in the closed box; None: nowhere."""
    begin, end = Q(0), Q(1)
    for axis in (0, 1):
        start, delta = Q(a[axis]), Q(b[axis]) - Q(a[axis])
        low, high = Q(box[axis]), Q(box[axis + 2])
        if delta == 0:
            if not low <= start <= high:
                return None
            continue
        near, far = sorted(((low - start) / delta, (high - start) / delta))
        begin, end = max(begin, near), min(end, far)
    return begin if begin <= end else None


def cells(blocked: np.ndarray) -> Iterator[Box]:
    """The blocked unit cells as boxes."""
    for row, column in np.argwhere(blocked):
        yield (int(column), int(row), int(column) + 1, int(row) + 1)


def first_cell(a: Point, b: Point, blocked: np.ndarray) -> Q | None:
    """Smallest t at which the segment touches a blocked unit cell: every one of them is tried."""
    met = (first_box(a, b, cell) for cell in cells(blocked))
    return min((t for t in met if t is not None), default=None)


def segment_point(a: Point, b: Point, p: Point) -> float:
    """Distance of p from the segment a-b."""
    ax, ay, bx, by, x, y = map(Q, (*a, *b, *p))
    dx, dy = bx - ax, by - ay
    length2 = dx * dx + dy * dy
    t = min(Q(1), max(Q(0), ((x - ax) * dx + (y - ay) * dy) / length2)) if length2 else Q(0)
    return math.sqrt((ax + t * dx - x) ** 2 + (ay + t * dy - y) ** 2)


def segment_box(a: Point, b: Point, box: Box) -> float:
    """Distance of the segment from the box: that of the nearest of the box's four sides."""
    if first_box(a, b, box) is not None:
        return 0.0
    x0, y0, x1, y1 = box
    corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    sides = zip(corners, corners[1:] + corners[:1], strict=True)
    return min(
        min(segment_point(c, d, a), segment_point(c, d, b), segment_point(a, b, c))
        for c, d in sides
    )
