"""What a path is worth: how near it came to harm, how steep it was."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ..core import F64
from ..kernels import geometry
from ..kernels import shapes as rounded
from ._world import Grid, Worlds


def path_length(path: F64) -> float:
    """Length of a path (k, 2) [m]."""
    return float(np.sum(np.hypot(*np.diff(path, axis=0).T)))


def tilt(attitude: F64) -> F64:
    """Angle of the body against level [rad] from attitudes (..., 3): height, pitch, roll."""
    level = np.cos(attitude[..., 1]) * np.cos(attitude[..., 2])
    return np.arccos(np.clip(level, -1.0, 1.0))


def clearance(path: F64, worlds: Worlds, k: int = 0) -> float:
    """Smallest distance of a path's SEGMENTS to anything rover k must not touch [m].

    Args:
        path: Points (p, 2) [m]; a single point counts as a segment of no length.
        worlds: Where it was driven.
        k: Whose world.

    Returns:
        0 where the path touches something, inf where there is nothing to touch.
    """
    points = np.ascontiguousarray(path if len(path) > 1 else np.repeat(path, 2, axis=0))
    world = int(worlds.of[k])
    boxes = worlds.boxes[worlds.offsets[world] : worlds.offsets[world + 1]]
    shapes = worlds.shapes_of(k)
    best = np.inf
    for a, b in pairwise(points):
        for box in boxes:
            best = min(best, geometry.segment_box(a[0], a[1], b[0], b[1], box))
        for shape in shapes:
            corners = np.ascontiguousarray(shape.corners)
            gap = rounded.segment_shape(a[0], a[1], b[0], b[1], corners, float(shape.radius))
            best = min(best, gap)
    grid = worlds.row(k).grid
    if grid is not None:
        best = min(best, _to_grid(points, grid))
    return float(best)


def _to_grid(points: F64, grid: Grid) -> float:
    """Distance [m] of a path to the nearest blocked cell; the exact squares, not their centres."""
    from scipy.ndimage import distance_transform_edt

    if not grid.blocked.any():
        return float("inf")
    cell = grid.frame.cell
    cells = points / cell
    far = np.asarray(distance_transform_edt(grid.blocked == 0))
    segments = np.concatenate([cells[:-1], cells[1:]], axis=1)
    rows = np.clip(cells[:-1, 1], 0, grid.blocked.shape[0] - 1).astype(int)
    columns = np.clip(cells[:-1, 0], 0, grid.blocked.shape[1] - 1).astype(int)
    middle = far[rows, columns]
    slack = np.hypot(cells[:-1, 0] - columns, cells[:-1, 1] - rows) + 2.0
    along = np.hypot(*np.diff(cells, axis=0).T)
    least = middle - slack - along
    order = np.argsort(least, kind="stable")
    found = geometry.closest_cell(
        segments[order], grid.blocked, (middle + slack + along)[order], least[order]
    )
    return found * cell
