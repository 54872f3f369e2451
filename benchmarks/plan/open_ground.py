"""Peers that leave the grid: scikit-fmm with a descent, OMPL."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from harness.model import Skipped

STEP = 0.5
SECONDS = 5.0
"""What OMPL's planner is given: it has no end of its own."""


def scikit_fmm(cost: Any, start: Any, goal: Any) -> Callable[[], Any]:
    """`travel_time` to second order from the goal, then a descent in steps of half a cell."""
    import skfmm

    blocked = ~np.isfinite(cost)
    speed = np.where(blocked, 0.0, 1.0 / np.where(blocked, 1.0, cost))

    def plan() -> Any:
        phi = np.ones(cost.shape)
        phi[goal] = -1.0
        time = skfmm.travel_time(np.ma.MaskedArray(phi, blocked), speed, order=2)
        return _descent(np.ma.filled(time, np.inf), start, goal)

    return plan


def _descent(time: Any, start: Any, goal: Any) -> Any:
    """Down the gradient of the four cells around; over whole cells where that fails."""
    from rovernav.core import Frame
    from rovernav.kernels.marching import RING
    from rovernav.plan import CostMap, Field

    flat = np.pad(time.astype(np.float32), RING, constant_values=np.inf)
    flat[goal[0] + RING, goal[1] + RING] = -1.0
    costs = CostMap.of(1.0, Frame(cell=1.0, shape=time.shape))
    field = Field(costs=costs, flat=flat.ravel())
    return field.path_from(start[1] + 0.5, start[0] + 0.5)


def ompl(cost: Any, start: Any, goal: Any) -> Callable[[], Any]:
    """RRT* for five seconds, its cost the integral of the cells' costs along each motion."""
    try:
        from ompl import base, geometric
    except ImportError as error:
        raise Skipped(f"ompl cannot be loaded: {error}"[:80]) from None
    from rovernav.plan import CostMap

    costs = CostMap.of(cost)
    h, w = cost.shape
    space = base.RealVectorStateSpace(2)
    bounds = base.RealVectorBounds(2)
    for axis, side in enumerate((w, h)):
        bounds.setLow(axis, 0.0)
        bounds.setHigh(axis, float(side))
    space.setBounds(bounds)

    def plan() -> Any:
        setup = geometric.SimpleSetup(space)
        info = setup.getSpaceInformation()

        class Along(base.OptimizationObjective):
            def motionCost(self, a: Any, b: Any) -> Any:
                return base.Cost(costs.cost_of([(a[0], a[1]), (b[0], b[1])]))

            def stateCost(self, a: Any) -> Any:
                return base.Cost(float(cost[min(int(a[1]), h - 1), min(int(a[0]), w - 1)]))

        setup.setStateValidityChecker(
            lambda s: math.isfinite(cost[min(int(s[1]), h - 1), min(int(s[0]), w - 1)])
        )
        info.setStateValidityCheckingResolution(0.5 / math.hypot(h, w))
        first, last = setup.getStateSpace().allocState(), setup.getStateSpace().allocState()
        for state, (row, column) in ((first, start), (last, goal)):
            state[0], state[1] = column + 0.5, row + 0.5
        setup.setStartAndGoalStates(first, last)
        setup.setOptimizationObjective(Along(info))
        setup.setPlanner(geometric.RRTstar(info))
        setup.solve(SECONDS)
        if not setup.haveExactSolutionPath():
            raise Skipped(f"no path in {SECONDS:.0f} s")
        states = setup.getSolutionPath().getStates()
        return np.array([(s[0], s[1]) for s in states])

    return plan
