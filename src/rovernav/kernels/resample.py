"""Heights between the posts of another grid, and means over blocks of cells.

A missing height is NaN. All inputs are C-ordered.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._jit import kernel

F64: TypeAlias = NDArray[np.float64]
I64: TypeAlias = NDArray[np.int64]


@kernel()
def resample(z: F64, at: F64, first: I64, whole: I64, steps: I64, out: F64) -> None:
    """Write heights between posts to `out` (h, w), bilinear.

    Cell (i, j) of a large grid lies at the post row ``at[0] + at[1] i + at[2] j`` and the post
    column ``at[3] + at[4] i + at[5] j`` of a file of ``whole`` (rows, columns) posts; post (0, 0)
    of `z` is post ``first[2:]`` of the file, and ``out[0, 0]`` is cell ``first[:2]``. The cell is
    the mean of ``steps`` (rows, columns) places spread evenly over it. It has a height where the
    posts nearest to at least half of those places do; a place beyond the file by more than half a
    post has none.
    """
    h, w = out.shape
    count = steps[0] * steps[1]
    for i in range(h):
        for j in range(w):
            total, known = 0.0, 0
            for a in range(steps[0]):
                y = first[0] + i + (a + 0.5) / steps[0] - 0.5
                for b in range(steps[1]):
                    x = first[1] + j + (b + 0.5) / steps[1] - 0.5
                    r = at[0] + at[1] * y + at[2] * x
                    c = at[3] + at[4] * y + at[5] * x
                    here = between(z, r, c, first, whole)
                    if not np.isnan(here):
                        total += here
                        known += 1
            out[i, j] = total / known if 2 * known >= count else np.nan


@kernel()
def between(z: F64, r: float, c: float, first: I64, whole: I64) -> float:
    """The height at post row r and column c; NaN where the nearest post has none."""
    if not (-0.5 - 1e-6 <= r <= whole[0] - 0.5 + 1e-6):
        return np.nan
    if not (-0.5 - 1e-6 <= c <= whole[1] - 0.5 + 1e-6):
        return np.nan
    r, c = min(max(r, 0.0), whole[0] - 1.0), min(max(c, 0.0), whole[1] - 1.0)
    i, j = int(r), int(c)
    u, v = r - i, c - j
    if np.isnan(_post(z, i + int(u >= 0.5), j + int(v >= 0.5), first)):
        return np.nan
    total, weight = 0.0, 0.0
    for di in range(2):
        for dj in range(2):
            share = (u if di else 1.0 - u) * (v if dj else 1.0 - v)
            if share > 0.0:
                here = _post(z, i + di, j + dj, first)
                if not np.isnan(here):
                    total += share * here
                    weight += share
    return total / weight


@kernel()
def _post(z: F64, i: int, j: int, first: I64) -> float:
    return np.float64(z[i - first[2], j - first[3]])


@kernel()
def block_means(z: F64, n: int, out: F64) -> None:
    """Write the mean of each n x n block of `z` to `out`; NaN where fewer than half are known.

    Blocks beyond the edge of `z` hold what is there; the missing rest counts as unknown.
    """
    h, w = out.shape
    rows, columns = z.shape
    for i in range(h):
        for j in range(w):
            total, known = 0.0, 0
            for a in range(i * n, min(i * n + n, rows)):
                for b in range(j * n, min(j * n + n, columns)):
                    if not np.isnan(z[a, b]):
                        total += z[a, b]
                        known += 1
            out[i, j] = total / known if 2 * known >= n * n else np.nan
