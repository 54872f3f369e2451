"""The ground as a surface in three dimensions: points and the colours that lie on them."""

from __future__ import annotations

import numpy as np

from ..core import F64, U8, value
from ..rover import Standing
from ..terrain import Terrain
from ._relief import PIXELS, Window, relief_pixels


@value
class Surface:
    """Points of the ground on a lattice, row by row from the north, and their colours.

    Attributes:
        x: East (w,) [m].
        y: North (h,) [m], falling.
        z: Height (h, w) above the lowest point of the terrain [m]; NaN without data.
        colours: Shaded relief (p, q, 3) that covers the lattice, row 0 in the north.
    """

    x: F64
    y: F64
    z: F64
    colours: U8


def surface_of(
    terrain: Terrain,
    *,
    window: Window | None = None,
    standing: Standing | None = None,
    points: int = 128,
    pixels: int = PIXELS,
) -> Surface:
    """A terrain, or a part of it, as a surface.

    Args:
        terrain: The ground.
        window: Which part [m]; all by default.
        standing: Where a rover could stand, drawn by reason.
        points: Points along a side at most.
        pixels: Cells along a side of the colours at most.
    """
    colours, (west, south, east, north) = relief_pixels(
        terrain, window=window, standing=standing, pixels=pixels
    )
    cell = terrain.frame.cell
    width = min(points, max(2, round((east - west) / cell)))
    height = min(points, max(2, round((north - south) / cell)))
    far_x, far_y = terrain.frame.extent  # which thinned colours may reach beyond
    x = np.minimum(np.linspace(west, east, width), far_x)
    y = np.minimum(np.linspace(north, south, height), far_y)
    z = terrain.elevation_at(*np.meshgrid(x, y)) - terrain.span[0]
    return Surface(x=x, y=y, z=np.asarray(z, np.float64), colours=colours)
