"""Where bilinear ground rises to a segment: every patch of the grid is tried; slow."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np


def first_rise(a: Any, b: Any, heights: np.ndarray, c: float) -> float | None:
    """Smallest t at which the ground is at or above the segment; None: nowhere."""
    h, w = heights.shape
    padded = np.pad(heights.astype(float), 1, mode="edge")
    met = (
        _patch(a, b, (i, j), padded[i : i + 2, j : j + 2], c, (h, w))
        for i in range(h + 1)
        for j in range(w + 1)
    )
    return min((t for t in met if t is not None), default=None)


def _patch(
    a: Any,
    b: Any,
    at: tuple[int, int],
    posts: np.ndarray,
    c: float,
    shape: tuple[int, int],
) -> float | None:
    if not np.isfinite(posts).all():
        return None
    begin, end, place, rate = 0.0, 1.0, [0.0, 0.0], [0.0, 0.0]
    for axis in (0, 1):
        count, low = shape[1 - axis], at[1 - axis]
        start, d = a[axis] / c + 0.5, (b[axis] - a[axis]) / c
        place[axis], rate[axis] = start, d
        for least, most in ((low, low + 1), (0.5, count + 0.5)):
            if d == 0.0:
                if not least <= start <= most:
                    return None
                continue
            near, far = sorted(((least - start) / d, (most - start) / d))
            begin, end = max(begin, near), min(end, far)
    if begin > end:
        return None

    def above(t: float) -> float:
        p, q = place[0] + t * rate[0] - at[1], place[1] + t * rate[1] - at[0]
        (z00, z01), (z10, z11) = posts.tolist()
        ground = (1 - q) * ((1 - p) * z00 + p * z01) + q * ((1 - p) * z10 + p * z11)
        return ground - (a[2] + t * (b[2] - a[2]))

    return _root(above, begin, end)


def _root(f: Callable[[float], float], begin: float, end: float) -> float | None:
    """First t at which a parabola is 0 or more: its peak from three values, then by halving."""
    if f(begin) >= 0:
        return begin
    middle = 0.5 * (begin + end)
    low, mid, high = f(begin), f(middle), f(end)
    bend = 2 * (low - 2 * mid + high)
    peak = end
    if bend < 0 and end > begin:
        peak = begin + (end - begin) * min(1.0, max(0.0, -(high - low - bend) / (2 * bend)))
    if f(peak) < 0:
        peak = end
    if f(peak) < 0:
        return None
    below, above = begin, peak
    for _ in range(200):
        half = 0.5 * (below + above)
        if half in (below, above) or math.isnan(half):
            break
        below, above = (below, half) if f(half) >= 0 else (half, above)
    return above
