"""A rectangle that moves: what it touches on its way, closed sets both.

The rectangle goes from one pose to another with a constant body twist, so its points move on arcs.
The convex hull of the rectangle at both ends of an arc, grown by the farthest that the arc can
bulge from its chord, holds all that the rectangle passes: nothing is missed. It holds more than
that, so where it meets something the arc is halved until that more is small. Straight ways and
rectangles at rest have neither and are exact. What is met is decided as in `geometry`.

Symbols: pose x [m], y [m], heading [rad]; rectangle (rear, front, right, left) in body axes [m];
hull corners (m, 2) counter-clockwise [m]; e the bulge [m].
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ._jit import kernel
from .drive import WorldArrays
from .geometry import first_box, side_of
from .shapes import first_shape

ROUNDS = 30
"""Halvings that find where on its way a rectangle meets something."""


@kernel(inline=True)
def along_arc(pose: Any, step: Any, share: float) -> tuple[float, float, float]:
    """The pose after a share of a step (forward, left, turn) of a constant body twist.

    The chord of an arc of angle b is sin(b/2) / (b/2) of its length and points b/2 from the start.
    """
    half = 0.5 * step[2] * share
    short = share * (math.sin(half) / half if half != 0.0 else 1.0)
    u, v, a = step[0] * short, step[1] * short, pose[2] + half
    c, s = math.cos(a), math.sin(a)
    return pose[0] + (u * c - v * s), pose[1] + (u * s + v * c), pose[2] + 2.0 * half


@kernel(inline=True)
def _corner(at: tuple[float, float, float], x: float, y: float, row: int, out: Any) -> None:
    c, s = math.cos(at[2]), math.sin(at[2])
    out[row, 0], out[row, 1] = at[0] + (c * x - s * y), at[1] + (s * x + c * y)


@kernel(bare=True)
def hull_of(
    a: tuple[float, float, float], b: tuple[float, float, float], rectangle: Any, hull: Any
) -> int:
    """Write the convex hull of the rectangle at two poses to `hull` (24, 2); returns its corners.

    Andrew's monotone chain (1979). Rows 16 to 23 are scratch.
    """
    rear, front, right, left = rectangle[0], rectangle[1], rectangle[2], rectangle[3]
    count = 4 if a[0] == b[0] and a[1] == b[1] and a[2] == b[2] else 8
    for k in range(count // 4):
        at, row = (a if k == 0 else b), 16 + 4 * k
        _corner(at, rear, right, row, hull)
        _corner(at, front, right, row + 1, hull)
        _corner(at, front, left, row + 2, hull)
        _corner(at, rear, left, row + 3, hull)
    if count == 4:
        for k in range(4):
            hull[k, 0], hull[k, 1] = hull[16 + k, 0], hull[16 + k, 1]
        return 4
    for i in range(17, 24):
        x, y, j = hull[i, 0], hull[i, 1], i - 1
        while j >= 16 and (hull[j, 0] > x or (hull[j, 0] == x and hull[j, 1] > y)):
            hull[j + 1, 0], hull[j + 1, 1] = hull[j, 0], hull[j, 1]
            j -= 1
        hull[j + 1, 0], hull[j + 1, 1] = x, y
    lower = _chain(hull, 0, 1)
    return lower + _chain(hull, lower, -1)


@kernel(bare=True)
def _chain(hull: Any, first: int, way: int) -> int:
    """Write half of the hull of the sorted scratch from row `first` on, its last corner not."""
    size = first
    for n in range(8):
        i = 16 + n if way > 0 else 23 - n
        x, y = hull[i, 0], hull[i, 1]
        while size >= first + 2:
            ax, ay, bx, by = (
                hull[size - 2, 0],
                hull[size - 2, 1],
                hull[size - 1, 0],
                hull[size - 1, 1],
            )
            if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0.0:
                break
            size -= 1
        hull[size, 0], hull[size, 1] = x, y
        size += 1
    return size - 1 - first


@kernel(bare=True)
def holds(hull: Any, m: int, x: float, y: float) -> bool:
    """Whether the closed hull holds the point."""
    for k in range(m):
        j = (k + 1) % m
        if side_of(hull[k, 0], hull[k, 1], hull[j, 0], hull[j, 1], x, y) < 0.0:
            return False
    return True


@kernel(bare=True)
def meets_box(hull: Any, m: int, x0: float, y0: float, x1: float, y1: float) -> bool:
    """Whether the hull touches the closed box."""
    box = (x0, y0, x1, y1)
    for k in range(m):
        j = (k + 1) % m
        if first_box(hull[k, 0], hull[k, 1], hull[j, 0], hull[j, 1], box) <= 1.0:
            return True
    return holds(hull, m, x0, y0)


@kernel(bare=True)
def meets_shape(hull: Any, m: int, corners: Any, r: float) -> bool:
    """Whether the hull touches the polygon grown by r."""
    for k in range(m):
        j = (k + 1) % m
        if first_shape(hull[k, 0], hull[k, 1], hull[j, 0], hull[j, 1], corners, r) <= 1.0:
            return True
    return holds(hull, m, corners[0, 0], corners[0, 1])


@kernel(bare=True)
def meets_disc(hull: Any, m: int, x: float, y: float, r: float) -> bool:
    """Whether the hull touches the disc."""
    if holds(hull, m, x, y):
        return True
    for k in range(m):
        j = (k + 1) % m
        ax, ay = hull[k, 0], hull[k, 1]
        dx, dy = hull[j, 0] - ax, hull[j, 1] - ay
        long = dx * dx + dy * dy
        t = min(1.0, max(0.0, ((x - ax) * dx + (y - ay) * dy) / long)) if long > 0.0 else 0.0
        gx, gy = ax + t * dx - x, ay + t * dy - y
        if gx * gx + gy * gy <= r * r:
            return True
    return False


@kernel(bare=True)
def meets_cells(hull: Any, m: int, edges: Any, blocked: Any, c: float, e: float) -> bool:
    """Whether the hull, grown by e, touches a blocked cell; `edges` is its bounding box, grown."""
    h, w = blocked.shape
    south, north = max(0, int(np.ceil(edges[1] / c)) - 1), min(h - 1, int(np.floor(edges[3] / c)))
    west, east = max(0, int(np.ceil(edges[0] / c)) - 1), min(w - 1, int(np.floor(edges[2] / c)))
    for i in range(south, north + 1):
        for j in range(west, east + 1):
            if blocked[i, j] != 0 and meets_box(
                hull, m, j * c - e, i * c - e, (j + 1) * c + e, (i + 1) * c + e
            ):
                return True
    return False


@kernel(bare=True)
def meets_world(hull: Any, m: int, of: int, world: WorldArrays, grid: bool, e: float) -> bool:
    """Whether the hull, grown by e, touches an obstacle of world `of`; boxes grow as boxes do."""
    x0, y0, x1, y1 = np.inf, np.inf, -np.inf, -np.inf
    for k in range(m):
        x0, x1 = min(x0, hull[k, 0]), max(x1, hull[k, 0])
        y0, y1 = min(y0, hull[k, 1]), max(y1, hull[k, 1])
    x0, y0, x1, y1 = x0 - e, y0 - e, x1 + e, y1 + e
    for k in range(world.offsets[of], world.offsets[of + 1]):
        box = world.boxes[k]
        apart = (x1 < box[0]) | (x0 > box[2]) | (y1 < box[1]) | (y0 > box[3])
        if not apart and meets_box(hull, m, box[0] - e, box[1] - e, box[2] + e, box[3] + e):
            return True
    if grid and world.blocked.size:
        layer = of if world.blocked.shape[0] > 1 else 0
        if meets_cells(hull, m, (x0, y0, x1, y1), world.blocked[layer], world.cell, e):
            return True
    if world.shapes.size:
        for k in range(world.shapes[of], world.shapes[of + 1]):
            corners = world.corners[world.ends[k] : world.ends[k + 1]]
            if meets_shape(hull, m, corners, world.radius[k] + e):
                return True
    return False


@kernel(inline=True)
def spread_of(step: Any, far: float) -> tuple[float, float]:
    """How far arcs bulge from chords, and what hulls hold beyond what is swept, over a whole step.

    A point within `far` of the middle goes at most V = |(u, v)| + far |b| over an arc of b and
    leaves its chord by at most V |b| / 8 [m]; over a share of the step, by its square of that.
    A hull also holds points between one point of the rectangle at the start and another, at most
    2 far away, at the end: at most far |b| / 2 [m] from what is swept; over a share, its share.
    """
    turn = abs(step[2])
    way = np.sqrt(step[0] * step[0] + step[1] * step[1]) + far * turn
    return way * turn / 8.0, 0.5 * far * turn
