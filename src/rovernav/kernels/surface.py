"""Where a wheel's centre can be over a grid of heights. Symbols: z height, c cell, r radius [m]."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._jit import kernel

F32: TypeAlias = NDArray[np.float32]


@kernel()
def wheel_centres(z: F32, c: float, r: float, out: F32) -> None:
    """Write to `out` (h, w) how high the centre of a wheel of radius `r` is over each post.

    The wheel is a sphere: the highest of z + sqrt(r^2 - d^2) over the posts at distance d < r, a
    grey dilation. NaN where one of those posts has no height; posts off the grid do not count.
    """
    h, w = z.shape
    n = int(np.floor(r / c))
    for i in range(h):
        row = out[i]
        for j in range(w):
            row[j] = -np.inf
        for di in range(-n, n + 1):
            if i + di < 0 or i + di >= h:
                continue
            other = z[i + di]
            for dj in range(-n, n + 1):
                left = r * r - c * c * (di * di + dj * dj)
                if left < 0.0:
                    continue
                cap = np.float32(np.sqrt(left))
                for j in range(max(0, -dj), min(w, w - dj)):
                    top = other[j + dj] + cap
                    # not <=: a missing height takes the place of any number, and stays
                    row[j] = row[j] if top <= row[j] or row[j] != row[j] else top


@kernel(inline=True)
def height_at(grid: F32, c: float, x: float, y: float) -> float:
    """Bilinear height [m] at (x, y) [m]; level within half a cell of the edge, NaN beyond."""
    h, w = grid.shape
    u, v = x / c - 0.5, y / c - 0.5
    if not (u >= -0.5 and v >= -0.5 and u <= w - 0.5 and v <= h - 0.5):
        return np.nan
    u, v = min(max(u, 0.0), w - 1.0), min(max(v, 0.0), h - 1.0)
    j, i = min(int(u), w - 2), min(int(v), h - 2)
    u, v = u - j, v - i
    total = 0.0
    if v < 1.0:
        total += (1.0 - v) * _between(grid[i, j], grid[i, j + 1], u)
    if v > 0.0:
        total += v * _between(grid[i + 1, j], grid[i + 1, j + 1], u)
    return total


@kernel(inline=True)
def _between(left: float, right: float, u: float) -> float:
    """Between two heights; one that does not count may be missing."""
    if u == 0.0:
        return left * 1.0
    if u == 1.0:
        return right * 1.0
    return (1.0 - u) * left + u * right
