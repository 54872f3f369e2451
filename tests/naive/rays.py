"""Free distances and range beams as their definitions say: every cell is tried; slow."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from rovernav.kernels.geometry import first_box


def cone(blocked: np.ndarray, row: int, column: int, step: tuple[int, int], most: int) -> int:
    """Columns to the nearest blocked cell of the cone that opens along `step` (di, dj)."""
    di, dj = step
    for m in range(most):
        for aside in range(-m, m + 1):
            i, j = row + m * di + aside * abs(dj), column + m * dj + aside * abs(di)
            inside = 0 <= i < blocked.shape[0] and 0 <= j < blocked.shape[1]
            if inside and blocked[i, j]:
                return m
    return most


def beam(
    pose: np.ndarray,
    way: np.ndarray,
    reach: float,
    blocked: np.ndarray,
    c: float,
    others: Callable[[float, float, float, float], float] = lambda *_: math.inf,
) -> float:
    """How far a beam goes [m]: the smallest t of the judge over all blocked cells, all others."""
    x, y, cosine, sine = *map(float, pose[:2]), math.cos(pose[2]), math.sin(pose[2])
    ex = x + reach * (cosine * float(way[0]) - sine * float(way[1]))
    ey = y + reach * (sine * float(way[0]) + cosine * float(way[1]))
    t = min(1.0, others(x, y, ex, ey))
    for i, j in np.argwhere(blocked):
        box = (float(j), float(i), j + 1.0, i + 1.0)
        t = min(t, first_box(x / c, y / c, ex / c, ey / c, box))
    return reach * t
