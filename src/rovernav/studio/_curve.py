"""What is remembered of a training while it runs: its error curve and the paper's trace."""

from __future__ import annotations

from collections import deque
from typing import final

import numpy as np

from ..core import F64, value
from ..learn import Progress

LONGEST = 3_000
"""Points of a curve at most; beyond it every second one goes."""
TRACED = 2_000
"""Updates that the trace remembers."""


@value
class Point:
    """A point of the error curve.

    Attributes:
        epoch: Epochs done.
        worst: Largest error of any output of any pattern.
        loss: Half the squared error, summed over outputs, mean over patterns.
    """

    epoch: int
    worst: float
    loss: float


@value
class TraceLine:
    """Every weight after one update.

    Attributes:
        epoch: Which epoch, from 1.
        pattern: Which pattern, from 1.
        weights: All weights (P,).
    """

    epoch: int
    pattern: int
    weights: F64


@final
class Curve:
    """An error curve of bounded length, however long the training."""

    def __init__(self) -> None:
        self._points: list[Point] = []

    @property
    def points(self) -> tuple[Point, ...]:
        """The points, first and last always among them."""
        return tuple(self._points)

    def add(self, event: Progress) -> None:
        """One more point; a second one of the same epoch takes the place of the first."""
        point = Point(epoch=event.epoch, worst=event.worst, loss=event.loss)
        if self._points and self._points[-1].epoch == event.epoch:
            self._points[-1] = point
        else:
            self._points.append(point)
        if len(self._points) > LONGEST:
            self._points = [*self._points[:1], *self._points[1:-1:2], *self._points[-1:]]


@final
class TracePane:
    """The last lines of the trace."""

    def __init__(self) -> None:
        self._lines: deque[TraceLine] = deque(maxlen=TRACED)

    @property
    def lines(self) -> tuple[TraceLine, ...]:
        """The lines, oldest first."""
        return tuple(self._lines)

    def add(self, epoch: int, patterns: np.ndarray, weights: F64, size: int) -> None:
        """The updates of a slice, of a table of `size` patterns: see `learn.Recorder`."""
        for row in range(max(0, len(patterns) - TRACED), len(patterns)):
            self._lines.append(
                TraceLine(
                    epoch=epoch + 1 + row // size,
                    pattern=int(patterns[row]) + 1,
                    weights=weights[row].copy(),
                )
            )
