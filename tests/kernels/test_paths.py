from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.core import read_only  # as costs are in a CostMap: no second compilation
from rovernav.kernels import polyline, pooling, tracing

pytestmark = pytest.mark.kernels


def priced(points: np.ndarray, c: np.ndarray) -> float:
    out = np.empty(len(points) - 1)
    polyline.pieces(points, read_only(c), out)
    return float(out.sum())


def test_blocks_have_the_mean_of_their_free_cells(rng: np.random.Generator) -> None:
    c = rng.uniform(1.0, 5.0, (10, 13)).astype(np.float32)
    c[rng.random(c.shape) < 0.3] = np.inf
    c[4:8, 8:12] = np.inf
    out = np.empty((3, 4), np.float32)
    pooling.pool(read_only(c), 4, out)
    for i in range(3):
        for j in range(4):
            block = c[4 * i : 4 * i + 4, 4 * j : 4 * j + 4]
            free = block[np.isfinite(block)]
            assert_allclose(out[i, j], free.mean() if free.size else np.inf, rtol=1e-6)
    assert np.isinf(out[1, 2])


def test_chosen_blocks_are_filled_in(rng: np.random.Generator) -> None:
    c = rng.uniform(1.0, 5.0, (5, 6)).astype(np.float32)
    chosen = np.array([[1, 0], [0, 1]], np.uint8)
    out = np.full((9, 10), np.inf, np.float32)
    pooling.unpool(read_only(c), chosen, 4, 2, out)
    expected = np.full((9, 10), np.inf, np.float32)
    expected[2:6, 2:6] = c[:4, :4]
    expected[6, 6:8] = c[4, 4:]
    np.testing.assert_array_equal(out, expected)


@pytest.mark.parametrize("step", [0.5, 0.1])
def test_bending_never_costs(step: float, rng: np.random.Generator) -> None:
    c = rng.uniform(1.0, 4.0, (12, 16)).astype(np.float32)
    path = np.column_stack([np.linspace(1.5, 14.5, 9), rng.uniform(4.0, 8.0, 9)])
    before, out = priced(path, c), np.empty_like(path)
    cost = tracing.bend(path, read_only(c), step, 3, float(c.min()), out)
    assert_allclose(priced(out, c), cost, rtol=1e-12)
    assert cost < before
    np.testing.assert_array_equal(out[[0, -1]], path[[0, -1]])


def test_bending_finds_the_cheapest_of_all_choices(rng: np.random.Generator) -> None:
    c = rng.uniform(1.0, 9.0, (8, 8)).astype(np.float32)
    path = np.array([[0.5, 4.0], [2.5, 4.2], [5.1, 3.9], [7.5, 4.0]])
    out = np.empty_like(path)
    cost = tracing.bend(path, read_only(c), 0.7, 2, float(c.min()), out)
    best = np.inf
    for a in range(-2, 3):
        for b in range(-2, 3):
            if abs(a - b) <= 2:
                moved = path.copy()
                for k, places in ((1, a), (2, b)):
                    along = path[k + 1] - path[k - 1]
                    moved[k] += 0.7 * places * np.array([-along[1], along[0]]) / np.hypot(*along)
                best = min(best, priced(moved, c))
    assert_allclose(cost, best, rtol=1e-12)


def test_tightening_leaves_out_what_costs(rng: np.random.Generator) -> None:
    c = np.ones((20, 20), np.float32)
    path = np.column_stack([np.linspace(1, 19, 30), 10 + rng.uniform(-2, 2, 30)])
    out = np.empty_like(path)
    count = tracing.tighten(path, read_only(c), 64, out)
    assert count < 8
    assert priced(out[:count], c) < priced(path, c)
    np.testing.assert_array_equal(out[[0, count - 1]], path[[0, -1]])
    c[8:12, 9:11] = np.inf
    around = np.array([[1.0, 10.0], [9.0, 7.0], [11.0, 7.0], [19.0, 10.0]])
    count = tracing.tighten(around, read_only(c), 64, out)
    assert np.isfinite(priced(out[:count], c))
