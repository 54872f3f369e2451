"""What a rover needs to plan anew: what was known at first, and over it what it has sensed."""

from __future__ import annotations

import itertools
from typing import Any, NamedTuple

import numpy as np

from ..core import F64, I64, Frame
from ..mapping import LocalMap
from ..plan import CostMap

MARGIN = 15.0
"""What a map without ground reaches beyond start, goal and route [m]."""
NEAREST = 1.5
"""Cells around a rover and its goal that do not count as blocked: the map is coarse there."""
SHY, SHY_FAR, SHY_CELLS = 2.0, 0.8, 2.0
"""Costs beside forbidden ground are so many times higher on top; the more falls off over this way
[m], and at least so many cells: drivers do not follow a route to the centimetre."""
MOST = 600
"""Cells along a side of a map without ground, about."""


def blocked_cells(local: LocalMap, k: int, known: I64) -> I64:
    """The cells of the world (m, 2) that rover k knows to be blocked: row, column, sorted.

    What lies on its map now counts as the map has it; the rest as it was known.
    """
    s = local.cells.shape[1]
    low = local.centre[k] - s // 2
    spots = np.argwhere(local.cells[k] != 0)
    now = low + ((spots - low) & (s - 1))
    inside = ((known >= low) & (known < low + s)).all(axis=1)
    return np.unique(np.concatenate([known[~inside], now]), axis=0)


def met(local: LocalMap, k: int, path: F64, pose: F64) -> bool:
    """Whether a path runs through a blocked cell of rover k's map.

    Grazing one does not count: four points around each place must lie in blocked cells. Neither
    does what is nearer than 1.5 cells.
    """
    c, s = local.cell, local.cells.shape[1]
    places: list[Any] = []
    for a, b in itertools.pairwise(path):
        count = 2 + int(3.0 * np.hypot(*(b - a)) / c)
        places.append(np.linspace(a, b, count))
    at = np.concatenate(places)
    at = at[np.hypot(*(at - pose[:2]).T) > NEAREST * c]
    hit = np.ones(len(at), bool)
    for dx, dy in ((-0.3, -0.3), (-0.3, 0.3), (0.3, -0.3), (0.3, 0.3)):
        cells = np.floor(at[:, ::-1] / c + (dy, dx)).astype(np.int64)
        there = np.abs(cells - local.centre[k]).max(axis=1, initial=0) < s // 2
        i, j = (cells & (s - 1)).T
        hit &= there & (local.cells[k][i, j] != 0)
    return bool(hit.any())


class Sheet(NamedTuple):
    """Costs to plan over, and where their local (0, 0) lies in the rover's metres.

    Attributes:
        ground: Costs.
        at: x, y [m].
    """

    ground: CostMap
    at: F64

    @classmethod
    def of(cls, ground: CostMap | None, route: F64, pose: F64, local: LocalMap) -> Sheet:
        """The ground that was known at first, or level ground all round the way."""
        if ground is not None:
            return cls(ground, np.zeros(2))
        around = np.vstack([route, pose[None, :2]])
        low, high = around.min(axis=0) - MARGIN, around.max(axis=0) + MARGIN
        cell = max(local.cell, float((high - low).max()) / MOST)
        shape = tuple(int(n) + 1 for n in ((high - low) / cell)[::-1])
        return cls(CostMap.of(1.0, Frame(cell=cell, shape=(shape[0], shape[1]))), low)

    def inside(self, point: F64) -> F64:
        """A point in the metres of the costs."""
        return point - self.at

    def outside(self, points: F64) -> F64:
        """Points in the rover's metres."""
        return points + self.at

    def costs(self, known: I64, cell: float, free: Any) -> CostMap:
        """The costs with sensed cells (m, 2) of `cell` metres forbidden, but for those near `free`.

        Around the points `free` the ground is free even if it was not: the rover stands there, or
        is to go there.
        """
        frame, cost = self.ground.frame, self.ground.cost.copy()
        parts = int(np.ceil(cell / frame.cell))
        for a in range(parts):
            for b in range(parts):
                share = (np.array([a, b]) + 0.5) / parts
                spots = ((known + share) * cell - self.at[::-1]) / frame.cell
                i, j = np.floor(spots).astype(np.int64).T
                on = (i >= 0) & (j >= 0) & (i < frame.shape[0]) & (j < frame.shape[1])
                cost[i[on], j[on]] = np.inf
        usual = self.ground.most if np.isfinite(self.ground.most) else 1.0
        for point in free:
            x, y = self.inside(point) / frame.cell
            reach = NEAREST * max(1.0, cell / frame.cell)
            rows = slice(max(0, int(y - reach)), max(0, int(y + reach) + 1))
            columns = slice(max(0, int(x - reach)), max(0, int(x + reach) + 1))
            part = cost[rows, columns]
            part[np.isinf(part)] = usual
        return shy(CostMap(frame=frame, cost=cost, unit=self.ground.unit))


def shy(costs: CostMap) -> CostMap:
    """The same costs, but dearer beside forbidden ground: routes that leave a driver some room."""
    from scipy.ndimage import distance_transform_edt

    if not costs.forbidden.any():
        return costs
    cell = costs.frame.cell
    away = np.asarray(distance_transform_edt(~costs.forbidden)) * cell
    near = np.clip(1.0 - away / max(SHY_FAR, SHY_CELLS * cell), 0.0, 1.0)
    dearer = (costs.cost * (1.0 + SHY * near)).astype(np.float32)
    return CostMap(frame=costs.frame, cost=dearer, unit=costs.unit)
