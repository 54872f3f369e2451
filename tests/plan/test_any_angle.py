from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from rovernav.core import Frame, InputError
from rovernav.plan import CostMap, Way, any_angle, shortest
from rovernav.plan import _any_angle as inside
from tests.plan.grounds import bumpy, check, free_point, smooth


@pytest.mark.parametrize("goal", [(37.3, 5.1), (3.1, 41.9), (38.0, 40.0), (2.2, 3.3)])
def test_over_even_ground_it_is_a_straight_line(goal: tuple[float, float]) -> None:
    costs = CostMap.of(3.0, Frame(cell=1.0, shape=(42, 40)))
    start = (2.2, 3.4)
    route = any_angle(costs, start, goal)
    check(route, costs, start, goal)
    assert_allclose(route.length, math.dist(start, goal), rtol=1e-6)
    assert_allclose(route.cost, 3.0 * math.dist(start, goal), rtol=1e-6)


def test_it_breaks_like_light_at_a_border() -> None:
    # Snell: the cheapest way from (3, 10.5) to (57, 49.5) crosses y = 30, where the cost changes
    cost = np.ones((60, 60))
    cost[30:] = 2.5
    costs = CostMap.of(cost)
    start, goal = (3.0, 10.5), (57.0, 49.5)
    x = np.linspace(0, 60, 600_001)
    best = (np.hypot(x - 3, 19.5) + 2.5 * np.hypot(57 - x, 19.5)).min()
    route = any_angle(costs, start, goal)
    check(route, costs, start, goal)
    assert best <= route.cost * (1 + 1e-9)
    assert route.cost <= 1.001 * best


def test_around_a_wall_it_goes_by_the_corners() -> None:
    costs = CostMap.of(1.0, forbidden=np.zeros((40, 40)))
    cost = costs.cost.copy()
    cost[10:40, 20] = np.inf
    costs = CostMap.of(cost)
    start, goal = (5.0, 30.0), (36.0, 30.0)
    best = math.dist(start, (20, 10)) + 1.0 + math.dist((21, 10), goal)
    route = any_angle(costs, start, goal)
    check(route, costs, start, goal)
    assert best < route.length < 1.005 * best


@pytest.mark.parametrize("seed", range(6))
def test_it_undercuts_the_grid_and_touches_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    costs = smooth(rng, 96, blocked=0.3)
    start, goal = free_point(costs, rng), free_point(costs, rng)
    route, grid = any_angle(costs, start, goal), shortest(costs, start, goal)
    assert route.found == grid.found
    if route.found:
        check(route, costs, start, goal)
        ends = sum(
            float(costs.cost[costs.frame.cell_of(*end)])
            * math.dist(end, costs.frame.centre_of(*costs.frame.cell_of(*end)))
            for end in (start, goal)
        )
        assert route.cost <= grid.cost + ends


@settings(max_examples=40)
@given(seed=st.integers(0, 10**6))
def test_hard_ground(seed: int) -> None:
    rng = np.random.default_rng(seed)
    costs = bumpy(rng, (int(rng.integers(1, 40)), int(rng.integers(1, 40))), rng.uniform(0, 0.5))
    if costs.forbidden.all():
        return
    start, goal = free_point(costs, rng), free_point(costs, rng)
    route = any_angle(costs, start, goal)
    assert route.found == shortest(costs, start, goal).found
    if route.found and start != goal:
        check(route, costs, start, goal)
    elif not route.found:
        assert route.way in (Way.START_ENCLOSED, Way.GOAL_ENCLOSED)
        assert route.nearest is not None
        assert any_angle(costs, start, route.nearest).found


@pytest.mark.parametrize("turns", [1, 2, 3])
def test_a_turned_world_has_a_turned_route(turns: int, rng: np.random.Generator) -> None:
    costs = smooth(rng, 80, blocked=0.2)
    start, goal = free_point(costs, rng), free_point(costs, rng)
    route = any_angle(costs, start, goal)

    def turned(point: tuple[float, float]) -> tuple[float, float]:
        x, y = point
        for _ in range(turns):
            x, y = 80.0 - y, x
        return x, y

    other = any_angle(CostMap.of(np.rot90(costs.cost, -turns)), turned(start), turned(goal))
    assert_allclose(other.cost, route.cost, rtol=2e-3)
    back = any_angle(costs, goal, start)
    assert_allclose(back.cost, route.cost, rtol=2e-3)


def test_a_higher_price_changes_no_way(rng: np.random.Generator) -> None:
    costs = smooth(rng, 80, blocked=0.2)
    start, goal = free_point(costs, rng), free_point(costs, rng)
    route = any_angle(costs, start, goal)
    dearer = any_angle(CostMap.of(costs.cost * np.float32(8.0)), start, goal)
    assert_allclose(dearer.points, route.points, rtol=0, atol=1e-6)
    assert_allclose(dearer.cost, 8.0 * route.cost, rtol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_the_corridor_loses_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    costs = smooth(rng, 240, blocked=0.3)
    start, goal = free_point(costs, rng), free_point(costs, rng)
    fast, whole = any_angle(costs, start, goal), any_angle(costs, start, goal, slack=np.inf)
    assert fast.found == whole.found
    if fast.found:
        check(fast, costs, start, goal)
        assert_allclose(fast.cost, whole.cost, rtol=2e-3)


def test_walls_thinner_than_a_block_are_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    # On blocks of four cells the walls vanish; the way found is dearer than the estimate.
    cost = np.ones((240, 240))
    cost[:-3, 41::40] = np.inf
    cost[3:, 61::40] = np.inf
    cost[:3, 41::40] = 1.0
    cost[:-3, 41::40] = np.inf
    costs = CostMap.of(cost)
    start, goal = (5.0, 5.0), (235.0, 120.0)
    route = any_angle(costs, start, goal)
    check(route, costs, start, goal)
    assert route.length > 2000
    monkeypatch.setattr(inside, "SMALL", 10**6)
    assert_allclose(any_angle(costs, start, goal).length, route.length, rtol=1e-3)


def test_on_rough_ground_it_is_no_dearer_than_over_the_grid(rng: np.random.Generator) -> None:
    costs = CostMap.of(np.exp(rng.normal(0.0, 1.0, (220, 220))))
    start, goal = (20.5, 30.5), (190.5, 170.5)
    route = any_angle(costs, start, goal)
    check(route, costs, start, goal)
    assert route.cost < shortest(costs, start, goal).cost


def test_start_at_goal() -> None:
    route = any_angle(CostMap.of(np.ones((3, 3))), (1.2, 1.3), (1.2, 1.3))
    assert route.found
    assert (route.length, route.cost, route.points.tolist()) == (0.0, 0.0, [[1.2, 1.3]])


def test_an_end_that_touches_forbidden_ground() -> None:
    costs = CostMap.of(1.0, forbidden=[[0, 0, 1], [0, 0, 0]])
    answer = any_angle(costs, (2.0, 0.5), (0.5, 0.5))
    assert answer.way is Way.START_FORBIDDEN
    assert "touches forbidden ground; the nearest free ground is at (1.5, 0.5) m" in answer.reason


def test_what_encloses_is_told() -> None:
    cost = np.ones((30, 30))
    cost[10:15, [10, 14]] = np.inf
    cost[[10, 14], 10:15] = np.inf
    costs = CostMap.of(cost, cell=2.0)
    answer = any_angle(costs, (3.0, 3.0), (25.0, 25.0))
    assert answer.way is Way.GOAL_ENCLOSED
    assert "in a region of 9 cells (36 m²)" in answer.reason
    assert answer.nearest == (25.0, 19.0) or answer.nearest == (19.0, 25.0)
    assert any_angle(costs, (25.0, 25.0), (3.0, 3.0)).way is Way.START_ENCLOSED
    assert not answer.points.size
    assert (answer.length, answer.cost) == (np.inf, np.inf)


def test_a_slack_below_nothing() -> None:
    with pytest.raises(InputError, match="slack must be a share of 0 or more"):
        any_angle(CostMap.of(np.ones((3, 3))), (1, 1), (2, 2), slack=-0.1)
