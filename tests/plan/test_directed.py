"""Ways where going costs by direction."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav import plan
from rovernav.core import InputError, SettingError
from rovernav.kernels import going as k
from rovernav.plan._directed import NEIGHBOURS, Search, stencil
from tests.naive import going as naive
from tests.plan.slopes import bumpy, going_over

EVERY = tuple(plan.OBJECTIVES)
NO_GOAL = ((0.0, 0.0), 0.0, np.empty((0, 0)))


@pytest.mark.kernels
@pytest.mark.parametrize("neighbours", NEIGHBOURS)
def test_moves_are_all_different_and_have_their_length(neighbours: int) -> None:
    moves = stencil(neighbours)
    assert len(set(zip(moves.down, moves.right, strict=True))) == neighbours
    for n in range(neighbours):
        part = slice(moves.first[n], moves.first[n + 1])
        length = math.hypot(moves.down[n], moves.right[n])
        assert_allclose(moves.within[part].sum(), length, rtol=1e-12)


@pytest.mark.kernels
@pytest.mark.parametrize("objective", EVERY)
def test_pieces_cost_what_sorted_crossings_say(objective: str) -> None:
    ground = going_over(bumpy(3, 12, 0.5), objective)
    rng = np.random.default_rng(1)
    finite = 0
    for _ in range(40):
        a, b = rng.uniform(0.0, 12.0, (2, 2))
        told = naive.piece(ground, tuple(a), tuple(b))
        assert_allclose(ground.cost_of([a, b]), told, rtol=1e-9)
        finite += told < math.inf
    assert finite > 5


def _search(ground: plan.Going, first: tuple[int, int], room: int) -> tuple[float, np.ndarray]:
    shape = ground.frame.shape
    cost, came = np.full(shape, np.inf), np.full(shape, -1, np.int8)
    cost[first] = 0.0
    heap = k.Heap(np.empty(room), np.empty(room, np.int64))
    told, _end = k.search(ground.packed(), stencil(16), *NO_GOAL, cost, came, heap)
    return told, cost


def test_energy_on_20_x_20_is_that_of_brute_force() -> None:
    ground = going_over(bumpy(0, 20, 0.5))
    free = np.argwhere(ground.blocked == 0)
    first = (int(free[0, 0]), int(free[0, 1]))
    best = naive.costs_from(ground, first, 2)
    _told, cost = _search(ground, first, 9000)
    assert np.isfinite(best).sum() > 100
    assert_allclose(cost * ground.frame.cell, best, rtol=1e-9)


def test_the_bound_of_a_search_to_a_goal_loses_nothing() -> None:
    for objective in EVERY:
        ground = going_over(bumpy(1, 40, 0.6), objective)
        start = ground.frame.centre_of(*np.argwhere(ground.blocked == 0)[0])
        everywhere, towards = Search(ground, start), Search(ground, start)
        everywhere.run()
        for cell in np.argwhere(np.isfinite(everywhere.cost))[5::60]:
            goal = ground.frame.centre_of(*cell)
            assert_allclose(towards.run(goal)[0], everywhere.to(goal), rtol=1e-12)


def test_a_full_heap_says_so() -> None:
    ground = going_over(bumpy(0, 20, 0.5))
    first = tuple(np.argwhere(ground.blocked == 0)[0])
    assert _search(ground, first, 4)[0] == k.FULL


@pytest.mark.parametrize("objective", EVERY)
def test_terms_sum_to_the_cost(objective: str) -> None:
    ground = going_over(bumpy(5, 40, 0.5), objective)
    found = plan.directed(ground, (2.0, 2.0), (37.0, 36.5))
    assert found.found, found.reason
    assert_allclose(found.points[[0, -1]], [(2.0, 2.0), (37.0, 36.5)], rtol=0)
    assert_allclose(found.cost, ground.cost_of(found.points), rtol=0)
    assert_allclose(ground.split(found.points).sum(axis=1), ground.pieces(found.points), rtol=1e-9)


@pytest.mark.parametrize("objective", EVERY)
def test_each_objective_is_best_at_its_own(objective: str) -> None:
    ground = going_over(bumpy(7, 48, 0.6))
    ends = (2.0, 2.0), (45.0, 44.0)
    own = ground.by(objective)
    cost = plan.directed(own, *ends).cost
    assert cost < math.inf
    for other in EVERY:
        theirs = own.cost_of(plan.directed(ground.by(other), *ends).points)
        assert cost <= theirs * 1.005, other


def test_tight_is_cheaper_than_the_graph_and_more_neighbours_are_no_dearer() -> None:
    ground = going_over(bumpy(5, 40, 0.5))
    ends = (2.0, 2.0), (37.0, 36.5)
    graph = [plan.directed(ground, *ends, neighbours=n, tight=False).cost for n in NEIGHBOURS]
    assert graph == sorted(graph, reverse=True)
    for n, cost in zip(NEIGHBOURS, graph, strict=True):
        assert plan.directed(ground, *ends, neighbours=n).cost < cost


def test_uphill_costs_more_than_downhill() -> None:
    ground = going_over(np.tile(0.08 * np.arange(40.0), (40, 1)))
    up = plan.directed(ground, (5.0, 20.0), (35.0, 20.0))
    down = plan.directed(ground, (35.0, 20.0), (5.0, 20.0))
    assert up.cost > 1.3 * down.cost


def test_least_energy_goes_around_a_hill_that_the_shortest_way_climbs() -> None:
    x, y = np.meshgrid(np.arange(60.0), np.arange(60.0))
    ground = going_over(3.0 * np.exp(-((x - 30) ** 2 + (y - 28) ** 2) / 12.0**2), "distance")
    ends = (5.0, 28.0), (55.0, 28.0)
    short, least = plan.directed(ground, *ends), plan.directed(ground.by("energy"), *ends)
    energy = ground.by("energy").cost_of
    assert least.length > 1.02 * short.length
    assert energy(least.points) < 0.98 * energy(short.points)


def _ramp(degrees: float) -> np.ndarray:
    rise = 40.0 * math.tan(math.radians(degrees))
    return np.tile(np.interp(np.arange(80.0), [20, 60], [0.0, rise]), (80, 1))


def test_a_rover_tacks_up_what_it_cannot_climb_straight() -> None:
    ground = going_over(_ramp(17.5), "distance")
    ends = (10.0, 40.0), (70.0, 40.0)
    assert not ground.blocked.any()
    assert ground.cost_of(ends) == math.inf
    assert ground.cost_of(ends[::-1]) < math.inf
    up, down = plan.directed(ground, *ends), plan.directed(ground, *ends[::-1])
    assert up.cost == ground.cost_of(up.points)
    assert up.length > 1.05 * down.length


def test_where_it_cannot_tack_slip_is_named_and_the_number_opens_a_way() -> None:
    heights = _ramp(17.5)
    heights[:39], heights[42:] = np.nan, np.nan
    ground = going_over(heights, "distance")
    ends = (10.0, 40.5), (70.0, 40.5)
    assert plan.directed(ground, *ends[::-1]).found
    found = plan.travel(ground, ends)
    assert not found.found
    (barrier,) = (b for b in found.barriers if b.limit == "slip")
    assert barrier.now < barrier.needed < 0.9
    assert f"rises from {barrier.now:.0%} to {barrier.needed:.0%}" in found.reason
    assert found.nearest is not None
    assert found.nearest[0] < 30.0


def test_start_is_goal() -> None:
    found = plan.directed(going_over(bumpy(0)), (9.5, 9.5), (9.5, 9.5))
    assert found.found
    assert found.length == found.cost == 0.0


def test_same_question_same_bits() -> None:
    ground = going_over(bumpy(5, 40, 0.5))
    a, b = (plan.directed(ground, (2.0, 2.0), (37.0, 36.5)).points for _ in range(2))
    assert np.array_equal(a, b)


def test_what_is_refused() -> None:
    ground = going_over(bumpy(0))
    with pytest.raises(SettingError, match="neighbours must be 8, 16 or 32, got 7"):
        plan.directed(ground, (1.0, 1.0), (5.0, 5.0), neighbours=7, tight=False)
    with pytest.raises(SettingError, match=r"unknown objective 'enregy'.*energy"):
        going_over(bumpy(0), "enregy")
    with pytest.raises(InputError, match="the start must be two numbers"):
        plan.directed(ground, (np.nan, 1.0), (5.0, 5.0))
    assert plan.directed(ground, (-1.0, 1.0), (5.0, 5.0)).way == "start_outside"


def test_held_karp_is_the_best_of_all_orders() -> None:
    rng = np.random.default_rng(3)
    for n in (2, 3, 4, 6, 7):
        matrix = rng.uniform(1.0, 9.0, (n, n))
        orders = [(0, *inner, n - 1) for inner in itertools.permutations(range(1, n - 1))]
        costs = [sum(matrix[a, b] for a, b in itertools.pairwise(o)) for o in orders]
        assert plan.held_karp(matrix) == orders[int(np.argmin(costs))]


def test_best_order_is_cheaper_than_a_foolish_one() -> None:
    ground = going_over(bumpy(5, 40, 0.5))
    stops = [(2.0, 2.0), (35.0, 30.0), (8.0, 9.0), (24.0, 20.0), (37.0, 36.5)]
    given, best = (plan.travel(ground, stops, order=order) for order in plan.ORDERS)
    assert given.found, given.reason
    assert best.order == (0, 2, 3, 1, 4)
    assert best.cost < given.cost
    assert_allclose(sum(leg["cost"] for leg in best.account()), best.cost, rtol=1e-12)
    for leg in best.account():
        assert_allclose(sum(leg["terms"].values()), leg["cost"], rtol=1e-9)


def test_trips_that_are_refused() -> None:
    ground = going_over(bumpy(0))
    with pytest.raises(SettingError, match="at most 12 stops between start and goal, got 13"):
        plan.travel(ground, [(5.0, 5.0)] * 15, order="best")
    with pytest.raises(InputError, match="needs a start and a goal, got 1"):
        plan.travel(ground, [(5.0, 5.0)])
    with pytest.raises(SettingError, match=r"unknown order 'bets'.*best"):
        plan.travel(ground, [(5.0, 5.0), (6.0, 6.0)], order="bets")


def test_waypoints_are_on_the_way_and_no_farther_apart() -> None:
    points = plan.waypoints([(0.0, 0.0), (10.0, 0.0), (10.0, 3.0)], apart=4.0)
    assert_allclose(points[-1], (10.0, 3.0))
    assert np.hypot(*np.diff(points, axis=0).T).max() <= 4.0
    assert len(points) == 5
