from __future__ import annotations

import heapq
import math

import numpy as np
import pytest

from rovernav.kernels import eikonal

pytestmark = pytest.mark.kernels


def solve(f: np.ndarray, seed: tuple[int, int]) -> np.ndarray:
    u = np.full(f.shape, np.inf)
    u[seed] = 0.0
    eikonal.sweep(f, u, 1e-12, 500)
    return u


def dijkstra(f: np.ndarray, seed: tuple[int, int]) -> np.ndarray:
    """Shortest ways over shared edges and corners: never shorter than the true ones."""
    u = np.full(f.shape, np.inf)
    heap = [(0.0, seed)]
    while heap:
        cost, (i, j) = heapq.heappop(heap)
        if cost >= u[i, j]:
            continue
        u[i, j] = cost
        for di in (-1, 0, 1):
            for dj in (-1, 0, 1):
                a, b = i + di, j + dj
                if (di or dj) and 0 <= a < f.shape[0] and 0 <= b < f.shape[1] and f[a, b] < np.inf:
                    heapq.heappush(
                        heap, (cost + math.hypot(di, dj) * (f[i, j] + f[a, b]) / 2, (a, b))
                    )
    return u


def test_on_open_ground_it_is_the_straight_distance() -> None:
    u = solve(np.ones((41, 41)), (20, 20))
    y, x = np.mgrid[-20:21, -20:21]
    far = np.hypot(x, y)
    assert (u >= far - 1e-9).all()  # first order: never too short
    assert (u - far)[far > 5].max() < 1.1  # and at most a cell too long
    np.testing.assert_allclose(u[20], np.abs(np.arange(-20, 21)))


def test_every_cell_obeys_the_upwind_equation(rng: np.random.Generator) -> None:
    f = rng.uniform(0.5, 3.0, (15, 23))
    f[rng.random(f.shape) < 0.25] = np.inf
    f[7, 11] = 1.0
    u = solve(f, (7, 11))
    padded = np.pad(u, 1, constant_values=np.inf)
    for (i, j), value in np.ndenumerate(u):
        if (i, j) == (7, 11) or not np.isfinite(value):
            continue
        a = min(padded[i, j + 1], padded[i + 2, j + 1])
        b = min(padded[i + 1, j], padded[i + 1, j + 2])
        grown = max(value - a, 0.0) ** 2 + max(value - b, 0.0) ** 2
        assert math.sqrt(grown) == pytest.approx(f[i, j], abs=1e-9)


def test_blocked_ground_is_gone_around_and_never_entered(rng: np.random.Generator) -> None:
    f = np.ones((30, 30))
    f[5:25, 15] = np.inf
    u = solve(f, (15, 5))
    assert np.isinf(u[5:25, 15]).all()
    longest = dijkstra(f, (15, 5))
    assert u[15, 25] > 2 * math.hypot(10, 10) * 0.97
    assert u[15, 25] <= longest[15, 25] * 1.08


def test_what_is_walled_in_is_infinitely_far() -> None:
    f = np.ones((20, 20))
    f[5:12, [5, 11]] = np.inf
    f[[5, 11], 5:12] = np.inf
    assert np.isinf(solve(f, (1, 1))[8, 8])
