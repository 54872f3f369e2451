"""Slope, steps and shaded relief of a terrain.

Slopes come from windows that lie wholly on the grid. A cell too near the edge for a window around
it takes the slope of the nearest window: so edge cells have values too, as sure as those inside,
and exact on planes.
"""

from __future__ import annotations

import math

import numpy as np

from ..core import F32, value
from ..kernels import relief as k
from ._elevation import Terrain

SUN_AZIMUTH = math.radians(315.0)
SUN_ALTITUDE = math.radians(45.0)


def slope(terrain: Terrain) -> F32:
    """Slope angle (h, w) [rad] by Horn's 3 x 3 differences; NaN where a height of the nine is.

    Source: B. K. P. Horn, Hill shading and the reflectance map, Proc. IEEE 69 (1981).
    """
    p, q = _horn(terrain)
    return _to_the_edge(np.arctan(np.hypot(p, q)), 1)


def slope_over(terrain: Terrain, length: float) -> F32:
    """Slope angle (h, w) [rad] of the plane fitted to a square of about `length` [m].

    Noise of single posts is averaged away, as a body of that length would feel the ground. The
    square has an odd number of cells, at least 3 x 3 and at most what the grid holds; NaN where
    one of its heights is missing.
    """
    return planes_over(terrain, length).slope()


@value
class Planes:
    """Planes fitted to a square around each cell; NaN where one of its heights is missing.

    Attributes:
        east: Rise per metre to the east (h, w), float32.
        north: Rise per metre to the north (h, w), float32.
        rms: Root mean square of what the plane leaves over (h, w), float32 [m].
        posts: Posts along a side of the square.
    """

    east: F32
    north: F32
    rms: F32
    posts: int

    def slope(self) -> F32:
        """Angle of the planes (h, w), float32 [rad]."""
        out = np.empty(self.east.shape, np.float32)
        k.steepness(self.east, self.north, out)
        return out


def planes_over(terrain: Terrain, length: float) -> Planes:
    """The planes of `slope_over`: how the ground rises over about `length` [m], and how roughly."""
    reach = _reach(length, terrain)
    h, w = terrain.frame.shape
    whole = np.empty((3, h, w), np.float32)
    k.plane(terrain.whole, terrain.frame.cell, reach, whole)
    for grid in whole:
        _spread(grid, reach)
    return Planes(east=whole[0], north=whole[1], rms=whole[2], posts=2 * reach + 1)


def _spread(grid: F32, reach: int) -> None:
    """Give cells near the edge the value of the nearest one that has a window."""
    grid[:, :reach], grid[:, -reach:] = grid[:, [reach]], grid[:, [-reach - 1]]
    grid[:reach], grid[-reach:] = grid[reach], grid[-reach - 1]


def step_height(terrain: Terrain) -> F32:
    """Largest height difference (h, w) [m] to the eight neighbours; NaN where there is no data.

    Neighbours that are missing or beyond the edge are left out.
    """
    return ledge_height(terrain)


def ledge_height(terrain: Terrain, *, within: float = 0.0, steeper: float = 0.0) -> F32:
    """Height (h, w) [m] of the highest ledge at each cell; NaN where there is no data.

    A ledge is a rise between two posts in one of the eight directions that is steeper than a slope
    of `steeper`; both its ends count. On posts far apart a gentle slope rises by more than a wheel
    can climb, yet holds no ledge.

    Args:
        terrain: The ground.
        within: Farthest posts compared [m]; neighbours always are.
        steeper: Slope that a ledge exceeds [rad].
    """
    out = np.empty(terrain.frame.shape, np.float32)
    reach = max(1, round(within / terrain.frame.cell))
    k.ledge(terrain.whole, reach, math.tan(steeper) * terrain.frame.cell, out)
    return out


def hillshade(
    terrain: Terrain, *, azimuth: float = SUN_AZIMUTH, altitude: float = SUN_ALTITUDE
) -> F32:
    """Brightness (h, w) of the ground under a sun, 0 (turned away) to 1; NaN as in `slope`.

    Args:
        terrain: The ground.
        azimuth: Direction of the sun, clockwise from north [rad].
        altitude: Height of the sun over the horizon [rad].
    """
    p, q = _horn(terrain)
    east = math.sin(azimuth) * math.cos(altitude)
    north = math.cos(azimuth) * math.cos(altitude)
    lit = (math.sin(altitude) - east * p - north * q) / np.sqrt(1.0 + p * p + q * q)
    return _to_the_edge(np.clip(lit, 0.0, 1.0).astype(np.float32), 1)


def _horn(terrain: Terrain) -> tuple[F32, F32]:
    p, q = _inside(terrain, 1), _inside(terrain, 1)
    k.horn(terrain.height, terrain.frame.cell, p, q)
    return p, q


def _reach(length: float, terrain: Terrain) -> int:
    """Cells on each side of the middle one that make a window of about `length` [m]."""
    fits = (min(terrain.frame.shape) - 1) // 2
    return min(max(1, round(length / (2.0 * terrain.frame.cell))), fits)


def _inside(terrain: Terrain, reach: int) -> F32:
    """Room for the cells that have `reach` more on each side."""
    h, w = terrain.frame.shape
    return np.empty((h - 2 * reach, w - 2 * reach), np.float32)


def _to_the_edge(inside: F32, reach: int) -> F32:
    """A value for every cell: those near the edge take the nearest."""
    return np.pad(inside, reach, mode="edge")
