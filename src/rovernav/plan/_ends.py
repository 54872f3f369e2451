"""Whether there is a way at all: the two ends judged, and the ground around them."""

from __future__ import annotations

import math
from typing import Any, cast

import numpy as np

from ..core import Frame, InputError
from ..kernels import polyline
from ._costs import CostMap
from ._route import Route, Way, no_route

Point = tuple[float, float]


def check_point(point: Any, what: str) -> Point:
    """`point` as two finite floats.

    Raises:
        InputError: It is something else.
    """
    try:
        x, y = (float(part) for part in point)
    except (TypeError, ValueError):
        x = y = math.nan
    if not (math.isfinite(x) and math.isfinite(y)):
        raise InputError(f"the {what} must be two numbers x, y in metres, got {point!r}")
    return x, y


def judge_ends(costs: CostMap, start: Point, goal: Point) -> Route | None:
    """Why no route can begin at `start` or end at `goal`; None where both are fine."""
    off = judge_inside(costs.frame, start, goal)
    if off is not None:
        return off
    for (x, y), what, way in (
        (start, "start", Way.START_FORBIDDEN),
        (goal, "goal", Way.GOAL_FORBIDDEN),
    ):
        if not is_free(costs, x, y):
            free = nearest_free(costs, x, y)
            near = (
                "; no cell of this map is free"
                if free is None
                else f"; the nearest free ground is at {_at(*free)}, "
                f"{math.dist(free, (x, y)):.3g} m away"
            )
            nearest = free if what == "goal" else None
            return no_route(way, f"the {what} {_at(x, y)} touches forbidden ground{near}", nearest)
    return None


def judge_inside(frame: Frame, start: Point, goal: Point) -> Route | None:
    """That an end lies beyond the map; None where both are on it."""
    width, height = frame.extent
    for (x, y), what, way in (
        (start, "start", Way.START_OUTSIDE),
        (goal, "goal", Way.GOAL_OUTSIDE),
    ):
        if not frame.contains(x, y):
            return no_route(
                way,
                f"the {what} {_at(x, y)} lies beyond the map, which is {width:g} m wide and "
                f"{height:g} m high{_on_the_map(frame, (x, y))}",
            )
    return None


def is_free(costs: CostMap, x: float, y: float) -> bool:
    """Whether the local point (x, y) [m] lies on the map and touches no forbidden cell."""
    x, y = x / costs.frame.cell, y / costs.frame.cell
    return bool(polyline.piece(x, y, x, y, costs.cost) < np.inf)


def nearest_free(costs: CostMap, x: float, y: float) -> Point | None:
    """Middle of the free cell nearest to the local point (x, y) [m]; None where none is free."""
    return _nearest(costs, ~costs.forbidden, x, y)


def enclosed(costs: CostMap, start: Point, goal: Point, *, corners: bool = False) -> Route:
    """The answer where a search has found that the two ends lie in two pieces of free ground.

    Args:
        costs: The map.
        start: Local point [m] in a free cell.
        goal: Local point [m] in a free cell.
        corners: Whether cells that touch at a corner belong together.
    """
    from scipy import ndimage

    shape = np.ones((3, 3)) if corners else None
    regions, _count = cast(Any, ndimage).label(~costs.forbidden, structure=shape)
    from_start = regions[costs.frame.cell_of(*start)]
    from_goal = regions[costs.frame.cell_of(*goal)]
    cells = np.bincount(regions.ravel(), minlength=2)
    around_start, around_goal = int(cells[from_start]), int(cells[from_goal])
    nearest = _nearest(costs, regions == from_start, *goal)
    assert nearest is not None
    small = min(around_start, around_goal)
    area = small * costs.frame.cell**2
    what, way = ("goal", Way.GOAL_ENCLOSED)
    if around_start < around_goal:
        what, way = ("start", Way.START_ENCLOSED)
    x, y = start if what == "start" else goal
    return no_route(
        way,
        f"forbidden ground encloses the {what} {_at(x, y)} in a region of {small:,} "
        f"{'cell' if small == 1 else 'cells'} ({area:,.6g} m²); the nearest point to the goal that "
        f"can be reached is {_at(*nearest)}, {math.dist(nearest, goal):.3g} m from it",
        nearest,
    )


def _nearest(costs: CostMap, wanted: Any, x: float, y: float) -> Point | None:
    """Middle of the wanted cell (h, w) whose middle is nearest to (x, y) [m]."""
    best, found = math.inf, None
    columns = (np.arange(wanted.shape[1]) + 0.5) * costs.frame.cell
    for row in np.flatnonzero(wanted.any(axis=1)):
        dy = (row + 0.5) * costs.frame.cell - y
        if abs(dy) < best:
            far = np.where(wanted[row], np.hypot(columns - x, dy), np.inf)
            if far.min() < best:
                best, found = float(far.min()), costs.frame.centre_of(int(row), int(far.argmin()))
    return found


def _at(x: float, y: float) -> str:
    return f"({x:.6g}, {y:.6g}) m"


def _on_the_map(frame: Frame, point: Point) -> str:
    """The point and the map in the map's own coordinates, where those are others."""
    if frame.to_map(0.0, 0.0) == (0.0, 0.0) and frame.to_map(1.0, 1.0) == (1.0, 1.0):
        return ""
    width, height = frame.extent
    corners = [frame.to_map(x, y) for x in (0.0, width) for y in (0.0, height)]
    (left, *_, right), (bottom, *_, top) = (sorted(side) for side in zip(*corners, strict=True))
    x, y = (round(at, 6) + 0.0 for at in frame.to_map(*point))
    return (
        f"; in its own coordinates that is {x:.9g}, {y:.9g}, and it spans x from {left:.9g} to "
        f"{right:.9g} and y from {bottom:.9g} to {top:.9g}"
    )
