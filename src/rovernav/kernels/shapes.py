"""Segments against rounded polygons: everything within a radius of a closed polygon.

One corner is a disc, two are a capsule, three and more a polygon, its inside by the even-odd rule.
With radius 0 what is met is decided by the side of the line on which points lie, as for boxes; with
a radius by distances, which are good to a few roundings.

Symbols: a, b ends of a segment, t in [0, 1] the place on it, p, q ends of a polygon's side, r the
radius.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ._jit import kernel
from .geometry import MISS, segment_point, side_of


@kernel(bare=True)
def first_shapes(
    ax: float, ay: float, bx: float, by: float, corners: Any, ends: Any, radius: Any, which: Any
) -> float:
    """Smallest t at which the segment meets one of the shapes `which` (first, last), or MISS.

    Args:
        ax: x of a [m].
        ay: y of a [m].
        bx: x of b [m].
        by: y of b [m].
        corners: Corners of all shapes (p, 2) [m].
        ends: Shape i has the corners ends[i] to ends[i + 1].
        radius: Radius of each shape [m].
        which: First shape, and the one after the last.
    """
    best = MISS
    for i in range(which[0], which[1]):
        t = first_shape(ax, ay, bx, by, corners[ends[i] : ends[i + 1]], radius[i])
        best = min(best, t)
    return best


@kernel(bare=True)
def first_shape(ax: float, ay: float, bx: float, by: float, corners: Any, r: float) -> float:
    """Smallest t at which the segment is within r of the closed polygon, or MISS."""
    m = corners.shape[0]
    if m == 0 or not abs(bx - ax) + abs(by - ay) < np.inf:
        return MISS
    x0, y0, x1, y1 = corners[0, 0], corners[0, 1], corners[0, 0], corners[0, 1]
    for k in range(1, m):
        x0, x1 = min(x0, corners[k, 0]), max(x1, corners[k, 0])
        y0, y1 = min(y0, corners[k, 1]), max(y1, corners[k, 1])
    if (max(ax, bx) < x0 - r) | (min(ax, bx) > x1 + r):
        return MISS
    if (max(ay, by) < y0 - r) | (min(ay, by) > y1 + r):
        return MISS
    if inside(ax, ay, corners):
        return 0.0
    best = MISS
    for k in range(m):
        t = _crossing(ax, ay, bx, by, corners, k) if r == 0.0 else MISS
        if r > 0.0:
            t = _first_round(ax, ay, bx, by, corners, k, r)
        best = min(best, t)
    return best


@kernel(bare=True)
def inside(x: float, y: float, corners: Any) -> bool:
    """Whether (x, y) lies inside the polygon by the even-odd rule; its edge is not decided here."""
    within = False
    m = corners.shape[0]
    for k in range(m):
        px, py = corners[k, 0], corners[k, 1]
        qx, qy = corners[(k + 1) % m, 0], corners[(k + 1) % m, 1]
        if (py > y) != (qy > y):
            s = side_of(px, py, qx, qy, x, y)
            if (s > 0.0) == (qy > py) and s != 0.0:
                within = not within
    return within


@kernel(bare=True)
def _crossing(ax: float, ay: float, bx: float, by: float, corners: Any, k: int) -> float:
    """Smallest t at which the segment touches side k of the polygon, or MISS."""
    m = corners.shape[0]
    px, py = corners[k, 0], corners[k, 1]
    qx, qy = corners[(k + 1) % m, 0], corners[(k + 1) % m, 1]
    apart = (max(ax, bx) < min(px, qx)) | (min(ax, bx) > max(px, qx))
    if apart or max(ay, by) < min(py, qy) or min(ay, by) > max(py, qy):
        return MISS
    at_p, at_q = side_of(ax, ay, bx, by, px, py), side_of(ax, ay, bx, by, qx, qy)
    at_a, at_b = side_of(px, py, qx, qy, ax, ay), side_of(px, py, qx, qy, bx, by)
    if (at_p > 0.0 and at_q > 0.0) or (at_p < 0.0 and at_q < 0.0):
        return MISS
    if (at_a > 0.0 and at_b > 0.0) or (at_a < 0.0 and at_b < 0.0):
        return MISS
    if at_a != 0.0 or at_b != 0.0:  # not along one line
        return 0.0 if at_a == 0.0 else abs(at_a) / (abs(at_a) + abs(at_b))
    dx, dy = bx - ax, by - ay
    length2 = dx * dx + dy * dy
    if length2 == 0.0:
        return 0.0
    to_p = ((px - ax) * dx + (py - ay) * dy) / length2
    to_q = ((qx - ax) * dx + (qy - ay) * dy) / length2
    return min(1.0, max(0.0, min(to_p, to_q)))


@kernel(bare=True)
def _first_round(
    ax: float, ay: float, bx: float, by: float, corners: Any, k: int, r: float
) -> float:
    """Smallest t at which the segment is within r > 0 of side k, or MISS."""
    m = corners.shape[0]
    px, py = corners[k, 0], corners[k, 1]
    qx, qy = corners[(k + 1) % m, 0], corners[(k + 1) % m, 1]
    if segment_point(px, py, qx, qy, ax, ay) <= r:
        return 0.0
    best = min(_first_disc(ax, ay, bx, by, px, py, r), _first_disc(ax, ay, bx, by, qx, qy, r))
    ux, uy = qx - px, qy - py
    length = np.hypot(ux, uy)
    if length == 0.0:
        return best
    ux, uy = ux / length, uy / length
    off = ux * (ay - py) - uy * (ax - px)  # left of the side, where a is
    rate = ux * (by - ay) - uy * (bx - ax)
    if rate == 0.0:
        return best
    t = (r - off) / rate if off > 0.0 else (-r - off) / rate
    if 0.0 <= t <= 1.0:
        along = ux * (ax + t * (bx - ax) - px) + uy * (ay + t * (by - ay) - py)
        if 0.0 <= along <= length:
            best = min(best, t)
    return best


@kernel(bare=True)
def _first_disc(ax: float, ay: float, bx: float, by: float, x: float, y: float, r: float) -> float:
    """Smallest t at which the segment is within r of (x, y), or MISS; a itself is not."""
    if segment_point(ax, ay, bx, by, x, y) > r:
        return MISS
    dx, dy = bx - ax, by - ay
    length = np.hypot(dx, dy)
    if length == 0.0:
        return 0.0
    ux, uy = dx / length, dy / length
    along, off = ux * (x - ax) + uy * (y - ay), ux * (y - ay) - uy * (x - ax)
    half = np.sqrt(max(0.0, r * r - off * off))
    return min(1.0, max(0.0, (along - half) / length))


@kernel(bare=True)
def segment_shape(ax: float, ay: float, bx: float, by: float, corners: Any, r: float) -> float:
    """Distance from the segment to the rounded polygon; 0 where they meet."""
    if first_shape(ax, ay, bx, by, corners, r) <= 1.0:
        return 0.0
    best = np.inf
    m = corners.shape[0]
    for k in range(m):
        px, py = corners[k, 0], corners[k, 1]
        qx, qy = corners[(k + 1) % m, 0], corners[(k + 1) % m, 1]
        best = min(best, segment_point(px, py, qx, qy, ax, ay))
        best = min(best, segment_point(px, py, qx, qy, bx, by))
        best = min(best, segment_point(ax, ay, bx, by, px, py))
    return max(0.0, best - r)
