from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.kernels import grid_paths as k
from rovernav.kernels.buckets import queue
from tests.naive.routes import dijkstra

pytestmark = pytest.mark.kernels


def search(c: np.ndarray, start: tuple[int, int], goal: int, how: dict[str, float | bool]):
    ringed = np.pad(c.astype(np.float32), 1, constant_values=np.inf)
    stride = ringed.shape[1]
    d = np.full(ringed.size, np.inf)
    seed = (start[0] + 1) * stride + start[1] + 1
    d[seed] = 0.0
    free = c[np.isfinite(c)]
    slice_ = float(how["width"]) * float(free.min())
    s = k.how(stride, slice_, goal, float(how["least"]), corners=bool(how["corners"]))
    q = queue(int(3 * free.max() / slice_) + 4, 8 * c.size)
    touched = np.zeros(ringed.size + 1, np.int32)
    assert k.search(ringed.ravel(), d, np.array([seed]), q, s, touched) > 0
    listed = touched[1 : 1 + touched[0]]
    np.testing.assert_array_equal(np.sort(listed), np.flatnonzero(np.isfinite(d)))
    return ringed, d, s


@pytest.mark.parametrize("corners", [False, True])
@pytest.mark.parametrize("width", [0.1, 1.0, 7.0])
def test_every_cell_is_as_far_as_with_a_heap(
    width: float, corners: bool, rng: np.random.Generator
) -> None:
    c = rng.uniform(0.5, 4.0, (9, 14)).astype(np.float32)
    c[rng.random(c.shape) < 0.3] = np.inf
    c[4, 5] = 1.0
    how = {"width": width, "least": 0.0, "corners": corners}
    _, d, _ = search(c, (4, 5), -1, how)
    got = d.reshape(11, 16)[1:-1, 1:-1]
    assert_allclose(got, dijkstra(c, (4, 5), corners=corners), rtol=1e-12)


@pytest.mark.parametrize("width", [0.1, 1.0, 7.0])
def test_a_lower_bound_changes_no_length(width: float, rng: np.random.Generator) -> None:
    c = rng.uniform(1.0, 2.0, (9, 14)).astype(np.float32)
    c[rng.random(c.shape) < 0.2] = np.inf
    c[0, 0] = c[8, 13] = 1.0
    how = {"width": width, "least": float(c.min()), "corners": False}
    ringed, d, s = search(c, (0, 0), 9 * 16 + 14, how)
    far = dijkstra(c, (0, 0))[8, 13]
    assert_allclose(d[s.goal], far, rtol=1e-12)
    if np.isfinite(far):
        out = np.empty(200, np.int64)
        count = k.walk_back(ringed.ravel(), d, s.goal, s, out)
        assert (out[0], out[count - 1]) == (s.goal, 17)
        assert k.walk_back(ringed.ravel(), d, s.goal, s, out[:2]) == k.FULL
