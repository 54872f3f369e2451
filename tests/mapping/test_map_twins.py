"""What happens to a whole map of heights, cell by cell in plain Python."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.kernels import elevation as kernels
from rovernav.kernels import fan
from tests.naive import elevation as naive

pytestmark = pytest.mark.kernels
S, N, CELL = 16, 3, 0.2


@pytest.fixture
def centre(rng: np.random.Generator) -> Any:
    """Rovers far from their maps' origin, on both sides of it."""
    return rng.integers(-40, 40, (N, 2))


def cells_of(centre: Any, k: int) -> list[tuple[int, int]]:
    """World cells that the map of rover k holds."""
    return [
        (int(centre[k, 0]) + i, int(centre[k, 1]) + j)
        for i in range(-S // 2, S // 2) for j in range(-S // 2, S // 2)
    ]  # fmt: skip


def at(layer: Any, k: int, cell: tuple[int, int]) -> float:
    return layer[k, cell[0] % S, cell[1] % S]


def some_map(rng: np.random.Generator) -> tuple[Any, Any]:
    height = rng.normal(0.0, 0.3, (N, S, S)).astype(np.float32)
    variance = rng.uniform(0.001, 0.1, (N, S, S)).astype(np.float32)
    lost = rng.random((N, S, S)) < 0.3
    height[lost] = variance[lost] = np.nan
    return height, variance


def test_doubt_grows_as_in_plain_python(rng: np.random.Generator) -> None:
    _, variance = some_map(rng)
    top = rng.normal(0.0, 0.3, (N, S, S)).astype(np.float32)
    slope = rng.uniform(0.0, 0.6, (N, S, S)).astype(np.float32)
    slope[rng.random(slope.shape) < 0.2] = np.nan
    rise, aside = np.array([0.01, 0.0, 0.0]), np.array([0.02, 0.03, 0.0])
    want_v, want_t = variance.astype(float), top.astype(float)
    for k, i, j in np.ndindex(variance.shape):
        steep = 0.0 if math.isnan(slope[k, i, j]) else math.tan(slope[k, i, j])
        grown = want_v[k, i, j] + rise[k] + steep**2 * aside[k]
        sunk = math.sqrt(grown) - math.sqrt(want_v[k, i, j])
        want_v[k, i, j], want_t[k, i, j] = grown, want_t[k, i, j] - (sunk if k < 2 else 0.0)
    kernels.inflate(variance, top, slope, rise, aside)
    assert_allclose(variance, want_v, rtol=1e-5)
    assert_allclose(top, want_t, atol=1e-6)


def test_a_patch_is_laid_where_it_fits_as_in_plain_python(
    rng: np.random.Generator, centre: Any
) -> None:
    height, variance = some_map(rng)
    f = kernels.Fusion(CELL, 0.8, 0.01, 1e-4, 1.0)
    places = rng.uniform(-2.0, 2.0, (40, 2))
    patch = rng.normal(0.0, 0.3, (N, 40))
    patch[rng.random(patch.shape) < 0.3] = np.nan
    patch[2] = np.nan
    stand = np.empty((N, 4))
    stand[:, 0], stand[:, 1] = CELL * (centre[:, 1] + 0.4), CELL * (centre[:, 0] + 0.7)
    stand[:, 2] = rng.uniform(-3.0, 3.0, N)
    want = []
    for k in range(N):
        both = []
        for place, up in zip(places, patch[k], strict=True):
            cell = naive.cell_at(stand[k], place, CELL)
            if not naive.inside(cell, tuple(centre[k]), S) or math.isnan(up):
                continue
            known = float(at(height, k, cell))
            if not math.isnan(known):
                doubt = float(at(variance, k, cell)) + naive.variance_of(f, place, up)
                both.append((known - up, 1.0 / doubt))
        total = sum(weight for _, weight in both)
        want.append(sum(gap * weight for gap, weight in both) / total if both else 0.0)
    kernels.level(height, variance, centre, stand, places, patch, f)
    assert want[2] == 0.0 != want[0]
    assert_allclose(stand[:, 3], want, rtol=1e-5)


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("radius", [0.5, 2.3])
def test_hazards_grow_as_in_plain_python(
    radius: float, closed: bool, rng: np.random.Generator, centre: Any
) -> None:
    reason = rng.choice(
        np.array([kernels.FREE, kernels.UNKNOWN, kernels.STEEP, kernels.LEDGE, kernels.NEAR]),
        (N, S, S), p=[0.7, 0.15, 0.03, 0.02, 0.1],
    ).astype(np.uint8)  # fmt: skip
    marks = (rng.random((N, S, S)) < 0.05).astype(np.uint8)
    want_reason, want = reason.copy(), marks.copy()
    for k in range(N):
        whole = cells_of(centre, k)
        bad = [c for c in whole if at(reason, k, c) in (kernels.STEEP, kernels.LEDGE)]
        for cell in whole:
            i, j = cell[0] % S, cell[1] % S
            near = any(math.dist(cell, other) <= radius for other in bad)
            was = reason[k, i, j]
            if was in (kernels.FREE, kernels.NEAR):
                want_reason[k, i, j] = kernels.NEAR if near else kernels.FREE
            want[k, i, j] = marks[k, i, j] or near or (closed and was == kernels.UNKNOWN)
    cells = np.empty_like(marks)
    kernels.grow(reason, marks, centre, radius, closed, cells)
    assert_array_equal(cells, want)
    assert_array_equal(reason, want_reason)


def test_what_leaves_is_forgotten_as_in_plain_python(rng: np.random.Generator, centre: Any) -> None:
    layer = rng.normal(size=(N, S, S)).astype(np.float32)
    shift = np.array([(3, -2), (0, 0), (S + 5, 1)])
    pose = np.zeros((N, 3))
    now = centre + shift
    pose[:, 0], pose[:, 1] = CELL * (now[:, 1] + 0.5), CELL * (now[:, 0] + 0.5)
    held = [{c: float(at(layer, k, c)) for c in cells_of(centre, k)} for k in range(N)]
    kernels.forget(layer, centre, pose, CELL, np.nan)
    for k in range(N):
        for cell in cells_of(now, k):
            assert at(layer, k, cell) == pytest.approx(held[k].get(cell, math.nan), nan_ok=True)


def test_rays_of_a_map_are_those_of_plain_python(rng: np.random.Generator, centre: Any) -> None:
    cells = (rng.random((N, S, S)) < 0.04).astype(np.uint8)
    pose = np.zeros((N, 3))
    pose[:, 0] = CELL * (centre[:, 1] + rng.uniform(0.01, 0.99, N))
    pose[:, 1] = CELL * (centre[:, 0] + rng.uniform(0.01, 0.99, N))
    zero, out, farthest = rng.uniform(-3.0, 3.0, N), np.empty((N, 12)), S // 2 - 1
    fan.around(cells, centre, pose, zero, CELL, out)
    for k in range(N):
        for ray in range(12):
            turn = zero[k] + math.radians(30.0 * ray)
            looks = [0.5 * CELL * n for n in range(2, 2 * farthest)]
            met = [
                far for far in looks
                if at(cells, k, naive.cell_at((*pose[k, :2], turn), (far, 0.0), CELL))
            ]  # fmt: skip
            assert out[k, ray] == pytest.approx(met[0] if met else CELL * farthest)
