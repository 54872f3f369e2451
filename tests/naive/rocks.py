"""Rocks on a grid, cell by cell; slow."""

from __future__ import annotations

import math
from typing import Any

import numpy as np


def raised(columns: Any, shape: tuple[int, int], cell: float) -> np.ndarray:
    """Height [m] of the highest half ellipsoid over each cell centre."""
    out = np.zeros(shape)
    for i in range(shape[0]):
        for j in range(shape[1]):
            for x, y, diameter, height in zip(*columns, strict=True):
                d = math.hypot((j + 0.5) * cell - x, (i + 0.5) * cell - y) / (diameter / 2)
                if math.floor(x / cell) == j and math.floor(y / cell) == i:
                    top = height
                else:
                    top = height * math.sqrt(max(0.0, 1.0 - d * d))
                out[i, j] = max(out[i, j], top)
    return out
