"""Where a grid lies: the frame that ties cells, local metres and map coordinates together."""

from __future__ import annotations

import numpy as np

from .errors import InputError, SettingError, suggest
from .values import value

Axes = tuple[tuple[float, float], tuple[float, float]]
PLAIN: Axes = ((1.0, 0.0), (0.0, 1.0))
"""Map coordinates that are local metres counted from another place."""
FRAMES = ("crs", "local", "pixel")
"""In what people give a point: map coordinates, local metres, or pixels of the image."""


@value
class Frame:
    """A grid of square cells in a local metric frame: x east, y north [m].

    Row i runs along +y and column j along +x, so row 0 is the south edge. The local frame's (0, 0)
    is the south-west corner of cell (0, 0); cell (i, j) covers ``[j, j+1] x [i, i+1]`` times
    `cell`. Poses are local float64 metres, because eastings are too large for short floats.

    A projection's metres are rarely true ones, and some maps count in degrees or feet. Local metres
    are true; `axes` says how many map units one of them is, so that ``map = origin + axes @ local``
    holds exactly both ways.

    Attributes:
        cell: Side of a cell [m].
        shape: Rows and columns (h, w).
        origin: Map coordinates (x, y) of the local (0, 0) [map units].
        crs: Coordinate reference system as WKT, or None where the grid has none.
        axes: Map units per local metre: ((x along x, x along y), (y along x, y along y)).
    """

    cell: float
    shape: tuple[int, int]
    origin: tuple[float, float] = (0.0, 0.0)
    crs: str | None = None
    axes: Axes = PLAIN

    def _check(self) -> None:
        if not (np.isfinite(self.cell) and self.cell > 0):
            raise InputError(f"a cell must be a positive number of metres, got {self.cell!r}")
        if min(self.shape) < 1:
            raise InputError(f"a grid needs at least one row and column, got shape {self.shape}")
        if not (np.isfinite(self.axes).all() and self._area > 0):
            raise InputError(f"the axes of a frame must span an area, got {self.axes}")

    @property
    def _area(self) -> float:
        (xx, xy), (yx, yy) = self.axes
        return xx * yy - xy * yx

    @property
    def extent(self) -> tuple[float, float]:
        """Width along x and height along y [m]."""
        return self.shape[1] * self.cell, self.shape[0] * self.cell

    @property
    def map_cell(self) -> tuple[float, float]:
        """Width and height of a cell in map units."""
        return self.cell * self.axes[0][0], self.cell * self.axes[1][1]

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
        x, y = x - self.origin[0], y - self.origin[1]
        if self.axes == PLAIN:
            return x, y
        (xx, xy), (yx, yy) = self.axes
        return (yy * x - xy * y) / self._area, (xx * y - yx * x) / self._area

    def to_map(self, x: float, y: float) -> tuple[float, float]:
        """Map coordinates of the local point (x, y) [m]."""
        if self.axes != PLAIN:
            (xx, xy), (yx, yy) = self.axes
            x, y = xx * x + xy * y, yx * x + yy * y
        return x + self.origin[0], y + self.origin[1]

    def place(self, x: float, y: float, given: str = "crs") -> tuple[float, float]:
        """Local metres of a point that is given in one of `FRAMES`.

        Args:
            x: Along x; for ``pixel`` the column, counted from the left of the image.
            y: Along y; for ``pixel`` the row, counted from the top. Whole numbers are the middles
                of pixels.
            given: ``crs``, ``local`` or ``pixel``.

        Raises:
            SettingError: There is no such frame.
        """
        if given not in FRAMES:
            raise SettingError(f"there is no frame {given!r}; {suggest(given, FRAMES)}")
        if given == "local":
            return x, y
        if given == "pixel":
            return (x + 0.5) * self.cell, (self.shape[0] - y - 0.5) * self.cell
        return self.to_local(x, y)

    def part(self, row: int, column: int, shape: tuple[int, int], factor: int = 1) -> Frame:
        """The frame of a part: its first row and column, its shape, `factor` cells to one."""
        corner = self.to_map(column * self.cell, row * self.cell)
        cell = self.cell * factor
        return Frame(cell=cell, shape=shape, origin=corner, crs=self.crs, axes=self.axes)
