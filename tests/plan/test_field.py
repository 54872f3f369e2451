from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.core import Frame, InputError
from rovernav.plan import CostMap, any_angle, cost_to_go, travel_time
from tests.plan.grounds import smooth


def middles(n: int) -> tuple[Any, Any]:
    y, x = np.mgrid[0:n, 0:n] + 0.5
    return x, y


@pytest.mark.parametrize(("order", "most"), [(1, 0.015), (2, 0.002)])
def test_even_ground(order: int, most: float) -> None:
    costs = CostMap.of(2.0, Frame(cell=0.5, shape=(120, 120)))
    x, y = middles(120)
    exact = 2.0 * np.hypot(0.5 * x - 21.3, 0.5 * y - 33.1)
    got = travel_time(costs, (21.3, 33.1), order=order).value
    far = exact > 10.0
    assert (np.abs(got - exact)[far] / exact[far]).max() < most


def test_two_half_planes() -> None:
    # Snell: what crosses the border pays 1 below it and 2 above it
    cost = np.ones((100, 100))
    cost[50:] = 2.0
    got = travel_time(CostMap.of(cost), (30.5, 20.5)).value
    x, y = middles(100)
    cross = np.linspace(0, 100, 4001)
    for row in (60, 75, 95):
        for column in (10, 50, 90):
            best = (np.hypot(cross - 30.5, 29.5)
                    + 2 * np.hypot(x[row, column] - cross, y[row, column] - 50)).min()  # fmt: skip
            assert got[row, column] == pytest.approx(best, rel=0.01)


def test_several_seeds_share_the_ground() -> None:
    costs = CostMap.of(np.ones((40, 60)))
    seeds = [(5.5, 5.5), (50.5, 30.5)]
    both = travel_time(costs, seeds).value
    alone = [travel_time(costs, seed).value for seed in seeds]
    assert_allclose(both, np.minimum(*alone), rtol=0.01, atol=0.05)


def test_going_down_leads_home(rng: np.random.Generator) -> None:
    costs = smooth(rng, 90, blocked=0.2)
    goal = next(g for g in np.argwhere(~costs.forbidden)[2000:] if True)
    home = costs.frame.centre_of(int(goal[0]), int(goal[1]))
    field = cost_to_go(costs, home)
    x, y = middles(90)
    for row, column in np.argwhere(np.isfinite(field.value))[::997]:
        path = field.path_from(x[row, column], y[row, column])
        assert_allclose(path[0], (x[row, column], y[row, column]))
        assert math.dist(path[-1], home) < 1.0
        assert np.isfinite(costs.cost_of(path))
        route = any_angle(costs, (x[row, column], y[row, column]), home)
        assert route.cost <= field.at(x[row, column], y[row, column]) * 1.01 + 1e-9


def test_the_orders_agree(rng: np.random.Generator) -> None:
    costs = smooth(rng, 90, blocked=0.2)
    home = costs.frame.centre_of(*map(int, np.argwhere(~costs.forbidden)[100]))
    first, second = (travel_time(costs, home, order=order).value for order in (1, 2))
    np.testing.assert_array_equal(np.isinf(first), np.isinf(second))
    known = np.isfinite(first) & (second > 20.0)
    assert_allclose(first[known], second[known], rtol=0.05)


def test_what_cannot_be_asked() -> None:
    costs = CostMap.of(1.0, forbidden=np.eye(3))
    with pytest.raises(InputError, match="the order must be 1 or 2, got 3"):
        travel_time(costs, (0.5, 1.5), order=3)
    with pytest.raises(InputError, match="off the map or on forbidden ground"):
        travel_time(costs, (0.5, 0.5))
    with pytest.raises(InputError, match=r"seeds must be points \(k, 2\)"):
        travel_time(costs, np.empty((0, 2)))
    field = cost_to_go(costs, (0.5, 2.5))
    assert field.at(2.5, 0.5) == np.inf
    assert field.at(-1.0, 0.5) == np.inf
    with pytest.raises(InputError, match="there is no way from"):
        field.path_from(2.5, 0.5)


@pytest.mark.oracle
def test_it_agrees_with_scikit_fmm(rng: np.random.Generator) -> None:
    skfmm = pytest.importorskip("skfmm", reason="scikit-fmm is not installed")
    x, y = middles(200)
    far = np.hypot(x - 70.5, y - 60.5)
    cost = 1.0 + (smooth(rng, 200).cost - 1.0) * np.clip(far / 30.0 - 0.5, 0.0, 1.0)
    costs = CostMap.of(cost)
    for order, most in ((1, 0.01), (2, 0.006)):
        theirs = np.asarray(skfmm.travel_time(far - 10.0, 1.0 / cost, order=order))
        ours = travel_time(costs, (70.5, 60.5), order=order).value
        beyond = far > 15.0  # where the ground is even their front begins as a circle
        assert_allclose(ours[beyond], theirs[beyond] + 10.0, rtol=most)
