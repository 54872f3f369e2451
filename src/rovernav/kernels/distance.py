"""How far cells are from marked ones, exactly; and which reason keeps a rover off a cell.

Symbols: g distance to the nearest mark in the same column, d its square over all columns [cells].
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._jit import kernel

F32: TypeAlias = NDArray[np.float32]
I32: TypeAlias = NDArray[np.int32]
I64: TypeAlias = NDArray[np.int64]
U8: TypeAlias = NDArray[np.uint8]

FAR = 46_340
"""Distances are told up to this [cells]; its square is the largest that fits a short integer."""


@kernel()
def reasons(slope: F32, step: F32, limits: tuple[float, float], out: U8) -> None:
    """Write 1 (no data), 2 (slope) or 3 (step) to `out` (h, w) where a limit is broken, else 0."""
    steepest, highest = limits
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            a, b = slope[i, j], step[i, j]
            high = np.uint8(3) if np.float64(b) > highest else np.uint8(0)
            steep = np.uint8(2) if np.float64(a) > steepest else high
            out[i, j] = np.uint8(1) if a != a else steep


@kernel()
def columns(marked: U8, g: I32) -> None:
    """Write the distance to the nearest non-zero cell of the same column to `g` (h, w) [cells]."""
    h, w = marked.shape
    for j in range(w):
        g[0, j] = 0 if marked[0, j] else FAR
    for i in range(1, h):
        for j in range(w):
            g[i, j] = 0 if marked[i, j] else g[i - 1, j] + 1
    for i in range(h - 2, -1, -1):
        for j in range(w):
            g[i, j] = min(g[i, j], g[i + 1, j] + 1)


@kernel()
def squares(g: I32) -> None:
    """Turn column distances `g` (h, w) into squared distances over the plane [cells^2], in place.

    Row by row the lower envelope of parabolas (x - k)^2 + g(k)^2. Cells without any mark on the
    grid get at least FAR^2. Source: A. Meijster, J. Roerdink and W. Hesselink, A general algorithm
    for computing distance transforms in linear time (2000).
    """
    h, w = g.shape
    site, start, own = np.empty(w, np.int64), np.empty(w, np.int64), np.empty(w, np.int64)
    for i in range(h):
        row, last = g[i], 0
        for j in range(w):
            own[j] = np.int64(row[j]) * np.int64(row[j])
        site[0], start[0] = 0, 0
        for j in range(1, w):
            while last >= 0:
                k, x = site[last], start[last]
                if (x - k) * (x - k) + own[k] <= (x - j) * (x - j) + own[j]:
                    break
                last -= 1
            if last < 0:
                last, site[0], start[0] = 0, j, 0
                continue
            k = site[last]
            x = 1 + (j * j - k * k + own[j] - own[k]) // (2 * (j - k))
            if x < w:
                last += 1
                site[last], start[last] = j, x
        end = w
        while last >= 0:
            k, height = site[last], own[site[last]]
            for j in range(start[last], end):
                d = (j - k) * (j - k) + height
                row[j] = np.int32(min(d, np.int64(FAR) * FAR))
            end = start[last]
            last -= 1


@kernel()
def near(d: I32, reach: float, out: U8) -> None:
    """Write 4 to `out` (h, w) where it is 0 and the squared distance `d` is at most `reach`."""
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            close = np.float64(d[i, j]) <= reach
            out[i, j] = np.uint8(4) if close and out[i, j] == 0 else out[i, j]


@kernel()
def metres(d: I32, c: float, out: F32) -> None:
    """Write distances [m] of squared distances `d` (h, w) [cells^2] to `out`; infinite if none."""
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            far = d[i, j] >= FAR * FAR
            out[i, j] = np.inf if far else c * np.sqrt(np.float64(d[i, j]))
