"""The cheapest way where going costs by direction: exact on a graph, then drawn tight."""

from __future__ import annotations

import dataclasses
import functools
from typing import Any

import numpy as np

from ..core import F64, SettingError
from ..kernels import easing
from ..kernels import going as k
from ._any_angle import any_angle, split_long
from ._ends import Point, check_point, judge_ends
from ._going import Going, against, room_for
from ._route import Route, Way, no_route

NEIGHBOURS = (8, 16, 32)
"""Cells that a move may lead to."""
USUAL = 16

REACH = 2
"""Cells around an end whose middles are joined to it by a straight piece."""

ROUNDS = ((2.0, 1.0, 4), (2.0, 0.5, 4), (3.0, 0.25, 4), (2.0, 0.12, 4))
"""Longest piece, distance between places, and places on either side of each round [cells]."""
AHEAD = 48
"""Points that one piece may replace."""
GAIN, MOST = 5e-4, 3
"""All rounds are repeated while they gain this share, up to so many times."""


@functools.cache
def stencil(neighbours: int) -> k.Stencil:
    """The moves to so many neighbours, with the length of each in every cell that it touches.

    Raises:
        SettingError: Not 8, 16 or 32.
    """
    if neighbours not in NEIGHBOURS:
        raise SettingError(f"neighbours must be 8, 16 or 32, got {neighbours!r}")
    far = NEIGHBOURS.index(neighbours) + 1
    moves = [
        (i, j) for i in range(-far, far + 1) for j in range(-far, far + 1) if np.gcd(i, j) == 1
    ]
    first, rows, columns, within = [0], [], [], []
    for i, j in moves:
        cells, lengths = np.empty((64, 2), np.int64), np.empty(64)
        middle = far + 0.5
        a, b = (middle, middle), (middle + j, middle + i)
        count = k.walk(a, b, (2 * far + 1, 2 * far + 1), cells, lengths)
        rows += list(cells[:count, 0] - far)
        columns += list(cells[:count, 1] - far)
        within += list(np.where(lengths[:count] > k.NEAR, lengths[:count], 0.0))
        first.append(len(rows))
    down, right = np.array(moves, np.int64).T
    return k.Stencil(
        down.copy(), right.copy(), np.array(first), np.array(rows), np.array(columns),
        np.array(within),
    )  # fmt: skip


class Search:
    """What it costs to get from one point to others, on the graph of moves between cells.

    Attributes:
        cost: From the start to each cell's middle (h, w) [unit per metre times cells], float64; a
            bound from above where a goal ended the search.
        came: Move by which each cell was reached (h, w), int8; -1 where none.
    """

    def __init__(self, ground: Going, start: Point, *, neighbours: int = USUAL) -> None:
        self._ground, self._start = ground, start
        self._packed, self._moves = ground.packed(), stencil(neighbours)
        self.cost = np.empty(ground.frame.shape)
        self.came = np.empty(ground.frame.shape, np.int8)

    def run(self, goal: Point | None = None) -> tuple[float, int]:
        """Search to a goal, or everywhere.

        Returns:
            Cost to the goal [unit] and the last cell (flat) on the way; inf and -1 without a way.
        """
        cell = self._ground.frame.cell
        last = self.spokes(goal, inward=True) if goal is not None else np.empty((0, 0))
        aim = (goal[0] / cell, goal[1] / cell) if goal is not None else (0.0, 0.0)
        least = self._ground.least * (1.0 - 1e-9) if goal is not None else 0.0
        room = max(4096, self.cost.size // 2)
        while True:
            self._begin()
            heap = k.Heap(np.empty(room), np.empty(room, np.int64))
            best, end = k.search(
                self._packed, self._moves, aim, least, last, self.cost, self.came, heap
            )
            if best != k.FULL:
                return best * cell, end
            room *= 3

    def to(self, goal: Point) -> float:
        """After a search everywhere: cost to any goal [unit]; inf where there is no way."""
        frame = self._ground.frame
        row, column = frame.cell_of(*goal)
        around = np.full((2 * REACH + 1, 2 * REACH + 1), np.inf)
        for i in range(-REACH, REACH + 1):
            for j in range(-REACH, REACH + 1):
                if 0 <= row + i < frame.shape[0] and 0 <= column + j < frame.shape[1]:
                    around[i + REACH, j + REACH] = self.cost[row + i, column + j]
        return float((around + self.spokes(goal, inward=True)).min()) * frame.cell

    def path(self, goal: Point, end: int) -> F64:
        """The way (k, 2) [m] from the start to a goal whose last cell is `end`."""
        room = 4096
        while True:
            out = np.empty(room, np.int64)
            count = k.walk_back(self.came, self._moves, end, out)
            if count != k.FULL:
                break
            room *= 4
        rows, columns = np.divmod(out[:count][::-1], self.cost.shape[1])
        middles = (np.column_stack([columns, rows]) + 0.5) * self._ground.frame.cell
        return np.vstack([self._start, middles, goal])

    def spokes(self, point: Point, *, inward: bool) -> F64:
        """Costs of straight pieces between a point and the middles of the cells around it.

        In units per metre times cells; `inward` goes from the middles to the point.
        """
        frame, room = self._ground.frame, room_for(self._ground.frame)
        row, column = frame.cell_of(*point)
        x, y = point[0] / frame.cell, point[1] / frame.cell
        out = np.empty((2 * REACH + 1, 2 * REACH + 1))
        for i in range(-REACH, REACH + 1):
            for j in range(-REACH, REACH + 1):
                middle = (column + j + 0.5, row + i + 0.5)
                a, b = (middle, (x, y)) if inward else ((x, y), middle)
                out[i + REACH, j + REACH] = k.piece(a, b, self._packed, *room)
        return out

    def _begin(self) -> None:
        self.cost.fill(np.inf)
        self.came.fill(-1)
        frame = self._ground.frame
        row, column = frame.cell_of(*self._start)
        spokes = self.spokes(self._start, inward=False)
        for (i, j), cost in np.ndenumerate(spokes):
            if cost < np.inf:
                self.cost[row + i - REACH, column + j - REACH] = cost


def directed(
    ground: Going, start: Any, goal: Any, *, neighbours: int = USUAL, tight: bool = True
) -> Route:
    """The cheapest way where going costs by direction.

    On the graph whose moves lead from the middle of a cell to those of 8, 16 or 32 around it, the
    way is exact; with `tight` it is then straightened and bent under the same cost function, which
    only makes it cheaper. A shortest way over open ground that keeps every limit is the shortest
    of all; it is tried first where distance counts.

    Args:
        ground: What going costs.
        start: Local point (x, y) [m].
        goal: Local point (x, y) [m].
        neighbours: 8, 16 or 32.
        tight: Whether to leave the graph.

    Returns:
        The route, or why there is none; `barriers` finds out more.

    Raises:
        InputError: An end is not two finite numbers.
        SettingError: Another number of neighbours.
    """
    stencil(neighbours)  # a number that there is none for is refused whatever is counted
    start, goal = check_point(start, "start"), check_point(goal, "goal")
    costs = ground.open_ground()
    refused = judge_ends(costs, start, goal)
    if refused is not None:
        end = {Way.START_FORBIDDEN: start, Way.GOAL_FORBIDDEN: goal}.get(refused.way)
        if end is None:
            return refused
        return dataclasses.replace(refused, reason=refused.reason + against(ground, end))
    if start == goal:
        return Route(points=np.array([start]), cost=0.0, length=0.0)
    if tight and (ground.objective == "distance" or _even(ground)):
        easy = any_angle(costs, start, goal)
        if not easy.found:
            return easy
        cost = ground.cost_of(easy.points)
        if cost < np.inf:
            return _route(easy.points, cost)
    search = Search(ground, start, neighbours=neighbours)
    _cost, end = search.run(goal)
    if end < 0:
        return _no_way(ground, search, start, goal)
    path = search.path(goal, end)
    path = eased(path, ground) if tight else path
    return _route(path, ground.cost_of(path))


def _even(ground: Going) -> bool:
    """Whether a metre costs the same wherever it is allowed."""
    return ground.table is None and ground.objective == "time"


def _route(points: F64, cost: float) -> Route:
    return Route(points=points, cost=cost, length=float(np.hypot(*np.diff(points, axis=0).T).sum()))


def _no_way(ground: Going, search: Search, start: Point, goal: Point) -> Route:
    """Told by what the search could reach."""
    frame = ground.frame
    reached = np.argwhere(search.cost < np.inf)
    if not reached.size:
        return no_route(
            Way.START_ENCLOSED,
            f"from the start ({start[0]:.6g}, {start[1]:.6g}) m every direction is forbidden to "
            f"{ground.rover.name}",
        )
    middles = (reached[:, ::-1] + 0.5) * frame.cell
    far = np.hypot(*(middles - goal).T)
    nearest = tuple(map(float, middles[far.argmin()]))
    area = len(reached) * frame.cell**2
    return no_route(
        Way.GOAL_ENCLOSED,
        f"from the start {ground.rover.name} reaches only {len(reached):,} cells ({area:,.6g} m²); "
        f"the nearest point to the goal that can be reached is ({nearest[0]:.6g}, "
        f"{nearest[1]:.6g}) m, {far.min():.3g} m from it",
        (nearest[0], nearest[1]),
    )


def eased(path: F64, ground: Going) -> F64:
    """A path (k, 2) [m] that costs no more, straightened and bent where that pays."""
    ends, cell, least = path[[0, -1]], ground.frame.cell, ground.least
    packed, room = ground.packed(), room_for(ground.frame)
    points = _tighten(path / cell, packed, room)
    best, before = points, ground.cost_of(points * cell)
    for _ in range(MOST):
        for longest, step, half in ROUNDS:
            points = split_long(points, longest)
            bent = np.empty_like(points)
            cost = easing.bend(points, packed, step, half, least, room, bent)
            points = _tighten(bent if cost < np.inf else points, packed, room)
        now = ground.cost_of(points * cell)
        best = points if now < before else best
        if not now < (1.0 - GAIN) * before:
            break
        before = now
    out = best * cell
    out[[0, -1]] = ends  # not a rounding off
    return out if ground.cost_of(out) <= ground.cost_of(path) else path


def _tighten(points: F64, packed: k.Going, room: Any) -> F64:
    out = np.empty_like(points)
    return out[: easing.tighten(points, packed, AHEAD, room, out)].copy()
