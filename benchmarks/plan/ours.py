"""rovernav: any angle, over the whole map, and from cell to cell."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from . import task


def any_angle(cost: Any, start: Any, goal: Any) -> Callable[[], Any]:
    """`plan.any_angle` as it comes."""
    return _with("any_angle", cost, start, goal)


def whole_map(cost: Any, start: Any, goal: Any) -> Callable[[], Any]:
    """`plan.any_angle` without a corridor."""
    return _with("any_angle", cost, start, goal, slack=np.inf)


def shortest(cost: Any, start: Any, goal: Any) -> Callable[[], Any]:
    """`plan.shortest`."""
    return _with("shortest", cost, start, goal)


def _with(name: str, cost: Any, start: Any, goal: Any, **how: Any) -> Callable[[], Any]:
    from rovernav import plan

    costs = plan.CostMap.of(cost)
    ends = task.middles([start, goal])
    return lambda: getattr(plan, name)(costs, ends[0], ends[1], **how).points
