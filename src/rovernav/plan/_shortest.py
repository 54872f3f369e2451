"""The cheapest way from cell to cell, exactly."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core import F32, read_only
from ..kernels import grid_paths as k
from ..kernels.buckets import queue
from ..kernels.marching import RING
from ._costs import CostMap
from ._ends import Point, check_point, enclosed, judge_ends
from ._field import ringed
from ._route import Route

SLICES = 1 << 20
"""Slices of a queue at most: 8 MB."""
SHARE = 0.5
"""Width of a slice, of the smallest step: towards a goal sums of cost and bound grow slowly."""


def shortest(costs: CostMap, start: Any, goal: Any, *, corners: bool = False) -> Route:
    """The cheapest way over the middles of cells, each a neighbour of the last in 8 directions.

    It is exact: what Dijkstra's algorithm finds on the same graph. A step costs its length times
    the mean of the two cells' costs, which is the line integral from middle to middle.

    Args:
        costs: Where going costs how much.
        start: Local point (x, y) [m]; the route begins in the middle of its cell.
        goal: Local point (x, y) [m]; the route ends in the middle of its cell.
        corners: Whether a diagonal step may pass a forbidden cell at its corner. `CostMap.pieces`
            then calls such a step forbidden.

    Returns:
        The route, or why there is none.

    Raises:
        InputError: An end is not two finite numbers.
    """
    start, goal = check_point(start, "start"), check_point(goal, "goal")
    start, goal = (_middle(costs, end) for end in (start, goal))
    refused = judge_ends(costs, start, goal)
    if refused is not None:
        return refused
    grid = GridSearch(costs, corners=corners)
    cells = grid.path(costs.frame.cell_of(*start), costs.frame.cell_of(*goal))
    if cells is None:
        return enclosed(costs, start, goal, corners=corners)
    points = (cells[:, ::-1] + 0.5) * costs.frame.cell
    length = float(np.hypot(*np.diff(points, axis=0).T).sum())
    return Route(points=points, cost=grid.cost * costs.frame.cell, length=length)


def _middle(costs: CostMap, point: Point) -> Point:
    """Middle of the cell that holds a point on the map; other points as they are."""
    if not costs.frame.contains(*point):
        return point
    return costs.frame.centre_of(*costs.frame.cell_of(*point))


class GridSearch:
    """Exact searches over one map: one, or with `again` many, for which room is allocated once.

    `grid` holds the costs to go by, with their ring, if not all of the map's.

    Attributes:
        cost: What the last path costs [unit per metre times cells].
        taken: Cells that the last search took out of its queue.
    """

    def __init__(
        self,
        costs: CostMap,
        *,
        corners: bool = False,
        again: bool = False,
        grid: F32 | None = None,
    ) -> None:
        grid = ringed(costs) if grid is None else grid
        self._stride = grid.shape[1]
        self._grid = read_only(grid.ravel())
        self._distance = np.full(grid.size, np.inf)
        self._touched = np.zeros(grid.size + 1 if again else 1, np.int32)
        self._room = max(4096, grid.size // 16)
        self._least, self._most = costs.least, costs.most
        self._slice = max(SHARE * costs.least, 4.0 * costs.most / SLICES)
        self._queue = queue(int(3.0 * costs.most / self._slice) + 4, self._room)
        self._corners = corners
        self.cost = np.inf
        self.taken = 0

    def path(self, start: tuple[int, int], goal: tuple[int, int]) -> Any:
        """Rows and columns (k, 2) of the cells of a cheapest way; None where there is none."""
        how, last = self._search(start, goal)
        self.cost = float(self._distance[last])
        if not self.cost < np.inf:
            return None
        room = 4096
        while True:
            out = np.empty(room, np.int64)
            count = k.walk_back(self._grid, self._distance, last, how, out)
            if count != k.FULL:
                break
            room *= 4
        rows, columns = np.divmod(out[:count][::-1], self._stride)
        return np.column_stack([rows - RING, columns - RING])

    def distance(self, start: tuple[int, int], goal: tuple[int, int]) -> float:
        """What the cheapest way costs [unit per metre times cells]; inf where there is none."""
        _how, last = self._search(start, goal)
        self.cost = float(self._distance[last])
        return self.cost

    def _search(self, start: tuple[int, int], goal: tuple[int, int]) -> tuple[k.Search, int]:
        first, last = self._flat(start), self._flat(goal)
        how = k.how(self._stride, self._slice, last, self._least, corners=self._corners)
        while True:
            self._forget()
            self._distance[first] = 0.0
            seeds = np.array([first])
            self.taken = k.search(
                self._grid, self._distance, seeds, self._queue, how, self._touched
            )
            if self.taken != k.FULL:
                return how, last
            self._room *= 4
            self._queue = queue(self._queue.head.size, self._room)

    def _forget(self) -> None:
        """Make all cells unreached."""
        if self._touched.size > 1:
            self._distance[self._touched[1 : 1 + self._touched[0]]] = np.inf
        else:
            self._distance[:] = np.inf

    def _flat(self, cell: tuple[int, int]) -> int:
        return (cell[0] + RING) * self._stride + cell[1] + RING
