"""The worlds that rovers drive in: obstacles, ground they cannot stand on, and an edge."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..core import F32, F64, I64, U8, Frame, SettingError, ShapeError, value
from ..kernels.drive import WorldArrays
from ._shapes import Shape, Shapes


@value
class Grid:
    """Ground on which a rover cannot stand, cell by cell.

    Attributes:
        frame: Where the cells lie; must have the shape of `blocked`.
        blocked: Nonzero where the rover cannot stand, uint8: (h, w) for all worlds, or (w, h, w)
            with one for each.
    """

    frame: Frame
    blocked: U8

    def _check(self) -> None:
        if self.blocked.shape[-2:] != self.frame.shape or self.blocked.dtype != np.uint8:
            raise ShapeError(
                f"a grid needs uint8 cells of shape {self.frame.shape}, "
                f"got {self.blocked.dtype} {self.blocked.shape}"
            )

    def of_world(self, i: int) -> Grid:
        """The grid of world i alone."""
        return self if self.blocked.ndim == 2 else replace(self, blocked=self.blocked[i])


@value
class Ground:
    """Heights that rovers drive over.

    Attributes:
        frame: Where the posts lie, in the middle of cells.
        height: Above `offset`, NaN where nothing is known, float32 [m]: (h, w) for all worlds, or
            (w, h, w) with one for each.
        offset: [m].
    """

    frame: Frame
    height: F32
    offset: float = 0.0

    def _check(self) -> None:
        if self.height.shape[-2:] != self.frame.shape or self.height.dtype != np.float32:
            raise ShapeError(
                f"ground needs float32 heights of shape {self.frame.shape}, "
                f"got {self.height.dtype} {self.height.shape}"
            )

    def of_world(self, i: int) -> Ground:
        """The ground of world i alone."""
        return self if self.height.ndim == 2 else replace(self, height=self.height[i])

    def finer(self, times: int) -> Ground:
        """The same ground with cells `times` smaller, bilinear between posts, level at the edge.

        Raises:
            SettingError: Not a whole number of 1 to 100 times.
        """
        if times not in range(1, 101):
            raise SettingError(f"ground can be made 1 to 100 times finer, got {times!r}")
        h, w = self.frame.shape
        height = _finer(_finer(self.height, times, -1), times, -2)
        frame = replace(self.frame, cell=self.frame.cell / times, shape=(h * times, w * times))
        return Ground(frame=frame, height=height.astype(np.float32), offset=self.offset)


@value
class Rocks:
    """Rocks of all worlds: the upper halves of ellipsoids, standing on the ground or on nothing.

    Attributes:
        place: Middle x, y, radius and height of each (m, 4) [m].
        offsets: World i has the rocks offsets[i] to offsets[i + 1] (w + 1,).
    """

    place: F64
    offsets: I64

    def _check(self) -> None:
        if self.place.ndim != 2 or self.place.shape[1] != 4 or not np.isfinite(self.place).all():
            raise ShapeError(
                f"rocks need finite x, y, radius, height (m, 4), got {self.place.shape}"
            )
        if (self.place[:, 2:] <= 0).any():
            raise ShapeError("a rock needs a radius and a height above 0 m")
        ends = self.offsets
        if (
            not len(ends)
            or ends[0] != 0
            or ends[-1] != len(self.place)
            or (np.diff(ends) < 0).any()
        ):
            raise ShapeError(f"`offsets` of rocks must rise from 0 to {len(self.place)}")

    def of_world(self, i: int) -> Rocks:
        """The rocks of world i alone."""
        part = self.place[self.offsets[i] : self.offsets[i + 1]]
        return Rocks(place=part, offsets=np.array([0, len(part)], dtype=np.int64))


@value
class Worlds:
    """Many worlds in one batch: rover k lives in world ``of[k]``.

    Attributes:
        boxes: Axis-aligned rectangles of all worlds (m, 4): x0, y0, x1, y1 [m], closed.
        offsets: World i has the boxes offsets[i] to offsets[i + 1] (w + 1,).
        bounds: Edge of each world (w, 4): x0, y0, x1, y1 [m]; a rover beyond it has left the map.
        of: World of each rover (n,).
        grid: Ground on which rovers cannot stand, one for all worlds or one for each, or None.
        shapes: Polygons and discs of each world, or None.
        ground: Heights, one for all worlds or one for each; None where the worlds are flat.
        rocks: Rocks of each world, or None.
    """

    boxes: F64
    offsets: I64
    bounds: F64
    of: I64
    grid: Grid | None = None
    shapes: Shapes | None = None
    ground: Ground | None = None
    rocks: Rocks | None = None

    def _check(self) -> None:
        if self.boxes.ndim != 2 or self.boxes.shape[1] != 4:
            raise ShapeError(f"boxes must have shape (m, 4), got {self.boxes.shape}")
        if (self.boxes[:, :2] > self.boxes[:, 2:]).any() or not np.isfinite(self.boxes).all():
            raise ShapeError("a box needs finite x0 <= x1 and y0 <= y1")
        _need_rising(self.offsets, len(self.boxes), "boxes")
        worlds = len(self.offsets) - 1
        if self.bounds.shape != (worlds, 4):
            raise ShapeError(f"{worlds} worlds need bounds ({worlds}, 4), got {self.bounds.shape}")
        if not (self.bounds[:, :2] <= self.bounds[:, 2:]).all():
            raise ShapeError("an edge needs x0 <= x1 and y0 <= y1")
        if len(self.of) and (self.of.min() < 0 or self.of.max() >= worlds):
            raise ShapeError(f"`of` must name worlds 0 to {worlds - 1}")
        self._check_parts(worlds)

    def _check_parts(self, worlds: int) -> None:
        """Raise unless shapes, rocks, grid and ground are those of so many worlds."""
        for what, packed in (("shapes", self.shapes), ("rocks", self.rocks)):
            if packed is not None and len(packed.offsets) != worlds + 1:
                raise ShapeError(
                    f"{worlds} worlds need the {what} of each, got {len(packed.offsets) - 1}"
                )
        for what, layers in (
            ("grid", None if self.grid is None else self.grid.blocked),
            ("ground", None if self.ground is None else self.ground.height),
        ):
            if layers is not None and layers.ndim != 2 and layers.shape[0] != worlds:
                raise ShapeError(
                    f"{worlds} worlds need one {what} for all or one for each, got {layers.shape}"
                )

    @classmethod
    def single(  # noqa: PLR0913 - each is a kind of thing, by keyword
        cls,
        boxes: Sequence[Sequence[float]] = (),
        *,
        bounds: Sequence[float] | None = None,
        grid: Grid | None = None,
        shapes: Sequence[Shape] = (),
        ground: Ground | None = None,
        rocks: Sequence[Sequence[float]] = (),
        rovers: int = 1,
    ) -> Worlds:
        """One world for `rovers` rovers; its edge is its grid's where `bounds` is not given.

        Rocks are rows x, y, radius, height [m].
        """
        framed = grid or ground
        if bounds is None and framed is not None:
            bounds = (0.0, 0.0, *framed.frame.extent)
        edge = bounds if bounds is not None else (-np.inf, -np.inf, np.inf, np.inf)
        return cls(
            boxes=np.array(boxes, dtype=np.float64).reshape(-1, 4),
            offsets=np.array([0, len(boxes)], dtype=np.int64),
            bounds=np.array([edge], dtype=np.float64),
            of=np.zeros(rovers, dtype=np.int64),
            grid=grid,
            shapes=Shapes.packed([shapes]) if shapes else None,
            ground=ground,
            rocks=None
            if not len(rocks)
            else Rocks(
                place=np.array(rocks, dtype=np.float64).reshape(-1, 4),
                offsets=np.array([0, len(rocks)], dtype=np.int64),
            ),
        )

    @classmethod
    def one_box_each(cls, boxes: F64, *, bounds: Sequence[float]) -> Worlds:
        """As many worlds and rovers as boxes (n, 4), one box in each world."""
        n = len(boxes)
        return cls(
            boxes=boxes,
            offsets=np.arange(n + 1, dtype=np.int64),
            bounds=np.tile(np.array(bounds, dtype=np.float64), (n, 1)),
            of=np.arange(n, dtype=np.int64),
        )

    def row(self, k: int) -> Worlds:
        """The world of rover k alone."""
        i, grid, ground = int(self.of[k]), self.grid, self.ground
        return Worlds(
            boxes=self.boxes[self.offsets[i] : self.offsets[i + 1]],
            offsets=np.array([0, self.offsets[i + 1] - self.offsets[i]], dtype=np.int64),
            bounds=self.bounds[i : i + 1],
            of=np.zeros(1, dtype=np.int64),
            grid=grid and grid.of_world(i),
            shapes=None if self.shapes is None else Shapes.packed([self.shapes.of_world(i)]),
            ground=ground and ground.of_world(i),
            rocks=None if self.rocks is None else self.rocks.of_world(i),
        )

    def shapes_of(self, k: int = 0) -> list[Shape]:
        """Polygons and discs in the world of rover k."""
        return [] if self.shapes is None else self.shapes.of_world(int(self.of[k]))

    def arrays(self) -> WorldArrays:
        """The worlds as the kernels take them."""
        grid, shapes = self.grid, self.shapes
        rounded = (
            {}
            if shapes is None
            else {
                "corners": np.ascontiguousarray(shapes.corners),
                "ends": np.ascontiguousarray(shapes.ends),
                "radius": np.ascontiguousarray(shapes.radius),
                "shapes": np.ascontiguousarray(shapes.offsets),
            }
        )
        return WorldArrays(
            boxes=np.ascontiguousarray(self.boxes),
            offsets=np.ascontiguousarray(self.offsets),
            of=np.ascontiguousarray(self.of),
            blocked=_EMPTY if grid is None else _each(grid.blocked),
            cell=1.0 if grid is None else float(grid.frame.cell),
            **rounded,
        )


def _finer(height: Any, times: int, axis: int) -> Any:
    """Posts between posts along an axis; those beyond the outermost are as high as these."""
    count = height.shape[axis]
    at = np.clip((np.arange(count * times) + 0.5) / times - 0.5, 0.0, count - 1.0)
    low = np.minimum(at.astype(np.int64), max(count - 2, 0))
    share = at - low if axis == -1 else (at - low)[:, None]
    rise = np.take(height, np.minimum(low + 1, count - 1), axis) - np.take(height, low, axis)
    return np.take(height, low, axis) + share * rise


def _need_rising(offsets: I64, last: int, what: str) -> None:
    if not len(offsets) or offsets[0] != 0 or offsets[-1] != last or (np.diff(offsets) < 0).any():
        raise ShapeError(f"`offsets` must rise from 0 to the {last} {what}")


def _each(layers: Any) -> Any:
    """Layers (g, h, w) as kernels take them: one for each world, or the only one for all."""
    return np.ascontiguousarray(layers if layers.ndim == 3 else layers[None])


_EMPTY = np.zeros((0, 0, 0), np.uint8)
_EMPTY.flags.writeable = False
