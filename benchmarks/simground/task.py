"""The ground and the rovers of all rows."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

SIDE, ROVERS, BEAMS, VIEW = 512, 4096, 64, np.pi
REACH, PERIOD, STEPS = 50, 0.2, 20
SLOPE, ROCKS = 7.0, 0.05
"""Root mean square slope over 2 m [deg], share of the ground that rocks cover."""


class Setting(NamedTuple):
    """A rover on ground to its measure.

    Attributes:
        rover: Preset.
        cell: Distance of posts [m].
        eye: Height of its range finder over the ground [m].
    """

    rover: str
    cell: float
    eye: float


SIX = Setting("perseverance", 0.2, 0.8)
FOUR = Setting("research", 0.05, 0.2)


def heights(setting: Setting) -> Any:
    """Self-affine relief with rocks on it, shrunk with the cell (512, 512), float32 [m]."""
    from rovernav.terrain import Ground, Recipe, Relief

    relief = Relief(hurst=0.8, slope=math.radians(SLOPE), baseline=2.0)
    recipe = Recipe(
        size=(0.2 * SIDE, 0.2 * SIDE), cell=0.2, relief=relief, rocks=ROCKS, rock_sizes=(0.4, 1.2)
    )
    made = Ground.made(recipe, 1).read().height
    return (made * (setting.cell / 0.2)).astype(np.float32)


def starts(setting: Setting, count: int) -> Any:
    """Poses farther from the edge than a beam reaches (n, 3) [m, rad]."""
    rng = np.random.default_rng(2)
    low, high = (REACH + 10) * setting.cell, (SIDE - REACH - 10) * setting.cell
    return np.c_[rng.uniform(low, high, (count, 2)), rng.uniform(-np.pi, np.pi, count)]
