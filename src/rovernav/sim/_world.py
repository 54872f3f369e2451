"""The worlds that rovers drive in: obstacles, ground they cannot stand on, and an edge."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..core import F64, I64, U8, Frame, ShapeError, value
from ..kernels.drive import WorldArrays
from ._shapes import Shape, Shapes


@value
class Grid:
    """Ground on which a rover cannot stand, cell by cell.

    Attributes:
        frame: Where the cells lie; must have the shape of `blocked`.
        blocked: Nonzero where the rover cannot stand (h, w), uint8.
    """

    frame: Frame
    blocked: U8

    def _check(self) -> None:
        if self.blocked.shape != self.frame.shape or self.blocked.dtype != np.uint8:
            raise ShapeError(
                f"a grid needs uint8 cells of shape {self.frame.shape}, "
                f"got {self.blocked.dtype} {self.blocked.shape}"
            )


@value
class Worlds:
    """Many worlds in one batch: rover k lives in world ``of[k]``.

    Attributes:
        boxes: Axis-aligned rectangles of all worlds (m, 4): x0, y0, x1, y1 [m], closed.
        offsets: World i has the boxes offsets[i] to offsets[i + 1] (w + 1,).
        bounds: Edge of each world (w, 4): x0, y0, x1, y1 [m]; a rover beyond it has left the map.
        of: World of each rover (n,).
        grid: Ground that all worlds share, or None.
        shapes: Polygons and discs of each world, or None.
    """

    boxes: F64
    offsets: I64
    bounds: F64
    of: I64
    grid: Grid | None = None
    shapes: Shapes | None = None

    def _check(self) -> None:
        if self.boxes.ndim != 2 or self.boxes.shape[1] != 4:
            raise ShapeError(f"boxes must have shape (m, 4), got {self.boxes.shape}")
        if (self.boxes[:, :2] > self.boxes[:, 2:]).any() or not np.isfinite(self.boxes).all():
            raise ShapeError("a box needs finite x0 <= x1 and y0 <= y1")
        ends, worlds = self.offsets, len(self.offsets) - 1
        if worlds < 0 or ends[0] != 0 or ends[-1] != len(self.boxes) or (np.diff(ends) < 0).any():
            raise ShapeError(f"`offsets` must rise from 0 to the {len(self.boxes)} boxes")
        if self.bounds.shape != (worlds, 4):
            raise ShapeError(f"{worlds} worlds need bounds ({worlds}, 4), got {self.bounds.shape}")
        if not (self.bounds[:, :2] <= self.bounds[:, 2:]).all():
            raise ShapeError("an edge needs x0 <= x1 and y0 <= y1")
        if len(self.of) and (self.of.min() < 0 or self.of.max() >= worlds):
            raise ShapeError(f"`of` must name worlds 0 to {worlds - 1}")
        if self.shapes is not None and len(self.shapes.offsets) != worlds + 1:
            raise ShapeError(
                f"{worlds} worlds need the shapes of each, got {len(self.shapes.offsets) - 1}"
            )

    @classmethod
    def single(
        cls,
        boxes: Sequence[Sequence[float]] = (),
        *,
        bounds: Sequence[float] | None = None,
        grid: Grid | None = None,
        shapes: Sequence[Shape] = (),
        rovers: int = 1,
    ) -> Worlds:
        """One world for `rovers` rovers; its edge is the grid's where `bounds` is not given."""
        if bounds is None and grid is not None:
            bounds = (0.0, 0.0, *grid.frame.extent)
        edge = bounds if bounds is not None else (-np.inf, -np.inf, np.inf, np.inf)
        return cls(
            boxes=np.array(boxes, dtype=np.float64).reshape(-1, 4),
            offsets=np.array([0, len(boxes)], dtype=np.int64),
            bounds=np.array([edge], dtype=np.float64),
            of=np.zeros(rovers, dtype=np.int64),
            grid=grid,
            shapes=Shapes.packed([shapes]) if shapes else None,
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
        i = int(self.of[k])
        return Worlds(
            boxes=self.boxes[self.offsets[i] : self.offsets[i + 1]],
            offsets=np.array([0, self.offsets[i + 1] - self.offsets[i]], dtype=np.int64),
            bounds=self.bounds[i : i + 1],
            of=np.zeros(1, dtype=np.int64),
            grid=self.grid,
            shapes=None if self.shapes is None else Shapes.packed([self.shapes.of_world(i)]),
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
            blocked=_EMPTY if grid is None else np.ascontiguousarray(grid.blocked),
            cell=1.0 if grid is None else float(grid.frame.cell),
            **rounded,
        )


_EMPTY = np.zeros((0, 0), np.uint8)
_EMPTY.flags.writeable = False
