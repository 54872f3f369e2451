"""Maps that tests of routes share, and what a route over them must keep to."""

from __future__ import annotations

import itertools

import numpy as np

from rovernav.core import F64
from rovernav.kernels import geometry
from rovernav.plan import CostMap, Route


def bumpy(rng: np.random.Generator, shape: tuple[int, int], blocked: float = 0.2) -> CostMap:
    """Costs from 1 to 4 that change from cell to cell, some cells forbidden."""
    return CostMap.of(rng.uniform(1.0, 4.0, shape), forbidden=rng.random(shape) < blocked)


def smooth(rng: np.random.Generator, n: int, blocked: float = 0.0) -> CostMap:
    """Costs from 1 to about 4 that change over tens of cells."""
    y, x = np.mgrid[0:n, 0:n] / n
    cost = np.ones((n, n))
    for _ in range(6):
        a, b, phase = rng.uniform(-12, 12), rng.uniform(-12, 12), rng.uniform(0, 6)
        cost += 0.25 * (1.0 + np.sin(a * x + b * y + phase))
    for _ in range(int(blocked * 40)):
        i, j = rng.integers(0, n, 2)
        cost[i : i + n // 10, j : j + n // 10] = np.inf
    return CostMap.of(cost)


def free_point(costs: CostMap, rng: np.random.Generator) -> tuple[float, float]:
    """Anywhere inside a free cell."""
    row, column = rng.permutation(np.argwhere(~costs.forbidden))[0]
    x, y = rng.uniform(0.1, 0.9, 2)
    return float(column + x) * costs.frame.cell, float(row + y) * costs.frame.cell


def touches(path: F64, costs: CostMap) -> bool:
    """Whether a path touches a forbidden cell, by the exact walk that ends drives."""
    points = path / costs.frame.cell
    blocked = costs.forbidden.astype(np.uint8)
    return any(
        geometry.first_cell(a[0], a[1], b[0], b[1], blocked) <= 1.0
        for a, b in itertools.pairwise(points)
    )


def check(route: Route, costs: CostMap, start: tuple[float, float], goal: tuple[float, float]):
    """What every route that was found must be."""
    assert route.found
    np.testing.assert_array_equal(route.points[0], start)
    np.testing.assert_array_equal(route.points[-1], goal)
    assert not touches(route.points, costs)
    lengths = np.hypot(*np.diff(route.points, axis=0).T)
    np.testing.assert_allclose(route.length, lengths.sum(), rtol=1e-12)
    np.testing.assert_allclose(route.cost, costs.cost_of(route.points), rtol=1e-12)
    straight = float(np.hypot(goal[0] - start[0], goal[1] - start[1]))
    assert route.length >= straight * (1 - 1e-12)
    assert route.cost >= costs.least * route.length * (1 - 1e-6)
