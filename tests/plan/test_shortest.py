from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy import sparse
from scipy.sparse import csgraph

from rovernav.core import Frame, InputError
from rovernav.plan import CostMap, Way, shortest
from tests.naive.routes import dijkstra, neighbours
from tests.plan.grounds import bumpy, touches


def middle(costs: CostMap, row: int, column: int) -> tuple[float, float]:
    return costs.frame.centre_of(row, column)


def pair(costs: CostMap, rng: np.random.Generator) -> tuple[tuple[int, int], tuple[int, int]]:
    a, b = rng.permutation(np.argwhere(~costs.forbidden))[:2]
    return (int(a[0]), int(a[1])), (int(b[0]), int(b[1]))


@pytest.mark.parametrize("corners", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_it_is_as_short_as_with_a_heap(seed: int, corners: bool) -> None:
    rng = np.random.default_rng(seed)
    costs = bumpy(rng, (int(rng.integers(1, 25)), int(rng.integers(2, 40))), 0.3)
    start, goal = pair(costs, rng)
    far = dijkstra(costs.cost, start, corners=corners)
    for cell in (goal, *map(tuple, np.argwhere(np.isfinite(far))[::17])):
        route = shortest(costs, middle(costs, *start), middle(costs, *cell), corners=corners)
        assert route.found == bool(np.isfinite(far[cell]))
        if route.found:
            assert_allclose(route.cost, far[cell], rtol=1e-9)


def test_it_is_as_short_as_scipy_finds(rng: np.random.Generator) -> None:
    costs = CostMap.of(np.exp(rng.normal(0.0, 1.5, (60, 80))), forbidden=rng.random((60, 80)) < 0.2)
    edges = [
        (cell[0] * 80 + cell[1], other[0] * 80 + other[1], step)
        for cell in map(tuple, np.argwhere(~costs.forbidden))
        for step, other in neighbours(costs.cost, cell, corners=False)
    ]
    rows, columns, steps = zip(*edges, strict=True)
    graph = sparse.csr_array((steps, (rows, columns)), shape=(4800, 4800))
    start, _goal = pair(costs, rng)
    far = csgraph.dijkstra(graph, indices=start[0] * 80 + start[1]).reshape(60, 80)
    for cell in map(tuple, np.argwhere(np.isfinite(far))[::97]):
        route = shortest(costs, middle(costs, *start), middle(costs, *cell))
        assert_allclose(route.cost, far[cell], rtol=1e-9)


def test_the_route_is_what_it_costs_and_cuts_no_corner(rng: np.random.Generator) -> None:
    for _ in range(20):
        costs = bumpy(rng, (20, 30), 0.35)
        start, goal = pair(costs, rng)
        route = shortest(costs, middle(costs, *start), middle(costs, *goal))
        if not route.found:
            continue
        assert_allclose(costs.cost_of(route.points), route.cost, rtol=1e-7)
        assert not touches(route.points, costs)
        steps = np.abs(np.diff(route.points, axis=0)).max(axis=1)
        assert_allclose(steps, 1.0)


@settings(max_examples=30)
@given(seed=st.integers(0, 10**6), factor=st.floats(1e-3, 1e3))
def test_from_either_end_and_at_any_price(seed: int, factor: float) -> None:
    rng = np.random.default_rng(seed)
    costs = bumpy(rng, (12, 17), 0.25)
    start, goal = (middle(costs, *cell) for cell in pair(costs, rng))
    there, back = shortest(costs, start, goal), shortest(costs, goal, start)
    assert there.found == back.found
    dearer = shortest(CostMap.of(costs.cost * np.float32(factor), unit="J"), start, goal)
    if there.found:
        assert_allclose(there.cost, back.cost, rtol=1e-9)
        assert_allclose(dearer.cost, there.cost * np.float32(factor), rtol=1e-5)


def test_cells_have_a_size() -> None:
    costs = CostMap.of(2.0, Frame(cell=0.5, shape=(3, 9)))
    route = shortest(costs, (0.1, 0.7), (4.4, 0.9))
    assert_allclose(route.points[[0, -1]], [[0.25, 0.75], [4.25, 0.75]])
    assert_allclose([route.length, route.cost], [4.0, 8.0])


def test_an_end_beyond_the_map_is_told_in_its_coordinates_too() -> None:
    frame = Frame(cell=0.5, shape=(4, 6), origin=(7000.0, -90.0))
    answer = shortest(CostMap.of(1.0, frame), (-6995.0, 91.0), (1.5, 0.5))
    assert answer.reason == (
        "the start (-6995, 91) m lies beyond the map, which is 3 m wide and 2 m high; in its own "
        "coordinates that is 5, 1, and it spans x from 7000 to 7003 and y from -90 to -88"
    )
    plain = shortest(CostMap.of(1.0, Frame(cell=0.5, shape=(4, 6))), (9, 1), (1.5, 0.5))
    assert plain.reason.endswith("which is 3 m wide and 2 m high")


def test_ends_that_cannot_be() -> None:
    costs = CostMap.of(1.0, forbidden=np.eye(4))
    assert shortest(costs, (9, 1), (1.5, 0.5)).way is Way.START_OUTSIDE
    assert shortest(costs, (1.5, 0.5), (1, -1)).way is Way.GOAL_OUTSIDE
    assert shortest(costs, (0.5, 0.5), (1.5, 0.5)).way is Way.START_FORBIDDEN
    goal = shortest(costs, (1.5, 0.5), (2.5, 2.5))
    assert goal.way is Way.GOAL_FORBIDDEN
    assert goal.status == "unreachable"
    assert goal.nearest is not None
    assert costs.cost[costs.frame.cell_of(*goal.nearest)] == 1.0
    across = shortest(costs, (1.5, 0.5), (0.5, 1.5))
    assert across.way is Way.START_ENCLOSED or across.way is Way.GOAL_ENCLOSED
    assert shortest(costs, (1.5, 0.5), (0.5, 1.5), corners=True).found
    with pytest.raises(InputError, match="the goal must be two numbers"):
        shortest(costs, (1, 1), (np.nan, 1))


def test_one_cell() -> None:
    costs = CostMap.of([[2.0]])
    route = shortest(costs, (0.2, 0.2), (0.9, 0.1))
    assert route.found
    assert (len(route.points), route.cost, route.length) == (1, 0.0, 0.0)
    nothing = CostMap.of([[np.inf]])
    answer = shortest(nothing, (0.2, 0.2), (0.9, 0.1))
    assert answer.way is Way.START_FORBIDDEN
    assert "no cell of this map is free" in answer.reason
