"""Coarse to fine: where a cheapest way may run, judged on a coarser map."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core import F32, U8
from ..kernels import marching as k
from ..kernels import pooling
from ._costs import CostMap
from ._ends import Point
from ._field import Field, Limits, flat_index, march

BLOCK = 4
"""Cells to a side of a block."""
UNSURE = 0.05
"""What two fields of a coarse map may differ by from each other, as a share."""


def coarsened(costs: CostMap, block: int = BLOCK) -> CostMap:
    """A map of blocks of cells: the mean cost of those that are free, forbidden where none is.

    What is enclosed on the coarse map is enclosed on the fine one; walls thinner than a block may
    vanish.
    """
    h, w = costs.frame.shape
    shape = (-(-h // block), -(-w // block))
    cost = np.empty(shape, np.float32)
    pooling.pool(costs.cost, block, cost)
    return CostMap(frame=costs.frame.part(0, 0, shape, block), cost=cost, unit=costs.unit)


def corridor(costs: CostMap, start: Point, goal: Point, slack: float) -> tuple[U8, float] | None:
    """Cells over which a way runs that is at most `slack` dearer than the cheapest, and its cost.

    Args:
        costs: The map, a coarse one as a rule.
        start: Local point [m].
        goal: Local point [m].
        slack: Share, 0.01 for 1 %.

    Returns:
        1 for the cells of the corridor (h, w), grown by one cell, and the cost of the cheapest way
        [unit]; None where there is no way.
    """
    reach = (1.0 + slack) * (1.0 + UNSURE)
    there = march(costs, np.array([start]), Limits(goal, reach - 1.0))
    best = float(there[flat_index(costs, goal)])
    if not best < np.inf:
        return None
    back = march(costs, np.array([goal]), Limits(rest=there, most=reach * best))
    if not back[flat_index(costs, start)] < np.inf:
        back = march(costs, np.array([goal]))
    both = there + back
    cheapest = Field(costs=costs, flat=back).path_from(*start) / costs.frame.cell
    along = (cheapest + k.RING).astype(np.int64)
    stride = costs.frame.shape[1] + 2 * k.RING
    limit = (1.0 + slack) * both[along[:, 1] * stride + along[:, 0]].max()
    return _grown(both.reshape(-1, stride) <= limit), best * costs.frame.cell


def _grown(ringed: Any) -> U8:
    """1 in every cell with a true neighbour, of a grid that has a ring."""
    h, w = (side - 2 * k.RING for side in ringed.shape)
    chosen = np.zeros((h, w), np.uint8)
    for i in range(k.RING - 1, k.RING + 2):
        for j in range(k.RING - 1, k.RING + 2):
            chosen |= ringed[i : i + h, j : j + w]
    return chosen


def spread(costs: CostMap, chosen: U8, block: int = BLOCK) -> F32:
    """The costs of all cells in the chosen blocks, with a ring; inf elsewhere."""
    h, w = costs.frame.shape
    grid = np.full((h + 2 * k.RING, w + 2 * k.RING), np.inf, np.float32)
    pooling.unpool(costs.cost, chosen, block, k.RING, grid)
    return grid
