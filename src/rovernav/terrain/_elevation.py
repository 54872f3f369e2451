"""Ground heights on a grid: the value that every reader and generator of ground returns."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core import F32, F64, Frame, InputError, ShapeError, value

HIGHEST = 1e5
"""No known ground lies farther than this from its datum [m]; larger numbers mark missing data."""


@value
class Terrain:
    """Ground heights at the centres of square cells.

    Attributes:
        frame: Where the cells lie; row 0 is the SOUTH edge, column 0 the west edge.
        height: Heights (h, w) above `offset`, float32 [m]; NaN means "no data".
        offset: The height that `height` counts from [m]. Short floats near -2600 m would be exact
            to 0.2 mm only; above a float64 offset they keep micrometres.
        name: Short name for titles and file names.
        source: Where the heights come from, for reports.
        plain: Whether this is a map of free and blocked cells: level ground, without a height where
            something stands or nothing is known. What is missing then says nothing of its
            neighbours.
    """

    frame: Frame
    height: F32
    offset: float
    name: str
    source: str
    plain: bool = False

    def _check(self) -> None:
        if self.height.dtype != np.float32 or self.height.shape != self.frame.shape:
            raise ShapeError(
                f"terrain heights must be float32 of the frame's shape {self.frame.shape}, got "
                f"{self.height.dtype} of shape {self.height.shape}; use Terrain.from_heights"
            )
        if not self.height.flags.c_contiguous:
            contiguous = np.ascontiguousarray(self.height)
            contiguous.flags.writeable = False
            object.__setattr__(self, "height", contiguous)

    @classmethod
    def from_heights(
        cls, heights: Any, frame: Frame, *, name: str, source: str, plain: bool = False
    ) -> Terrain:
        """A terrain from absolute heights (h, w) [m], row 0 south, NaN where there is no data.

        Raises:
            ShapeError: Not two-dimensional, smaller than 3 x 3 or not of the frame's shape.
            InputError: No height at all, an infinite one, or one beyond 100 km.
        """
        heights = np.asarray(heights)
        lowest = _lowest(heights, source)
        offset = float(np.floor(lowest))
        short = np.empty(heights.shape, np.float32)
        np.subtract(heights, offset, out=short, dtype=np.float64, casting="unsafe")
        return cls(frame=frame, height=short, offset=offset, name=name, source=source, plain=plain)

    @property
    def whole(self) -> F32:
        """The heights (h, w) over `offset` [m], level also under what stands on a `plain`."""
        return np.nan_to_num(self.height) if self.plain else self.height

    @property
    def finite(self) -> float:
        """Share of the cells that have a height, 0 to 1."""
        return float(np.isfinite(self.height).mean())

    @property
    def span(self) -> tuple[float, float]:
        """Lowest and highest height [m], the offset included."""
        low, high = np.nanmin(self.height), np.nanmax(self.height)
        return self.offset + float(low), self.offset + float(high)

    def elevation_at(self, x: float | F64, y: float | F64) -> F64:
        """Height [m] at local points, bilinear between the four nearest cell centres.

        Within half a cell of the edge the height of the outermost cells goes on level.

        Args:
            x: East [m], a number or an array.
            y: North [m], of a shape that fits `x`.

        Returns:
            Heights, float64, of the common shape; NaN off the grid and wherever one of the four
            cells that count (weight above zero) has no data.
        """
        h, w = self.frame.shape
        width, height = self.frame.extent
        x, y = np.broadcast_arrays(np.asarray(x, np.float64), np.asarray(y, np.float64))
        inside = (x >= 0) & (x <= width) & (y >= 0) & (y <= height)
        j, right = _between(np.where(inside, x, 0.0) / self.frame.cell, w)
        i, up = _between(np.where(inside, y, 0.0) / self.frame.cell, h)
        total = np.zeros(x.shape)
        for di, wi in ((0, 1 - up), (1, up)):
            for dj, wj in ((0, 1 - right), (1, right)):
                weight = wi * wj
                z = self.height[np.minimum(i + di, h - 1), np.minimum(j + dj, w - 1)]
                total += np.where(weight > 0, weight * z, 0.0)
        return np.where(inside, total + self.offset, np.nan)[()]


def _between(position: F64, count: int) -> tuple[Any, F64]:
    """Index of the cell centre at or before `position` [cells], and how far on, 0 to 1."""
    from_first = np.clip(position - 0.5, 0.0, count - 1.0)
    index = from_first.astype(np.int64)
    return index, from_first - index


def _lowest(heights: Any, source: str) -> float:
    """The lowest height [m], after every check that heights of any origin must pass."""
    if heights.ndim != 2 or min(heights.shape) < 3:
        raise ShapeError(
            f"{source}: ground needs at least 3 x 3 heights, got shape {heights.shape}; "
            "give a two-dimensional grid"
        )
    if heights.dtype.kind == "f" and np.isinf(heights).any():
        count = int(np.isinf(heights).sum())
        raise InputError(
            f"{source}: {count} heights are infinite; mark missing heights as NaN or as nodata"
        )
    if np.isnan(heights).all():
        raise InputError(f"{source}: every height is missing; check the file's nodata value")
    low, high = float(np.nanmin(heights)), float(np.nanmax(heights))
    if max(-low, high) > HIGHEST:
        raise InputError(
            f"{source}: heights from {low:g} to {high:g} m go beyond 100 km; if one of them marks "
            "missing data, set it as the file's nodata value"
        )
    return low
