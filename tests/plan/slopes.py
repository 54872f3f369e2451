"""Small grounds that routes are tested on."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from rovernav import plan
from rovernav.core import Frame
from rovernav.rover import Rover, hazards, read_rover
from rovernav.terrain import Terrain


def terrain_of(heights: Any, cell: float = 1.0) -> Terrain:
    heights = np.asarray(heights, np.float64)
    frame = Frame(cell=cell, shape=(heights.shape[0], heights.shape[1]))
    return Terrain.from_heights(heights, frame, name="made", source="a test")


@functools.cache
def rover() -> Rover:
    return read_rover("research")


def bumpy(seed: int, size: int = 20, height: float = 0.9) -> np.ndarray:
    """Smooth hills a few cells wide."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(size), np.arange(size))
    z = np.zeros((size, size))
    for _ in range(max(8, size * size // 40)):
        cx, cy, wide = rng.uniform(0, size), rng.uniform(0, size), rng.uniform(2.0, 4.0)
        z += rng.uniform(-height, height) * np.exp(-((x - cx) ** 2 + (y - cy) ** 2) / wide**2)
    return z


def going_over(heights: Any, objective: str = "energy", **options: Any) -> plan.Going:
    options.setdefault("soil", "loose-sand")
    ground = terrain_of(heights)
    return plan.going(hazards(ground, rover()), rover(), objective=objective, **options)
