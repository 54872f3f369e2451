"""What a grid of heights does from cell to cell.

Symbols: z height [m], c cell [m], p = dz/dx, q = dz/dy [1], r reach [cells].
A missing height is NaN and makes every sum it enters NaN. All inputs are C-ordered and read-only.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._jit import kernel

F32: TypeAlias = NDArray[np.float32]

_TWO = np.float64(2.0)  # times a short float it gives a long one, compiled or not


@kernel()
def horn(z: F32, c: float, p: F32, q: F32) -> None:
    """Write Horn's (1981) weighted differences of `z` (h, w) to `p`, `q` (h-2, w-2)."""
    h, w = p.shape
    for i in range(h):
        for j in range(w):
            west = _TWO * z[i + 1, j] + z[i, j] + z[i + 2, j]
            east = _TWO * z[i + 1, j + 2] + z[i, j + 2] + z[i + 2, j + 2]
            south = _TWO * z[i, j + 1] + z[i, j] + z[i, j + 2]
            north = _TWO * z[i + 2, j + 1] + z[i + 2, j] + z[i + 2, j + 2]
            nothing = 0.0 * z[i + 1, j + 1]  # NaN where the middle height is missing
            p[i, j] = (east - west) / (8.0 * c) + nothing
            q[i, j] = (north - south) / (8.0 * c) + nothing


@kernel()
def plane(z: F32, c: float, r: int, p: F32, q: F32) -> None:
    """Write the tilt of the least-squares plane over (2r+1)^2 cells of `z` to `p`, `q`.

    `z` is (h, w), the others (h-2r, w-2r): only windows wholly on the grid. With u, v = -r..r
    counted from the middle, the normal equations of z = a + p u c + q v c are diagonal:
    p = sum(u z) / (n s c), q = sum(v z) / (n s c), where n = 2r+1 and s = sum(u^2). Sums run down
    the columns first, then along the row of sums.
    """
    h, w = p.shape
    n = 2 * r + 1
    scale = 1.0 / (n * (r * (r + 1) * n / 3.0) * c)
    column = np.empty(w + 2 * r)
    lever = np.empty(w + 2 * r)
    for i in range(h):
        for j in range(w + 2 * r):
            total, moment = np.float64(0.0), np.float64(0.0)
            for v in range(n):
                total += z[i + v, j]
                moment += np.float64(v - r) * z[i + v, j]
            column[j], lever[j] = total, moment
        for j in range(w):
            along, across = 0.0, 0.0
            for u in range(n):
                along += (u - r) * column[j + u]
                across += lever[j + u]
            p[i, j], q[i, j] = along * scale, across * scale


@kernel()
def ledge(z: F32, r: int, rise: float, out: F32) -> None:
    """Write the largest |dz| to posts 1..r cells away, in eight directions, to `out` (h, w).

    Only differences above `rise` [m per cell of distance] count; 0 where there is none, NaN where
    `z` is.
    """
    h, w = z.shape
    for i in range(h):
        for j in range(w):
            out[i, j] = _highest_ledge(z, i, j, r, rise)


@kernel()
def _highest_ledge(z: F32, i: int, j: int, r: int, rise: float) -> float:
    h, w = z.shape
    here = np.float64(z[i, j])
    best = 0.0 * here  # NaN where the height is missing
    for di in range(-1, 2):
        for dj in range(-1, 2):
            if di == 0 and dj == 0:
                continue
            pace = rise * np.sqrt(float(di * di + dj * dj))
            for k in range(1, r + 1):
                y, x = i + k * di, j + k * dj
                if y < 0 or y >= h or x < 0 or x >= w:
                    break
                dz = abs(z[y, x] - here)
                if dz > k * pace and dz > best:
                    best = dz
    return best
