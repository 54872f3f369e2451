"""Where a grid lies: the frame that ties cells, local metres and map coordinates together."""

from __future__ import annotations

import numpy as np

from .errors import InputError
from .values import value


@value
class Frame:
    """A grid of square cells in a local metric frame: x east, y north [m].

    Row i runs along +y and column j along +x, so row 0 is the south edge. The local frame's (0, 0)
    is the south-west corner of cell (0, 0); cell (i, j) covers ``[j, j+1] x [i, i+1]`` times
    `cell`. Poses are local float64 metres, because eastings are too large for short floats.

    Attributes:
        cell: Side of a cell [m].
        shape: Rows and columns (h, w).
        origin: Map coordinates (x, y) of the local (0, 0) [m].
        crs: Coordinate reference system as WKT, or None where the grid has none.
    """

    cell: float
    shape: tuple[int, int]
    origin: tuple[float, float] = (0.0, 0.0)
    crs: str | None = None

    def _check(self) -> None:
        if not (np.isfinite(self.cell) and self.cell > 0):
            raise InputError(f"a cell must be a positive number of metres, got {self.cell!r}")
        if min(self.shape) < 1:
            raise InputError(f"a grid needs at least one row and column, got shape {self.shape}")

    @property
    def extent(self) -> tuple[float, float]:
        """Width along x and height along y [m]."""
        return self.shape[1] * self.cell, self.shape[0] * self.cell

    def contains(self, x: float, y: float) -> bool:
        """Whether the local point (x, y) [m] lies on the grid, its edge included."""
        width, height = self.extent
        return 0.0 <= x <= width and 0.0 <= y <= height

    def cell_of(self, x: float, y: float) -> tuple[int, int]:
        """Row and column of the cell that holds the local point (x, y) [m]; edges go inward."""
        h, w = self.shape
        return min(int(y // self.cell), h - 1), min(int(x // self.cell), w - 1)

    def centre_of(self, row: int, column: int) -> tuple[float, float]:
        """Local coordinates (x, y) [m] of a cell's centre."""
        return (column + 0.5) * self.cell, (row + 0.5) * self.cell

    def to_local(self, x: float, y: float) -> tuple[float, float]:
        """Local metres of the map coordinates (x, y)."""
        return x - self.origin[0], y - self.origin[1]

    def to_map(self, x: float, y: float) -> tuple[float, float]:
        """Map coordinates of the local point (x, y) [m]."""
        return x + self.origin[0], y + self.origin[1]
