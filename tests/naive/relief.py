"""Slope and ledges, written as one would explain them; slow."""

from __future__ import annotations

import math

import numpy as np


def horn(z: np.ndarray, cell: float) -> np.ndarray:
    """Slope [rad] from the eight neighbours, those beside the middle counting twice."""
    h, w = z.shape
    out = np.full(z.shape, math.nan)
    for i in range(h):
        for j in range(w):
            a, b = min(max(i, 1), h - 2), min(max(j, 1), w - 2)
            p = q = 0.0 * float(z[a, b])
            for k, weight in ((-1, 1), (0, 2), (1, 1)):
                p += weight * (float(z[a + k, b + 1]) - float(z[a + k, b - 1]))
                q += weight * (float(z[a + 1, b + k]) - float(z[a - 1, b + k]))
            out[i, j] = math.atan(math.sqrt(p * p + q * q) / (8 * cell))
    return out


def fitted(z: np.ndarray, cell: float, reach: int) -> np.ndarray:
    """Slope [rad] of the plane that NumPy's least squares fits to each window."""
    h, w = z.shape
    steps = range(-reach, reach + 1)
    design = np.array([[1.0, u * cell, v * cell] for v in steps for u in steps])
    out = np.full(z.shape, math.nan)
    for i in range(h):
        for j in range(w):
            a, b = min(max(i, reach), h - 1 - reach), min(max(j, reach), w - 1 - reach)
            heights = z[a - reach : a + reach + 1, b - reach : b + reach + 1].ravel()
            if not np.isnan(heights).any():
                _, p, q = np.linalg.lstsq(design, heights.astype(np.float64), rcond=None)[0]
                out[i, j] = math.atan(math.hypot(p, q))
    return out


def ledge(z: np.ndarray, cell: float, reach: int, steeper: float) -> np.ndarray:
    """Largest rise [m] to a post on one of eight rays that is steeper than `steeper` [rad]."""
    h, w = z.shape
    out = np.where(np.isnan(z), np.nan, 0.0)
    rays = [(di, dj) for di in (-1, 0, 1) for dj in (-1, 0, 1) if (di, dj) != (0, 0)]
    for i in range(h):
        for j in range(w):
            for di, dj in rays:
                for k in range(1, reach + 1):
                    a, b = i + k * di, j + k * dj
                    if not (0 <= a < h and 0 <= b < w) or math.isnan(z[i, j]):
                        continue
                    rise = abs(float(z[a, b]) - float(z[i, j]))
                    if rise > math.tan(steeper) * cell * k * math.hypot(di, dj):
                        out[i, j] = max(out[i, j], rise)
    return out
