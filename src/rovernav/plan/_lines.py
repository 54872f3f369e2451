"""Lines over blocks along which a far way is sought, and what is learnt from those that were tried.

Blocks tell what share of them is free, not how long a way through them is. So each line that was
walked at full resolution corrects the costs of the blocks around it, and all costs by one number;
if another line is still shorter than what was found, it is tried next.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple, cast

import numpy as np

from ..core import F64, Bool
from ..terrain import Window
from ._any_angle import any_angle
from ._ends import Point
from ._lookout import AROUND, Lookout, Progress, in_turn, silent
from ._stretch import MARGIN, lengths
from ._survey import HARDER

SURER = 0.01
"""Blocks that join are kept to where that makes a line longer by less than this."""
SPAN = (0.1, 4.0)
"""Between what the cost of an obstructed block is fitted."""
RATIO = (0.5, 4.0)
"""A stretch corrects the costs around it by no more than this."""
FIRST, WIDER = 0.004, 4.0
"""How much longer than straight ways may be that are looked at first; and how many times more where
there is none."""
WORTH = 0.01
"""A way counts as better if it is shorter by more than this share."""


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
        reach: Ways up to so many times the straight line were looked at.
    """

    def __init__(self, around: Lookout, ends: tuple[Point, Point], tell: Progress = silent) -> None:
        self._out, self._tell, self._shut = around, tell, list[tuple[Window, bool]]()
        self.ends, self.reach = ends, 0.0
        self._joined = False
        self._harder = HARDER
        self._widened(1.0 + FIRST)
        self._learnt = np.ones(self.found.share.shape, np.float32)
        self.middles = self.found.middle(*ends[0]), self.found.middle(*ends[1])

    @property
    def narrowed(self) -> int:
        """How many lines could not be passed."""
        return len(self._shut)

    @property
    def straight(self) -> float:
        """From stop to stop [m]."""
        return math.dist(*self.ends)

    def line(self) -> Line | None:
        """The line that promises the shortest way; None without one over all of the raster."""
        while True:
            line = self._line()
            if line is None:
                if self._out.whole or not self._hopeful():
                    return None
                more = max(self.reach - 1.0, AROUND * self.found.whole.cell / self.straight)
                self._widened(1.0 + WIDER * more)
            elif not self.widen(float(lengths(line.points)[-1])):
                return line

    def widen(self, length: float) -> bool:
        """Look farther if a way of that length [m] could be undercut by one not looked at."""
        needed = (1.0 - WORTH) * length / self.straight
        if self._out.whole or needed <= self.reach:
            return False
        self._widened(needed)
        return True

    def failed(self, window: Window) -> None:
        """There was no way within a window around the last line."""
        self._shut.append((window, self._joined))
        self.found = self.found.narrowed(window, joined=self._joined)

    def _widened(self, reach: float) -> None:
        self.reach = reach
        self._out.widen(self.ends, reach, self._tell)
        self.found = self._out.found
        for window, joined in self._shut:
            self.found = self.found.narrowed(window, joined=joined)

    def _hopeful(self) -> bool:
        """Whether there may be a way over what was not looked at."""
        return any_angle(self.found.costs(joined=False, hopeful=True), *self.middles).found

    def _line(self) -> Line | None:
        """The best over what was looked at."""
        hoped, sure = in_turn(
            lambda joined: any_angle(self._costs(joined=joined), *self.middles), (False, True)
        )
        if not hoped.found:
            return None
        self._joined = sure.found and sure.cost <= (1.0 + SURER) * hoped.cost
        chosen = sure if self._joined else hoped
        points = np.vstack([self.ends[0], chosen.points + self.found.corner, self.ends[1]])
        return Line(points, chosen.cost)

    def learn(self, line: Line, walk: Walk) -> None:
        """Correct costs by the way that was found along a line."""
        plain = float(lengths(line.points)[-1])
        over = line.cost - plain
        if over > 1e-3 * plain:
            share = float(np.clip(1.0 + (walk.length - line.cost) / over, 0.2, 5.0))
            self._harder = float(np.clip(self._harder * share, *SPAN))
        costs = self._costs(joined=False)
        width, height = costs.frame.extent
        learnt = np.array(self._learnt)
        for part, way in zip(walk.parts, walk.ways, strict=True):
            on = np.clip(part - self.found.corner, 0.0, [width, height])
            promised = costs.cost_of(on)
            ratio = float(lengths(way)[-1]) / promised if promised > 0.0 else 1.0
            near = self._around(part)
            learnt[near] = self._learnt[near] * np.clip(ratio, *RATIO)
        self._learnt = learnt

    def _costs(self, *, joined: bool) -> Any:
        return self.found.costs(joined=joined, harder=self._harder, learnt=self._learnt)

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
