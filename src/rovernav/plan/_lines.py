"""Lines over blocks along which a far way is sought, and what is learnt from those that were tried.

Blocks tell what share of them is free, not how long a way through them is. So each line that was
walked at full resolution corrects the costs of the blocks around it, and all costs by one number;
if another line is still shorter than what was found, it is tried next.
"""

from __future__ import annotations

from typing import Any, NamedTuple, cast

import numpy as np

from ..core import F64, Bool
from ..terrain import Window
from ._any_angle import any_angle
from ._ends import Point
from ._stretch import MARGIN, lengths
from ._survey import HARDER, Survey

SURER = 0.01
"""Blocks that join are kept to where that makes a line longer by less than this."""
SPAN = (0.1, 4.0)
"""Between what the cost of an obstructed block is fitted."""
RATIO = (0.5, 4.0)
"""A stretch corrects the costs around it by no more than this."""


class Walk(NamedTuple):
    """What was found along a line.

    Attributes:
        parts: The line's stretches, each (k, 2) [m].
        ways: The way along each, (k, 2) [m].
    """

    parts: list[F64]
    ways: list[F64]

    @property
    def length(self) -> float:
        """[m]."""
        return sum(float(lengths(way)[-1]) for way in self.ways)


class Line(NamedTuple):
    """A line over blocks.

    Attributes:
        points: (k, 2) [m], from stop to stop.
        cost: What it promises [m].
    """

    points: F64
    cost: float


class Guess:
    """What is known of the blocks between two stops.

    Attributes:
        found: The survey, without what has proved not to be passed.
        ends: The stops [m].
        middles: Of their blocks, on the map of costs [m].
        narrowed: How many lines could not be passed.
    """

    def __init__(self, found: Survey, ends: tuple[Point, Point]) -> None:
        self.found, self.ends, self.narrowed = found, ends, 0
        self.middles = found.middle(*ends[0]), found.middle(*ends[1])
        self._harder, self._known = HARDER, np.ones(found.share.shape, np.float32)
        self._joined = False

    def line(self) -> Line | None:
        """The line that promises the shortest way; None without one."""
        hoped = any_angle(self._costs(joined=False), *self.middles)
        if not hoped.found:
            return None
        sure = any_angle(self._costs(joined=True), *self.middles)
        self._joined = sure.found and sure.cost <= (1.0 + SURER) * hoped.cost
        chosen = sure if self._joined else hoped
        points = np.vstack([self.ends[0], chosen.points + self.found.corner, self.ends[1]])
        return Line(points, chosen.cost)

    def failed(self, window: Window) -> None:
        """There was no way within a window around the last line."""
        self.narrowed += 1
        self.found = self.found.narrowed(window, joined=self._joined)

    def learn(self, line: Line, walk: Walk) -> None:
        """Correct costs by the way that was found along a line."""
        plain = float(lengths(line.points)[-1])
        over = line.cost - plain
        if over > 1e-3 * plain:
            share = float(np.clip(1.0 + (walk.length - line.cost) / over, 0.2, 5.0))
            self._harder = float(np.clip(self._harder * share, *SPAN))
        costs = self._costs(joined=False)
        width, height = costs.frame.extent
        known = np.array(self._known)
        for part, way in zip(walk.parts, walk.ways, strict=True):
            on = np.clip(part - self.found.corner, 0.0, [width, height])
            promised = costs.cost_of(on)
            ratio = float(lengths(way)[-1]) / promised if promised > 0.0 else 1.0
            near = self._around(part)
            known[near] = self._known[near] * np.clip(ratio, *RATIO)
        self._known = known

    def _costs(self, *, joined: bool) -> Any:
        return self.found.costs(joined=joined, harder=self._harder, known=self._known)

    def _around(self, part: F64) -> Bool:
        """Blocks near a stretch of a line (h, w)."""
        from scipy import ndimage

        found = self.found
        count = 2 + int(2.0 * float(lengths(part)[-1]) / found.side)
        along = lengths(part)
        at = np.linspace(0.0, along[-1], count)
        x, y = (np.interp(at, along, part[:, axis]) for axis in range(2))
        h, w = found.share.shape
        rows = np.clip((y / found.side).astype(int), 0, h - 1)
        columns = np.clip((x / found.side).astype(int), 0, w - 1)
        reach = max(1, round(0.5 * MARGIN / found.block))
        low, left = max(0, rows.min() - reach), max(0, columns.min() - reach)
        box = np.zeros((rows.max() + reach + 1 - low, columns.max() + reach + 1 - left), bool)
        box[rows - low, columns - left] = True
        near = cast(Any, ndimage).binary_dilation(box, np.ones((3, 3)), reach)
        out = np.zeros((h, w), bool)
        out[low : low + box.shape[0], left : left + box.shape[1]] = near[: h - low, : w - left]
        return out
