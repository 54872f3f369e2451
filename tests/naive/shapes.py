"""Rounded polygons by dense samples and exact fractions; slow."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction as Q

Point = Sequence[float]


def inside(p: Point, corners: Sequence[Point]) -> bool:
    """Whether p is in the closed polygon: on its edge, or the winding of crossings is odd."""
    x, y = map(Q, p)
    odd = False
    for (ax, ay), (bx, by) in zip(corners, [*corners[1:], corners[0]], strict=True):
        ax, ay, bx, by = map(Q, (ax, ay, bx, by))
        cross = (bx - ax) * (y - ay) - (by - ay) * (x - ax)
        if cross == 0 and min(ax, bx) <= x <= max(ax, bx) and min(ay, by) <= y <= max(ay, by):
            return True
        if (ay > y) != (by > y) and x < ax + (y - ay) * (bx - ax) / (by - ay):
            odd = not odd
    return odd


def distance(p: Point, corners: Sequence[Point]) -> float:
    """Distance of a point from the closed polygon."""
    if len(corners) > 2 and inside(p, corners):
        return 0.0
    best = math.inf
    for a, b in zip(corners, [*corners[1:], corners[0]], strict=True):
        dx, dy = b[0] - a[0], b[1] - a[1]
        length2 = dx * dx + dy * dy
        t = ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / length2 if length2 else 0.0
        t = min(1.0, max(0.0, t))
        best = min(best, math.dist(p, (a[0] + t * dx, a[1] + t * dy)))
    return best


def first(a: Point, b: Point, corners: Sequence[Point], radius: float, *, samples: int) -> float:
    """First of evenly spaced t at which the point is within `radius`, or 2."""
    for i in range(samples + 1):
        t = i / samples
        p = (a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]))
        if distance(p, corners) <= radius:
            return t
    return 2.0
