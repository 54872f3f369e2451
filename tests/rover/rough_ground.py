"""Rough ground with rocks for the tests of settling and its bound."""

from __future__ import annotations

import math

import numpy as np
from scipy import ndimage

from rovernav.terrain import Terrain, scatter_rocks, with_rocks
from tests.terrain.ground import ground


def rough_ground(
    seed: int, *, slope: float = 0.0, cover: float = 0.0, cell: float = 0.1, cells: int = 160
) -> Terrain:
    """A slope with bumps of several sizes, and rocks over a share of it."""
    rng = np.random.default_rng(seed)
    i, j = np.indices((cells, cells))
    way = rng.uniform(-math.pi, math.pi)
    z = (j * math.cos(way) + i * math.sin(way)) * cell * math.tan(slope)
    for size in (3, 9, 27):
        bumps = ndimage.gaussian_filter(rng.normal(size=(cells, cells)), size)
        z = z + bumps * size * cell * 0.7
    terrain = ground(z, cell)
    if cover == 0.0:
        return terrain
    rocks = scatter_rocks(terrain.frame, cover, smallest=cell, largest=2.0, rng=rng)
    return with_rocks(terrain, rocks)


def poses(rng: np.random.Generator, terrain: Terrain, count: int, margin: float) -> np.ndarray:
    """Random poses, `margin` [m] off the edge."""
    width, height = terrain.frame.extent
    x, y = rng.uniform(margin, width - margin, count), rng.uniform(margin, height - margin, count)
    return np.stack([x, y, rng.uniform(-math.pi, math.pi, count)], axis=1)
