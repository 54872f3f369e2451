from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.core import read_only
from rovernav.kernels import polyline
from tests.naive.routes import line_cost

pytestmark = pytest.mark.kernels


def cost_of(a: tuple[float, float], b: tuple[float, float], c: np.ndarray) -> float:
    """From either end: it must be the same."""
    c = read_only(c)  # as costs are in a CostMap: no second compilation
    there = polyline.piece(*a, *b, c)
    back = polyline.piece(*b, *a, c)
    if math.isfinite(there):
        assert_allclose(there, back, rtol=1e-12)
    else:
        assert there == back
    return there


def test_it_is_the_line_integral(rng: np.random.Generator) -> None:
    c = rng.uniform(0.5, 3.0, (6, 9)).astype(np.float32)
    c[rng.random(c.shape) < 0.1] = np.inf
    finite = 0
    for _ in range(150):
        a, b = rng.uniform(0, [9, 6], (2, 2))
        expected = line_cost(a, b, c)
        finite += math.isfinite(expected)
        assert_allclose(cost_of(tuple(a), tuple(b), c), expected, rtol=1e-9, atol=1e-12)
    assert 30 < finite < 130


def test_from_middle_to_middle_it_is_the_step_of_a_grid() -> None:
    c = np.array([[1.0, 2.0], [5.0, 4.0]], np.float32)
    assert_allclose(cost_of((0.5, 0.5), (1.5, 0.5), c), 1.5)
    assert_allclose(cost_of((0.5, 0.5), (1.5, 1.5), c), math.sqrt(2) * 2.5, rtol=1e-8)


def test_along_a_border_the_dearer_cell_counts() -> None:
    c = np.array([[1.0, 2.0], [3.0, 4.0]], np.float32)
    assert_allclose(cost_of((1.0, 0.0), (1.0, 2.0), c), 2.0 + 4.0)
    assert_allclose(cost_of((0.0, 1.0), (2.0, 1.0), c), 3.0 + 4.0)


def test_touching_something_is_forbidden() -> None:
    c = np.ones((3, 3), np.float32)
    c[1, 1] = np.inf
    assert cost_of((0.0, 1.0), (3.0, 1.0), c) == np.inf  # along its border
    assert cost_of((0.5, 0.5), (0.9, 0.9), c) < np.inf
    assert cost_of((0.0, 2.0), (2.0, 0.0), c) == np.inf  # past its corner
    assert cost_of((1.0, 1.0), (1.0, 1.0), c) == np.inf  # a point on its corner
    assert cost_of((0.2, 0.2), (0.2, 0.2), c) == 0.0


@pytest.mark.parametrize("end", [(3.5, 1.0), (1.0, -0.1), (np.nan, 1.0), (np.inf, 0.0)])
def test_beyond_the_grid_everything_is_blocked(end: tuple[float, float]) -> None:
    assert cost_of((1.0, 1.0), end, np.ones((3, 3), np.float32)) == np.inf


def test_the_edge_of_the_grid_belongs_to_it() -> None:
    assert_allclose(cost_of((0.0, 0.0), (3.0, 0.0), np.ones((2, 3), np.float32)), 3.0)
    assert_allclose(cost_of((3.0, 0.0), (3.0, 2.0), np.ones((2, 3), np.float32)), 2.0)


def test_long_pieces_lose_nothing(rng: np.random.Generator) -> None:
    c = np.ones((400, 700), np.float32)
    for _ in range(20):
        a, b = rng.uniform(0, [700, 400], (2, 2))
        assert_allclose(cost_of(tuple(a), tuple(b), c), math.dist(a, b), rtol=1e-12)


def test_span_finds_the_first_cost_that_is_none() -> None:
    c = np.array([[1.0, np.inf], [3.0, 2.0]], np.float32)
    assert polyline.span(read_only(c)) == (1.0, 3.0, -1)
    c[1, 0] = 0.0
    assert polyline.span(read_only(c))[2] == 2
    c[0, 1] = np.nan
    assert polyline.span(read_only(c))[2] == 1
