"""Obstacles of any outline: polygons and discs, grown by a radius where a rover has a size."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence

import numpy as np

from ..core import F64, I64, ShapeError, value


@value
class Shape:
    """Everything within `radius` of a closed polygon: one corner makes it a disc.

    Attributes:
        corners: Corners (m, 2) [m], in order, the last joined to the first; they may cross, then
            the inside is by the even-odd rule.
        radius: [m].
    """

    corners: F64
    radius: float = 0.0

    def _check(self) -> None:
        if self.corners.ndim != 2 or self.corners.shape[1] != 2 or not len(self.corners):
            raise ShapeError(f"a shape needs corners (m, 2), got {self.corners.shape}")
        if not np.isfinite(self.corners).all():
            raise ShapeError("a corner of a shape is not a finite number")
        if not 0.0 <= self.radius < np.inf:
            raise ShapeError(f"the radius of a shape must be 0 m or more, got {self.radius!r}")

    @classmethod
    def disc(cls, x: float, y: float, radius: float) -> Shape:
        """Everything within `radius` of (x, y) [m]."""
        return cls(corners=np.array([[x, y]], dtype=np.float64), radius=radius)

    @classmethod
    def polygon(cls, corners: Sequence[Sequence[float]]) -> Shape:
        """The polygon with these corners x, y [m]."""
        return cls(corners=np.array(corners, dtype=np.float64).reshape(-1, 2))

    @classmethod
    def box(cls, x0: float, y0: float, x1: float, y1: float) -> Shape:
        """The rectangle from (x0, y0) to (x1, y1) [m]."""
        return cls.polygon([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])

    def grown(self, by: float) -> Shape:
        """Everything within `by` [m] of it: where the middle of a rover of that radius must not be.

        Exact: a disc rolled around a convex or hollow outline leaves round corners.
        """
        return Shape(corners=self.corners, radius=self.radius + by)

    def outline(self, *, step: float = np.pi / 24) -> list[F64]:
        """Closed outlines (k, 2) [m] to draw it by, round corners in steps of `step` [rad].

        The polygon itself and, with a radius, a stadium around each side: drawn filled and without
        edges they cover just the shape.
        """
        m = len(self.corners)
        if self.radius == 0.0:
            return [self.corners]
        sides = [(k, (k + 1) % m) for k in range(m if m > 2 else m - 1 or 1)]
        around = [_stadium(self.corners[i], self.corners[j], self.radius, step) for i, j in sides]
        return around + ([self.corners] if m > 2 else [])


@value
class Shapes:
    """The shapes of all worlds of a batch, packed.

    Attributes:
        corners: Corners of all shapes (p, 2) [m].
        ends: Shape i has the corners ends[i] to ends[i + 1] (m + 1,).
        radius: Radius of each shape (m,) [m].
        offsets: World i has the shapes offsets[i] to offsets[i + 1] (w + 1,).
    """

    corners: F64
    ends: I64
    radius: F64
    offsets: I64

    def _check(self) -> None:
        for name, array, last in (
            ("ends", self.ends, len(self.corners)),
            ("offsets", self.offsets, len(self.radius)),
        ):
            if not len(array) or array[0] != 0 or array[-1] != last or (np.diff(array) < 0).any():
                raise ShapeError(f"`{name}` of shapes must rise from 0 to {last}")
        if len(self.ends) != len(self.radius) + 1 or (np.diff(self.ends) < 1).any():
            raise ShapeError("every shape needs a radius and at least one corner")

    @classmethod
    def packed(cls, worlds: Iterable[Sequence[Shape]]) -> Shapes:
        """The shapes of each world, as kernels take them."""
        each = [list(shapes) for shapes in worlds]
        every = [shape for shapes in each for shape in shapes]
        corners = [shape.corners for shape in every]
        return cls(
            corners=np.concatenate([np.empty((0, 2)), *corners]),
            ends=_running(map(len, corners)),
            radius=np.array([shape.radius for shape in every], dtype=np.float64),
            offsets=_running(map(len, each)),
        )

    def of_world(self, i: int) -> list[Shape]:
        """The shapes of world i, one by one."""
        return [
            Shape(
                corners=self.corners[self.ends[k] : self.ends[k + 1]],
                radius=float(self.radius[k]),
            )
            for k in range(int(self.offsets[i]), int(self.offsets[i + 1]))
        ]


def _running(counts: Iterable[int]) -> I64:
    return np.array([0, *itertools.accumulate(counts)], dtype=np.int64)


def _stadium(p: F64, q: F64, radius: float, step: float) -> F64:
    """All within `radius` of the line from p to q, as a polygon (k, 2)."""
    half = np.arange(0.0, np.pi + step / 2, step)
    dx, dy = q - p
    right = np.arctan2(dy, dx) - np.pi / 2
    ends = [
        at + radius * np.stack([np.cos(turn + half), np.sin(turn + half)], axis=1)
        for at, turn in ((q, right), (p, right + np.pi))
    ]
    return np.concatenate(ends)
