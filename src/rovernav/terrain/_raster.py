"""A lazy handle on an elevation file: described at once, read in parts."""

from __future__ import annotations

import contextlib
import dataclasses
import math
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..core import F64, FileError, Float, Frame, InputError, SettingError, value
from ..kernels import resample as k
from ._elevation import Terrain
from ._posts import Lattice, Placing, Posts, Read, lay

MAX_CELLS = 100_000_000
"""Most cells that one reading gives: they take 0.4 GB as heights, and about 1 GB while read."""

STRIP = 8_000_000
"""Cells that are read at a time."""

Progress = Callable[[float], None]
Bounds = tuple[float, float, float, float]
"""West, south, east, north in map coordinates."""


@value
class Window:
    """A rectangle of a raster's cells, at full resolution; row 0 south.

    Attributes:
        row: The first row.
        column: The first column.
        rows: How many rows.
        columns: How many columns.
    """

    row: int
    column: int
    rows: int
    columns: int

    def _check(self) -> None:
        if min(self.row, self.column) < 0 or min(self.rows, self.columns) < 1:
            raise SettingError(
                f"a window needs a first row and column of 0 or more and a size of 1 or more, "
                f"got {self}"
            )


@value
class Raster:
    """An elevation file of any size, as square cells in true metres; nothing is read yet.

    All windows share one local frame, whose metres are true at the point `about`; so the cells of
    two windows lie on one grid, and the same cell has the same height whatever window it is read
    in. Farther from that point a map's metres drift: `Raster.at` moves it.

    Attributes:
        path: The file.
        frame: The whole grid at full resolution.
        name: Short name for titles and file names.
        source: What the file is, for reports.
        notes: What a reader should know: a resampled grid, a coordinate system that does not fit.
        about: Map point where local metres are true.
        placing: Where the file's own posts lie.
        posts: What reads them.
        lattice: How the grid lies over the posts.
        plain: Whether it is a map of free and blocked cells; see `Terrain`.
    """

    path: Path
    frame: Frame
    name: str
    source: str
    notes: tuple[str, ...]
    about: tuple[float, float]
    placing: Placing
    posts: Posts
    lattice: Lattice
    plain: bool = False

    @classmethod
    def over(
        cls, placing: Placing, posts: Posts, *, path: Path, kind: str, name: str | None = None
    ) -> Raster:
        """The raster over a file's posts, its metres true in the middle."""
        lattice = lay(placing, placing.middle, str(path))
        return cls(
            path=path, frame=lattice.frame, name=path.stem if name is None else name,
            source=f"{kind} {path.name}", notes=(lattice.note,) if lattice.note else (),
            about=placing.middle, placing=placing, posts=posts, lattice=lattice,
        )  # fmt: skip

    @property
    def resampled(self) -> bool:
        """Whether cells lie between the file's posts."""
        return self.lattice.at is not None

    def at(self, x: float, y: float) -> Raster:
        """The same file with metres that are true at the map point (x, y).

        Raises:
            FileError: The coordinate system has no such place.
        """
        lattice = lay(self.placing, (x, y), str(self.path))
        return dataclasses.replace(self, frame=lattice.frame, about=(x, y), lattice=lattice)

    def within(self, bounds: Bounds) -> Raster:
        """The same file with metres that are true in the middle of a part of the map.

        Raises:
            FileError: The coordinate system has no such place.
        """
        low = [max(a, b) for a, b in zip(self.bounds[:2], bounds[:2], strict=True)]
        high = [min(a, b) for a, b in zip(self.bounds[2:], bounds[2:], strict=True)]
        return self.at((low[0] + high[0]) / 2, (low[1] + high[1]) / 2)

    def window(self, west: float, south: float, east: float, north: float) -> Window:
        """The cells that a rectangle in map coordinates touches.

        Raises:
            SettingError: It is inside out, or lies off the map.
        """
        if not (west < east and south < north):
            raise SettingError(
                f"a window is written west, south, east, north and spans an area, got "
                f"{west:.10g},{south:.10g},{east:.10g},{north:.10g}"
            )
        corners = [self.frame.to_local(x, y) for x in (west, east) for y in (south, north)]
        x, y = np.array(corners).T / self.frame.cell
        (h, w), slack = self.frame.shape, 1e-6
        row, top = max(0, math.floor(y.min() + slack)), min(h, math.ceil(y.max() - slack))
        column, right = max(0, math.floor(x.min() + slack)), min(w, math.ceil(x.max() - slack))
        if row >= top or column >= right:
            low, high = self.bounds[:2], self.bounds[2:]
            raise SettingError(
                f"the window lies off the map, which reaches from ({low[0]:.10g}, {low[1]:.10g}) "
                f"to ({high[0]:.10g}, {high[1]:.10g})"
            )
        return Window(row=row, column=column, rows=top - row, columns=right - column)

    @property
    def bounds(self) -> Bounds:
        """West, south, east, north of the file in map coordinates."""
        (h, w), (x, y), (dx, dy) = self.placing.shape, self.placing.corner, self.placing.step
        return x, y, x + w * dx, y + h * dy

    @property
    def whole(self) -> Window:
        """The window that is all of it."""
        return Window(row=0, column=0, rows=self.frame.shape[0], columns=self.frame.shape[1])

    def read(
        self,
        window: Window | None = None,
        factor: int = 1,
        *,
        on_progress: Progress | None = None,
    ) -> Terrain:
        """Heights of a window, every `factor` x `factor` cells averaged to one.

        A mean is taken over the cells that have data, and is missing where fewer than half have; on
        a map of free and blocked cells where any is blocked.
        Memory stays bounded by the result: the file is read in strips.

        Args:
            window: The cells; all of them where not given.
            factor: Cells along a side that make one; the last block of a row may be cut short.
            on_progress: Called with the share that is done.

        Raises:
            FileError: Damaged, or more than `MAX_CELLS` cells would result.
            InputError: No height at all, or one that cannot be.
            SettingError: The window leaves the raster, or the factor is below 1.
        """
        window = window or self.whole
        heights = self.heights(window, factor, on_progress=on_progress)
        frame = self.frame.part(window.row, window.column, heights.shape, factor)
        how = f", {factor} x {factor} cells averaged" if factor > 1 else ""
        how = f", resampled to true metres{how}" if self.resampled else how
        return Terrain.from_heights(
            heights, frame, name=self.name, source=self.source + how, plain=self.plain
        )

    def heights(
        self, window: Window, factor: int = 1, *, on_progress: Progress | None = None
    ) -> Float:
        """As `read`, but the bare heights [m], row 0 south; all of them may be missing.

        Raises:
            FileError: Damaged, or more than `MAX_CELLS` cells would result.
            SettingError: The window leaves the raster, or the factor is below 1.
        """
        window = self._checked(window, factor)
        with _answered(self):
            return self._heights(window, factor, on_progress or _silent)

    def parts(
        self, windows: Iterable[Window], beyond: int
    ) -> Iterator[tuple[Window, Window, Float]]:
        """Heights of several windows, read in one go.

        Args:
            windows: Parts of the raster; fastest where each is near to the one before.
            beyond: Cells more on every side, as far as there are any.

        Yields:
            The window, the larger one that was read, and its heights [m], row 0 south; all of them
            may be missing.

        Raises:
            FileError: Damaged.
        """
        h, w = self.frame.shape
        with _answered(self), self.posts.open() as read:
            for window in windows:
                low, left = max(0, window.row - beyond), max(0, window.column - beyond)
                high = min(h, window.row + window.rows + beyond)
                right = min(w, window.column + window.columns + beyond)
                around = Window(row=low, column=left, rows=high - low, columns=right - left)
                yield window, around, self._cells(read, around)

    def describe(self) -> dict[str, Any]:
        """What is known without reading heights; lengths in true metres."""
        return {
            "source": self.source,
            "columns": self.frame.shape[1],
            "rows": self.frame.shape[0],
            "cell_m": self.frame.cell,
            "size_m": self.frame.extent,
            "posts": [self.placing.shape[1], self.placing.shape[0]],
            "post_step": list(self.placing.step),
            "resampled": self.resampled,
            "bounds": list(self.bounds),
            "crs": self.frame.crs,
            "notes": list(self.notes),
        }

    def _checked(self, window: Window, factor: int) -> Window:
        if factor < 1 or factor != int(factor):
            raise SettingError(f"--factor must be a whole number of 1 or more, got {factor}")
        (h, w), size = self.frame.shape, (window.rows, window.columns)
        if window.row + window.rows > h or window.column + window.columns > w:
            raise SettingError(f"{window} leaves the raster of {h:,} x {w:,} cells")
        cells = math.ceil(size[0] / factor) * math.ceil(size[1] / factor)
        if cells > MAX_CELLS:
            enough = math.ceil(math.sqrt(size[0] * size[1] / MAX_CELLS))
            raise FileError(
                f"{self.path} has {size[1]:,} x {size[0]:,} cells, and {cells:,} are more than "
                f"{MAX_CELLS:,} at a time; read a part with --window WEST,SOUTH,EAST,NORTH, or "
                f"average them with --factor {max(enough, factor + 1)}"
            )
        return window

    def _heights(self, window: Window, factor: int, tell: Progress) -> Float:
        rows, columns = (math.ceil(n / factor) for n in (window.rows, window.columns))
        exact = self.posts.exact and factor == 1 and not self.resampled
        out = np.empty((rows, columns), np.float32 if exact else np.float64)
        strip = max(1, STRIP // max(1, window.columns * factor))
        with self.posts.open() as read:
            for first in range(0, rows, strip):
                last = min(first + strip, rows)
                row = window.row + first * factor
                count = min(last * factor, window.rows) - first * factor
                part = dataclasses.replace(window, row=row, rows=count)
                out[first:last] = _averaged(
                    self._cells(read, part), factor, (last - first, columns), plain=self.plain
                )
                tell(last / rows)
        return out

    def _cells(self, read: Read, window: Window) -> Float:
        """Heights of a window at full resolution."""
        at, (h, w) = self.lattice.at, self.placing.shape
        if at is None:
            return read(window.row, window.column, window.rows, window.columns)
        i = np.array([0, 0, window.rows, window.rows]) + window.row - 0.5
        j = np.array([0, window.columns, 0, window.columns]) + window.column - 0.5
        r, c = at[0] + at[1] * i + at[2] * j, at[3] + at[4] * i + at[5] * j
        bottom, top = _span(r, h)
        left, right = _span(c, w)
        z = np.ascontiguousarray(read(bottom, left, top - bottom, right - left), np.float64)
        out = np.empty((window.rows, window.columns))
        first = np.array([window.row, window.column, bottom, left])
        whole, steps = np.array(self.placing.shape), np.array(self.lattice.steps)
        k.resample(z, at, first, whole, steps, out)
        return out


@contextlib.contextmanager
def _answered(raster: Raster) -> Any:
    """A file that is too large for memory says so in a sentence."""
    try:
        yield
    except MemoryError:
        raise FileError(
            f"{raster.path} needs more memory than there is; read a part of it with --window "
            "WEST,SOUTH,EAST,NORTH, or a coarser one with --factor N"
        ) from None


def _span(positions: F64, count: int) -> tuple[int, int]:
    """The posts, of `count`, that places between the positions are interpolated from."""
    low = min(max(0, math.floor(positions.min()) - 1), count - 1)
    return low, max(low + 1, min(count, math.ceil(positions.max()) + 2))


def _averaged(cells: Float, factor: int, shape: tuple[int, int], *, plain: bool) -> Float:
    if factor == 1:
        return cells
    if plain:  # sums of 0 and NaN: a wall thinner than a block does not vanish
        rows, columns = (np.arange(0, n, factor) for n in cells.shape)
        return np.add.reduceat(np.add.reduceat(cells, rows, axis=0), columns, axis=1)
    if np.isinf(cells).any():
        raise InputError("some heights are infinite; mark missing heights as NaN or as nodata")
    out = np.empty(shape)
    k.block_means(np.ascontiguousarray(cells, np.float64), factor, out)
    return out


def _silent(_share: float) -> None:
    pass
