"""Intervals, and what a grid holds within an area.

An interval is a pair, low and high; each function gives an interval that holds every result for
numbers out of those given. Symbols: c cell [m], P, Q gradient of a plane.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._jit import kernel

F32: TypeAlias = NDArray[np.float32]
F64: TypeAlias = NDArray[np.float64]
Span: TypeAlias = tuple[float, float]
Area: TypeAlias = tuple[float, float, float, float]


@kernel(inline=True)
def times(a: Span, b: Span) -> Span:
    """The product of two intervals."""
    p, q, r, t = a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1]
    return min(min(p, q), min(r, t)), max(max(p, q), max(r, t))


@kernel(inline=True)
def plus(a: Span, b: Span) -> Span:
    """The sum of two intervals."""
    return a[0] + b[0], a[1] + b[1]


@kernel(inline=True)
def scaled(k: float, a: Span) -> Span:
    """An interval times a number."""
    return (k * a[0], k * a[1]) if k >= 0.0 else (k * a[1], k * a[0])


@kernel(inline=True)
def sines(a: Span) -> Span:
    """Sines of the angles of an interval within +-90 degrees."""
    return np.sin(a[0]), np.sin(a[1])


@kernel(inline=True)
def cosines(a: Span) -> Span:
    """Cosines of the angles of an interval within +-90 degrees."""
    p, q = np.cos(a[0]), np.cos(a[1])
    return min(p, q), 1.0 if a[0] <= 0.0 <= a[1] else max(p, q)


@kernel(inline=True)
def arcsines(a: Span) -> Span:
    """Angles of the sines of an interval; the caller has made sure that there are some."""
    return np.arcsin(max(a[0], -1.0)), np.arcsin(min(a[1], 1.0))


@kernel(inline=True)
def turned(x: Span, z: Span, cos: Span, sin: Span) -> tuple[float, float, float, float]:
    """(x cos - z sin, x sin + z cos) for intervals."""
    p, q = times(x, cos), times(z, sin)
    u = p[0] - q[1], p[1] - q[0]
    v = plus(times(x, sin), times(z, cos))
    return u[0], u[1], v[0], v[1]


@kernel(inline=True)
def over(a: Span, b: Span) -> Span:
    """The quotient of two intervals, the second of which is positive."""
    low = a[0] / (b[1] if a[0] >= 0.0 else b[0])
    return low, a[1] / (b[0] if a[1] >= 0.0 else b[1])


@kernel(inline=True)
def most(a: Span) -> float:
    """The largest size of a number of an interval."""
    return max(abs(a[0]), abs(a[1]))


@kernel(inline=True)
def least(a: Span) -> float:
    """The smallest size of a number of an interval."""
    return 0.0 if a[0] <= 0.0 <= a[1] else min(abs(a[0]), abs(a[1]))


@kernel(inline=True)
def on_the_map(x: Span, y: Span, pose: F64, doubt: F64) -> tuple[float, float, float, float]:
    """West, east, south, north [m] of a box in the heading's axes, the pose's doubt included."""
    turn = (-doubt[1], doubt[1])
    u0, u1, v0, v1 = turned(x, y, cosines(turn), sines(turn))
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    a, b = scaled(cos, (u0, u1)), scaled(-sin, (v0, v1))
    c, d = scaled(sin, (u0, u1)), scaled(cos, (v0, v1))
    west, east = pose[0] + a[0] + b[0] - doubt[0], pose[0] + a[1] + b[1] + doubt[0]
    return west, east, pose[1] + c[0] + d[0] - doubt[0], pose[1] + c[1] + d[1] + doubt[0]


@kernel()
def range_over(grid: F32, c: float, area: Area, plane: tuple[float, ...]) -> Span:
    """Lowest and highest of the bilinear surface less the plane over an area; NaN if unknown.

    Exact: between posts the surface less a plane is bilinear, and over a rectangle such a function
    is highest and lowest at corners. The corners are those of the area and of the cells in it.
    """
    h, w = grid.shape
    per = 1.0 / c
    u0, u1 = area[0] * per - 0.5, area[1] * per - 0.5
    v0, v1 = area[2] * per - 0.5, area[3] * per - 0.5
    if not (u0 >= 0.0 and v0 >= 0.0 and u1 < w - 1.0 and v1 < h - 1.0):
        return np.nan, np.nan
    j0, j1, i0, i1 = int(u0), int(u1), int(v0), int(v1)
    p, q = plane[3] * c, plane[4] * c
    level = plane[2] + plane[3] * (0.5 * c - plane[0]) + plane[4] * (0.5 * c - plane[1])
    low, high, total = np.inf, -np.inf, 0.0
    for k in range(i0, i1 + 2):
        v = min(max(v0, float(k)), v1)
        i = min(int(v), h - 2)
        f = v - i
        base = level + q * v
        first = 0.0
        for end in range(2):
            u = u0 if end == 0 else u1
            j = j0 if end == 0 else j1
            e = u - j
            below = (1.0 - e) * grid[i, j] + e * grid[i, j + 1]
            above = (1.0 - e) * grid[i + 1, j] + e * grid[i + 1, j + 1]
            first = (1.0 - f) * below + f * above - base - p * u
            low, high = min(low, first), max(high, first)
            total += first
        for j in range(j0 + 1, j1 + 1):
            over = (1.0 - f) * grid[i, j] + f * grid[i + 1, j] - base - p * j
            total += over
            low, high = min(low, over), max(high, over)
    return (low, high) if total == total else (np.nan, np.nan)


@kernel()
def highest_step(step: F32, c: float, area: Area) -> float:
    """Highest step at the posts around an area that lies on the grid; NaN without data."""
    highest, total = 0.0, 0.0
    for i in range(int(area[2] / c - 0.5), int(area[3] / c - 0.5) + 2):
        for j in range(int(area[0] / c - 0.5), int(area[1] / c - 0.5) + 2):
            total += step[i, j]
            highest = max(highest, step[i, j])
    return highest if total == total else np.nan
