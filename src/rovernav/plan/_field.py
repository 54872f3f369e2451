"""What it costs to get to each place from somewhere, over open ground."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..core import F32, F64, InputError, read_only, value
from ..kernels import marching as k
from ..kernels import polyline, tracing
from ..kernels.buckets import queue
from ._costs import CostMap
from ._ends import Point, check_point, is_free

REACH = 8
"""Cells around a seed that begin with the cost of the straight way to them."""
HUGE = float(np.finfo(np.float32).max)
SLICES = 1 << 20
"""Slices of a queue at most: 8 MB."""


@value
class Field:
    """Cost of the cheapest way between each cell and the seeds, whichever way round.

    Attributes:
        costs: The map that it is of.
        flat: The values as the kernels have them: flat, with a ring of inf around the grid,
            float32 [unit per metre times cells].
    """

    costs: CostMap
    flat: F32

    @property
    def value(self) -> F32:
        """Cost (h, w) [unit]; inf where there is no way."""
        inner = self._grid()[k.RING : -k.RING, k.RING : -k.RING]
        return inner * np.float32(self.costs.frame.cell)

    def at(self, x: float, y: float) -> float:
        """Cost [unit] from the middle of the cell of a local point [m]; inf off the map."""
        if not self.costs.frame.contains(x, y):
            return np.inf
        row, column = self.costs.frame.cell_of(x, y)
        return float(self._grid()[row + k.RING, column + k.RING]) * self.costs.frame.cell

    def path_from(self, x: float, y: float) -> F64:
        """Downhill from a local point [m] to a seed: points (k, 2) [m], about two to a cell.

        Raises:
            InputError: The field has not reached that point.
        """
        if not self.at(x, y) < np.inf:
            raise InputError(f"there is no way from ({x:g}, {y:g}) m; check Field.at first")
        cell, room = self.costs.frame.cell, 1 << 14
        while True:
            out = np.empty((room, 2))
            count = tracing.descend(self.flat, self._stride, x / cell, y / cell, out)
            if 0 <= count <= room // 2 or room > 8 * self.flat.size:
                return out[:count] * cell
            room *= 4

    @property
    def _stride(self) -> int:
        return self.costs.frame.shape[1] + 2 * k.RING

    def _grid(self) -> F32:
        return self.flat.reshape(-1, self._stride)


def travel_time(costs: CostMap, seeds: Any, *, order: int = 2) -> Field:
    """Cost of the cheapest way from the seeds to every cell, over open ground in any direction.

    Fast marching: the solution of the eikonal equation. To first order it is too large by about
    half a cell times the cost for each doubling of the distance; to second order by far less.

    Args:
        costs: Where going costs how much.
        seeds: One local point (x, y) [m], or several (k, 2).
        order: 1 or 2.

    Raises:
        InputError: A seed is off the map or touches forbidden ground; another order.
    """
    if order not in (1, 2):
        raise InputError(f"the order must be 1 or 2, got {order!r}")
    points = np.atleast_2d(np.asarray(seeds, np.float64))
    if points.ndim != 2 or points.shape[1] != 2 or not len(points):
        raise InputError(f"seeds must be points (k, 2), got shape {np.shape(seeds)}")
    for point in points:
        x, y = check_point(point, "seed")
        if not is_free(costs, x, y):
            raise InputError(f"the seed ({x:g}, {y:g}) m is off the map or on forbidden ground")
    return Field(costs=costs, flat=march(costs, points, second=order == 2))


def cost_to_go(costs: CostMap, goal: Any, *, order: int = 1) -> Field:
    """Cost of the cheapest way from every cell to the goal: what a controller goes down.

    Where the cost does not depend on the direction, it is `travel_time` from the goal.
    """
    return travel_time(costs, goal, order=order)


class Limits(NamedTuple):
    """Where a march ends and what it leaves out.

    Attributes:
        goal: Local point [m]; go only as far as its cost is sure; or None.
        beyond: How much further to go, as a share of that cost.
        rest: What comes on top of the cost, flat, or None ...
        most: ... and the sum above which cells are left out [unit per metre times cells].
    """

    goal: Point | None = None
    beyond: float = 0.0
    rest: F32 | None = None
    most: float = np.inf


EVERYWHERE = Limits()


def march(
    costs: CostMap,
    seeds: F64,
    limits: Limits = EVERYWHERE,
    *,
    second: bool = False,
    grid: F32 | None = None,
) -> F32:
    """The flat values of a field.

    Args:
        costs: The map.
        seeds: Local points (k, 2) [m].
        limits: Where to end.
        second: Whether to second order.
        grid: The costs to go by, with their ring, if not all of the map's.
    """
    stride = costs.frame.shape[1] + 2 * k.RING
    f = read_only((ringed(costs) if grid is None else grid).ravel())
    room = max(4096, f.size // 16)
    slice_ = max(costs.least, 2.0 * costs.most / SLICES)
    end = flat_index(costs, limits.goal) if limits.goal is not None else -1
    how = k.March(stride, slice_, end, limits.beyond, second, min(limits.most, HUGE))
    rest = np.zeros(f.size if second else 0, np.float32) if limits.rest is None else limits.rest
    while True:
        u = np.full(f.size, np.inf, np.float32)
        first = _seed(costs, seeds, u, stride)
        if second:  # its differences undershoot near a seed, where the field is a cone
            rest[first] = np.inf
        ring = queue(int((1.5 + 2.0 * REACH) * costs.most / slice_) + 4, room)
        if k.march(f, u, first, ring, how, rest) != k.FULL:
            return u
        room *= 4


def flat_index(costs: CostMap, point: Point) -> int:
    """Where the cell of a local point [m] lies in a flat field."""
    row, column = costs.frame.cell_of(*point)
    return (row + k.RING) * (costs.frame.shape[1] + 2 * k.RING) + column + k.RING


def ringed(costs: CostMap) -> F32:
    """The costs of a map with a ring of inf around."""
    h, w = costs.frame.shape
    grid = np.full((h + 2 * k.RING, w + 2 * k.RING), np.inf, np.float32)
    grid[k.RING : -k.RING, k.RING : -k.RING] = costs.cost
    return grid


def _seed(costs: CostMap, seeds: F64, u: F32, stride: int) -> Any:
    """Write the cost of straight ways around the seeds to `u`; returns the cells that have one."""
    h, w = costs.frame.shape
    side = 2 * REACH + 1
    block, grid = np.empty((side, side)), u.reshape(h + 2 * k.RING, stride)
    found: list[Any] = []
    for x, y in seeds / costs.frame.cell:
        polyline.fan_out(x, y, REACH, costs.cost, block)
        row, column = min(int(y), h - 1), min(int(x), w - 1)
        for i, j in np.argwhere(block < np.inf):
            a, b = row + i - REACH + k.RING, column + j - REACH + k.RING
            grid[a, b] = min(grid[a, b], block[i, j])
            found.append(a * stride + b)
    return np.array(sorted(set(found)), np.int64)
