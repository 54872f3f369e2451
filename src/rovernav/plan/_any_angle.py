"""The cheapest way in any direction: marched, traced, drawn tight."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core import F32, F64, InputError
from ..kernels import tracing
from ._corridor import coarsened, corridor, spread
from ._costs import CostMap
from ._ends import Point, check_point, enclosed, judge_ends
from ._field import Field, Limits, march
from ._route import Route
from ._shortest import GridSearch

SLACK = 0.002
"""Usual width of the corridor, as a share of the cost."""
SMALL = 192
"""Maps with a side below this many cells are looked at whole."""
ROUGH = 0.7
"""Where the way found costs less than this share of what blocks of cells made of it, the costs
change so fast from cell to cell that the front of a march misses cheap cells."""
HOPEFUL = 1.025
"""A way over the grid is drawn tight if it costs at most this many times the smooth one."""

ROUNDS = (
    *((2.0, 1.0, 6), (2.0, 0.5, 4), (2.0, 0.25, 4)),
    *((3.0, 0.5, 4), (2.0, 0.12, 4), (12.0, 0.2, 4), (0.7, 0.1, 4), (24.0, 0.03, 4)),
)
"""Longest piece, distance between places, and places on either side of each round [cells]."""
AGAIN, GAIN, MOST = 5, 5e-4, 5
"""The last five rounds are repeated while they gain this share, up to so many times."""
AHEAD = 64
"""Points that one piece may replace."""


def any_angle(costs: CostMap, start: Any, goal: Any, *, slack: float = SLACK) -> Route:
    """The cheapest way over open ground, in any direction and without the grid's staircase.

    Large maps are first judged by blocks of cells; then only the corridor is looked at in which
    ways run that are by this estimate at most `slack` dearer than the cheapest. Where the way found
    is dearer than that estimate, the whole map is looked at: so the answer is as if it always were,
    but for ways that the estimate makes dearer than they are by more than `slack`.

    Args:
        costs: Where going costs how much.
        start: Local point (x, y) [m].
        goal: Local point (x, y) [m].
        slack: Share, 0.002 for 0.2 %; inf looks at the whole map at once.

    Returns:
        The route from exactly `start` to exactly `goal`, or why there is none. It touches no
        forbidden cell.

    Raises:
        InputError: An end is not two finite numbers, or a negative slack.
    """
    start, goal = check_point(start, "start"), check_point(goal, "goal")
    if not slack >= 0.0:
        raise InputError(f"the slack must be a share of 0 or more, like 0.005, got {slack!r}")
    refused = judge_ends(costs, start, goal)
    if refused is not None:
        return refused
    if start == goal:
        return Route(points=np.array([start]), cost=0.0, length=0.0)
    if slack == np.inf or min(costs.frame.shape) < SMALL:
        path = _cheaper(costs, start, goal, None, np.inf)
    else:
        found = corridor(coarsened(costs), start, goal, slack)
        if found is None:
            return enclosed(costs, start, goal)
        chosen, estimate = found
        path = _cheaper(costs, start, goal, spread(costs, chosen), estimate)
        if path is None or costs.cost_of(path) > (1.0 + slack) * estimate:
            path = _cheaper(costs, start, goal, None, estimate)
    if path is None:
        return enclosed(costs, start, goal)
    length = float(np.hypot(*np.diff(path, axis=0).T).sum())
    return Route(points=path, cost=costs.cost_of(path), length=length)


def _cheaper(
    costs: CostMap, start: Point, goal: Point, grid: F32 | None, estimate: float
) -> F64 | None:
    """The cheapest path [m] over the cells of a ringed grid of costs, or over all cells.

    The march gives a path; where its cost shows a rough map, so does an exact search from cell to
    cell, and the cheaper one counts.
    """
    traced = _traced(costs, start, goal, grid)
    if traced is None:
        return None
    path = drawn_tight(traced, costs)
    cost = costs.cost_of(path)
    if cost < ROUGH * estimate:
        search = GridSearch(costs, grid=grid)
        cells = search.path(costs.frame.cell_of(*start), costs.frame.cell_of(*goal))
        if cells is not None and search.cost * costs.frame.cell < HOPEFUL * cost:
            middles = (cells[:, ::-1] + 0.5) * costs.frame.cell
            other = drawn_tight(np.vstack([start, middles, goal]), costs)
            path = other if costs.cost_of(other) < cost else path
    return path


def _traced(costs: CostMap, start: Point, goal: Point, grid: F32 | None) -> F64 | None:
    """From the exact start, over the middle of its cell, downhill to the exact goal [m]."""
    field = Field(costs=costs, flat=march(costs, np.array([goal]), Limits(start), grid=grid))
    if not field.at(*start) < np.inf:
        return None
    middle = costs.frame.centre_of(*costs.frame.cell_of(*start))
    return np.vstack([start, field.path_from(*middle), goal])


def drawn_tight(path: F64, costs: CostMap) -> F64:
    """A path (k, 2) [m] that costs no more, bent and straightened where that pays."""
    ends = path[[0, -1]]
    path, before = _tighten(path / costs.frame.cell, costs), np.inf
    for number in range(MOST + 1):
        for longest, step, half in ROUNDS if number == 0 else ROUNDS[-AGAIN:]:
            path = split_long(path, longest)
            bent = np.empty_like(path)
            cost = tracing.bend(path, costs.cost, step, half, costs.least, bent)
            path = _tighten(bent if cost < np.inf else path, costs)
        now = costs.cost_of(path * costs.frame.cell)
        if now > (1.0 - GAIN) * before:
            break
        before = now
    path = path * costs.frame.cell
    path[[0, -1]] = ends  # not a rounding off
    return path


def _tighten(path: F64, costs: CostMap) -> F64:
    """The path without points that cost something; fewer points let more be left out."""
    while True:
        out = np.empty_like(path)
        count = tracing.tighten(path, costs.cost, AHEAD, out)
        if count == len(path):
            return path
        path = out[:count].copy()


def split_long(path: F64, longest: float) -> F64:
    """The same path with no piece longer than `longest`."""
    lengths = np.hypot(*np.diff(path, axis=0).T)
    parts = np.maximum(1, np.ceil(lengths / longest)).astype(np.int64)
    at = np.concatenate([[0.0], np.cumsum(parts)])
    every = np.arange(at[-1] + 1)
    return np.column_stack([np.interp(every, at, path[:, k]) for k in range(2)])
