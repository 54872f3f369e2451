"""Where a file's own posts lie, what reads them, and the square true-metre grid laid over them."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Generator
from typing import Any, Protocol, TypeAlias

import numpy as np

from ..core import F64, FileError, Float, Frame, ShapeError, value
from ..core.frame import PLAIN
from ._metres import SQUARE_WITHIN, geographic, map_unit

LEAST, MOST = 1e-4, 1e6
"""Sides that a cell can have [m]; and one is at most a thousand times the other."""

Read: TypeAlias = Callable[[int, int, int, int], Float]
"""Heights [m] of the posts from a row and column on, so many rows and columns; row 0 south."""

FINEST = 2.0
"""The square grid has at most this many cells to the longer side of a post."""


class Posts(Protocol):
    """What holds the heights of a file; opened for each reading, so it can be kept and sent."""

    @property
    def exact(self) -> bool:
        """Whether float32 holds every height."""
        ...

    def open(self) -> contextlib.AbstractContextManager[Read]:
        """Open the file; what is yielded reads windows of it."""
        ...


@value
class ArrayPosts:
    """Heights in an array, which may lie on disk (numpy.memmap).

    Attributes:
        array: (rows, columns) of numbers, row 0 south.
        scale: Metres per unit of the array.
        offset: Height of its 0 [m].
        exact: Whether float32 holds every height.
    """

    array: Any
    scale: float = 1.0
    offset: float = 0.0
    exact: bool = True

    @contextlib.contextmanager
    def open(self) -> Generator[Read]:
        """What reads windows of the array."""

        def read(row: int, column: int, rows: int, columns: int) -> Float:
            part = self.array[row : row + rows, column : column + columns]
            if self.scale == 1.0 and self.offset == 0.0:
                return np.asarray(part)
            return np.asarray(part, np.float64) * self.scale + self.offset

        yield read


@value
class Placing:
    """Where the posts of a file lie on the map.

    Attributes:
        shape: Rows and columns of posts.
        corner: Map coordinates of the south-west corner of the south-west post's cell.
        step: Width and height of a post's cell in map units, both positive.
        crs: Coordinate system as WKT, or None.
    """

    shape: tuple[int, int]
    corner: tuple[float, float]
    step: tuple[float, float]
    crs: str | None = None

    def _check(self) -> None:
        numbers = (*self.step, *self.corner)
        if min(self.shape) < 1 or not (min(self.step) > 0 and np.isfinite(numbers).all()):
            raise ShapeError(f"posts need rows, columns and steps above 0, got {self}")

    @property
    def middle(self) -> tuple[float, float]:
        """Map coordinates of the middle."""
        (h, w), (x, y), (dx, dy) = self.shape, self.corner, self.step
        return x + 0.5 * w * dx, y + 0.5 * h * dy


@value
class Lattice:
    """A grid of square cells in true metres over the posts of a file.

    Attributes:
        frame: The grid.
        at: Post row and column of a cell, as `rovernav.kernels.resample` takes them; None where
            each cell is a post.
        steps: Places along y and x whose mean a cell is.
        note: What a reader should know about the map's metres; empty where they are true.
    """

    frame: Frame
    at: F64 | None
    steps: tuple[int, int]
    note: str


def lay(placing: Placing, about: tuple[float, float], source: str) -> Lattice:
    """The grid whose metres are true at the map point `about`.

    Cells are posts where those are square on the ground. Otherwise the grid is resampled: its cell
    is the shorter side of a post, but at least half the longer one.

    Raises:
        FileError: The coordinate system has no such place.
    """
    unit = map_unit(placing.crs, *about, source=source)
    dx, dy = placing.step
    u: F64 = np.linalg.cholesky(unit.metric).T.astype(
        np.float64
    )  # local = u @ (map - origin), x along the map's x
    across = abs(u[0, 1]) > SQUARE_WITHIN * u[0, 0]
    width, height = float(u[0, 0]) * dx, float(u[1, 1]) * dy
    if not (
        LEAST <= min(width, height) <= max(width, height) <= min(MOST, 1e3 * min(width, height))
    ):
        raise FileError(
            f"{source} has cells of {width:.4g} x {height:.4g} m, which no ground is measured by; "
            "check its geotransform and coordinate system"
        )
    note = unit.note or _note(placing, width / dx, height / dy, across)
    if not across and abs(width - height) <= SQUARE_WITHIN * min(width, height):
        cell = dx if (width, height) == (dx, dx) else math.sqrt(width * height)
        axes = PLAIN if cell == dx == dy else ((dx / cell, 0.0), (0.0, dy / cell))
        frame = Frame(cell=cell, shape=placing.shape, origin=placing.corner, crs=placing.crs,
                      axes=axes)  # fmt: skip
        return Lattice(frame=frame, at=None, steps=(1, 1), note=note)
    cell = max(min(width, height), max(width, height) / FINEST)
    return _resampled(placing, u, cell, note)


def _resampled(placing: Placing, u: F64, cell: float, note: str) -> Lattice:
    (h, w), (dx, dy) = placing.shape, placing.step
    if abs(u[0, 1]) <= SQUARE_WITHIN * u[0, 0]:
        u = np.diag(np.diag(u))
    corners = u @ np.array([[0.0, w * dx, 0.0, w * dx], [0.0, 0.0, h * dy, h * dy]])
    low, high = corners.min(axis=1), corners.max(axis=1)
    columns, rows = (max(1, int(n)) for n in np.floor((high - low) / cell + 1e-6))
    back = np.linalg.inv(u)  # map units per local metre
    origin = back @ low
    frame = Frame(
        cell=cell,
        shape=(rows, columns),
        origin=(placing.corner[0] + float(origin[0]), placing.corner[1] + float(origin[1])),
        crs=placing.crs,
        axes=((float(back[0, 0]), float(back[0, 1])), (float(back[1, 0]), float(back[1, 1]))),
    )
    first = (origin + back @ [0.5 * cell, 0.5 * cell]) / placing.step - 0.5
    c, r = (back * cell) / np.array(placing.step)[:, None]
    at = np.array([first[1], r[1], r[0], first[0], c[1], c[0]])
    steps = (max(1, round(math.hypot(r[1], c[1]))), max(1, round(math.hypot(r[0], c[0]))))
    return Lattice(frame=frame, at=at, steps=steps, note=note)


def _note(placing: Placing, east: float, north: float, across: bool) -> str:
    """In words: what a map unit is."""
    if geographic(placing.crs):
        return "in degrees: resampled to square cells in true metres"
    if (east, north) == (1.0, 1.0):
        return "" if placing.step[0] == placing.step[1] else "resampled to square cells"
    said = f"a map unit is {east:.4f} m east-west and {north:.4f} m north-south on the ground"
    return said + ("; its axes are not at right angles" if across else "")
