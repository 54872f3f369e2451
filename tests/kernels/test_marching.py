from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.kernels import marching as k
from rovernav.kernels.buckets import queue

pytestmark = pytest.mark.kernels
NOTHING = np.empty(0, np.float32)


def solve(f: np.ndarray, seed: tuple[int, int], *, second: bool = False, width: float = 1.0):
    ringed = np.pad(f.astype(np.float32), k.RING, constant_values=np.inf)
    stride = f.shape[1] + 2 * k.RING
    u = np.full(ringed.size, np.inf, np.float32)
    at = (seed[0] + k.RING) * stride + seed[1] + k.RING
    u[at] = 0.0
    free = f[np.isfinite(f)]
    slice_ = width * float(free.min())
    q = queue(int(1.5 * free.max() / slice_) + 4, 4 * f.size)
    how = k.March(stride, slice_, -1, 0.0, second, np.inf)
    assert k.march(ringed.ravel(), u, np.array([at]), q, how, NOTHING) > 0
    grid = u.reshape(-1, stride)
    assert np.isinf(grid[: k.RING]).all()  # the ring stays as it is
    return grid[k.RING : -k.RING, k.RING : -k.RING].astype(np.float64)


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
        assert math.sqrt(grown) == pytest.approx(f[i, j], rel=1e-5)


def test_the_width_of_slices_changes_nothing(rng: np.random.Generator) -> None:
    f = rng.uniform(0.5, 5.0, (20, 30))
    f[rng.random(f.shape) < 0.2] = np.inf
    f[3, 4] = 1.0
    narrow = solve(f, (3, 4), width=0.2)
    assert_allclose(solve(f, (3, 4), width=3.0), narrow, rtol=1e-6)
    assert_allclose(solve(f, (3, 4), width=100.0), narrow, rtol=1e-6)


@pytest.mark.parametrize(("second", "most"), [(False, 0.05), (True, 0.02)])
def test_on_open_ground_it_is_the_straight_distance(second: bool, most: float) -> None:
    u = solve(np.ones((61, 61)), (30, 30), second=second)
    y, x = np.mgrid[-30:31, -30:31]
    far = np.hypot(x, y)
    assert (u >= far - 1e-4).all()
    assert ((u - far)[far > 25] / far[far > 25]).max() < most
    assert_allclose(u[30], np.abs(np.arange(-30, 31)), rtol=1e-6)
    assert_allclose(u, u.T, rtol=1e-5)
    assert_allclose(u, u[::-1], rtol=1e-5)


def test_what_is_walled_in_is_infinitely_far() -> None:
    f = np.ones((20, 20))
    f[5:12, [5, 11]] = np.inf
    f[[5, 11], 5:12] = np.inf
    assert np.isinf(solve(f, (1, 1))[8, 8])
    assert np.isinf(solve(f, (1, 1), second=True)[8, 8])


def test_a_full_queue_is_told() -> None:
    f = np.ones((30 + 2 * k.RING, 30 + 2 * k.RING), np.float32)
    u = np.full(f.size, np.inf, np.float32)
    u[500] = 0.0
    q = queue(4, 1)._replace(link=np.empty(1, np.int32))
    how = k.March(34, 1.0, -1, 0.0, False, np.inf)
    ringed = np.pad(f[2:-2, 2:-2], 2, constant_values=np.inf).astype(np.float32)
    assert k.march(ringed.ravel(), u, np.array([500]), q, how, NOTHING) == k.FULL
