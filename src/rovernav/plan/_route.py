"""A route, or why there is none."""

from __future__ import annotations

import enum

import numpy as np

from ..core import F64, ShapeError, value


class Way(enum.StrEnum):
    """Whether there is a way, and if not, what stands against it."""

    FOUND = "found"
    """There is a way."""
    START_OUTSIDE = "start_outside"
    """The start lies beyond the map."""
    GOAL_OUTSIDE = "goal_outside"
    """The goal lies beyond the map."""
    START_FORBIDDEN = "start_forbidden"
    """The start touches a forbidden cell."""
    GOAL_FORBIDDEN = "goal_forbidden"
    """The goal touches a forbidden cell."""
    START_ENCLOSED = "start_enclosed"
    """Forbidden ground or the map's edge encloses the start; the goal lies outside of it."""
    GOAL_ENCLOSED = "goal_enclosed"
    """Forbidden ground or the map's edge encloses the goal; the start lies outside of it."""


@value
class Route:
    """The answer to a question for a way.

    Attributes:
        points: The way (k, 2), local metres; empty where there is none, one point where the start
            is the goal.
        cost: What it costs, by the line integral of the cost along it [unit]; inf without a way.
        length: [m]; inf without a way.
        way: Whether there is a way, and if not, what stands against it.
        reason: A sentence that says why there is no way; empty where there is one.
        nearest: Local point (x, y) [m] that is nearest to the goal of all that can be reached; None
            where nothing can be reached, and where there is a way.
    """

    points: F64
    cost: float
    length: float
    way: Way = Way.FOUND
    reason: str = ""
    nearest: tuple[float, float] | None = None

    def _check(self) -> None:
        if self.points.ndim != 2 or self.points.shape[1] != 2:
            raise ShapeError(f"a route's points must have shape (k, 2), got {self.points.shape}")

    @property
    def found(self) -> bool:
        """Whether there is a way."""
        return self.way is Way.FOUND

    @property
    def status(self) -> str:
        """``found`` or ``unreachable``, as files and reports write it."""
        return "found" if self.found else "unreachable"


def no_route(way: Way, reason: str, nearest: tuple[float, float] | None = None) -> Route:
    """The answer where there is no way."""
    return Route(
        points=np.empty((0, 2)),
        cost=np.inf,
        length=np.inf,
        way=way,
        reason=reason,
        nearest=nearest,
    )
