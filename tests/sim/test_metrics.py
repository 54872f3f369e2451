from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from rovernav.core import Frame
from rovernav.sim import Grid, Worlds, clearance, path_length
from tests.naive import geometry as naive


def brute(path: np.ndarray, boxes: list[naive.Box]) -> float:
    ends = list(pairwise(path)) or [(path[0], path[0])]
    gaps = [naive.segment_box(a, b, box) for a, b in ends for box in boxes]
    return min(gaps, default=math.inf)


def gridded(seed: int, share: float, cell: float) -> tuple[Worlds, list[naive.Box]]:
    blocked = (np.random.default_rng(seed).random((9, 14)) < share).astype(np.uint8)
    grid = Grid(frame=Frame(cell=cell, shape=(9, 14)), blocked=blocked)
    boxes: list[naive.Box] = [[cell * side for side in box] for box in naive.cells(blocked)]
    return Worlds.single(grid=grid), boxes


@settings(max_examples=30)
@given(seed=st.integers(0, 10**6), points=st.integers(1, 5))
def test_clearance_of_boxes_is_the_smallest_distance_of_all(seed: int, points: int) -> None:
    rng = np.random.default_rng(seed)
    corner = rng.uniform(-5, 5, (4, 2))
    boxes = np.concatenate([corner, corner + rng.uniform(0, 2, (4, 2))], axis=1)
    path = rng.uniform(-7, 7, (points, 2))
    gap = clearance(path, Worlds.single(boxes.tolist()))
    assert_allclose(gap, brute(path, boxes.tolist()), rtol=0, atol=1e-12)


@settings(max_examples=30)
@given(
    seed=st.integers(0, 10**6),
    points=st.integers(1, 4),
    share=st.sampled_from([0.0, 0.01, 0.1]),
    cell=st.sampled_from([0.25, 1.0, 3.7]),
)
def test_clearance_of_a_grid_is_the_smallest_distance_of_all(
    seed: int, points: int, share: float, cell: float
) -> None:
    worlds, boxes = gridded(seed, share, cell)
    path = cell * np.random.default_rng(seed).uniform((-6, -6), (20, 15), (points, 2))
    assert_allclose(clearance(path, worlds), brute(path, boxes), rtol=0, atol=1e-11)


def test_clearance_is_of_segments_not_of_points() -> None:
    path = np.array([[0.0, 0.0], [10.0, 0.0]])
    assert clearance(path, Worlds.single([(4.9, 0.5, 5.1, 2.0)])) == 0.5
    assert clearance(path, Worlds.single([(4.9, -0.5, 5.1, 2.0)])) == 0.0
    assert clearance(path, Worlds.single()) == math.inf


def test_clearance_takes_the_nearer_of_boxes_and_grid_of_ones_own_world() -> None:
    blocked = np.zeros((8, 8), np.uint8)
    blocked[6, 2] = 1
    worlds = Worlds(
        boxes=np.array([[2.0, 1.5, 3.0, 1.75], [2.0, 0.5, 3.0, 0.75]]),
        offsets=np.array([0, 1, 2]),
        bounds=np.array([[0.0, 0, 4, 4]] * 2),
        of=np.array([1, 0]),
        grid=Grid(frame=Frame(cell=0.5, shape=(8, 8)), blocked=blocked),
    )
    path = np.array([[0.0, 2.0], [4.0, 2.0]])
    assert clearance(path, worlds, 0) == pytest.approx(1.0, abs=1e-12)
    assert clearance(path, worlds, 1) == pytest.approx(0.25, abs=1e-12)


def test_the_length_of_a_path() -> None:
    assert path_length(np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 4.0], [3.0, 3.0]])) == 6.0
    assert path_length(np.array([[5.0, 5.0]])) == 0.0
