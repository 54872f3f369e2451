"""The cheapest way in any direction: marched, traced, drawn tight."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core import F64
from ..kernels import polyline, tracing
from ._costs import CostMap
from ._ends import Point, check_point, enclosed, judge_ends
from ._field import Field, march
from ._route import Route

ROUNDS = ((12.0, 1.0), (8.0, 0.4), (6.0, 0.15), (4.0, 0.05))
"""Longest piece and distance between places of each round of bending [cells]."""
PLACES = 8
"""Places on either side of a point that a round of bending tries."""
AHEAD = 64
"""Points that one piece may replace."""


def any_angle(costs: CostMap, start: Any, goal: Any) -> Route:
    """The cheapest way over open ground, in any direction and without the grid's staircase.

    Args:
        costs: Where going costs how much.
        start: Local point (x, y) [m].
        goal: Local point (x, y) [m].

    Returns:
        The route from exactly `start` to exactly `goal`, or why there is none. It touches no
        forbidden cell.

    Raises:
        InputError: An end is not two finite numbers.
    """
    start, goal = check_point(start, "start"), check_point(goal, "goal")
    refused = judge_ends(costs, start, goal)
    if refused is not None:
        return refused
    if start == goal:
        return Route(points=np.array([start]), cost=0.0, length=0.0)
    field = Field(costs=costs, flat=march(costs, np.array([goal]), second=False, goal=start))
    if not field.at(*start) < np.inf:
        return enclosed(costs, start, goal)
    path = _trace(field, start, goal) / costs.frame.cell
    path = drawn_tight(path, costs) * costs.frame.cell
    path[0], path[-1] = start, goal
    length = float(np.hypot(*np.diff(path, axis=0).T).sum())
    return Route(points=path, cost=costs.cost_of(path), length=length)


def _trace(field: Field, start: Point, goal: Point) -> F64:
    """From the exact start, over the middle of its cell, downhill to the exact goal [m]."""
    frame = field.costs.frame
    middle = frame.centre_of(*frame.cell_of(*start))
    return np.vstack([start, field.path_from(*middle), goal])


def drawn_tight(path: F64, costs: CostMap) -> F64:
    """A path (k, 2) [cells] that costs no more, bent and straightened where that pays."""
    path = _tighten(path, costs)
    for longest, step in ROUNDS:
        path = _split(path, longest)
        bent = np.empty_like(path)
        polyline_cost = tracing.bend(path, costs.cost, step, PLACES, bent)
        path = _tighten(bent if polyline_cost < np.inf else path, costs)
    return path


def _tighten(path: F64, costs: CostMap) -> F64:
    out = np.empty_like(path)
    return out[: tracing.tighten(path, costs.cost, AHEAD, out)].copy()


def _split(path: F64, longest: float) -> F64:
    """The same path with no piece longer than `longest`."""
    lengths = np.hypot(*np.diff(path, axis=0).T)
    parts = np.maximum(1, np.ceil(lengths / longest)).astype(np.int64)
    at = np.concatenate([[0.0], np.cumsum(parts)])
    every = np.arange(at[-1] + 1)
    return np.column_stack([np.interp(every, at, path[:, k]) for k in range(2)])
