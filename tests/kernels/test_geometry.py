from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from rovernav.kernels import geometry as k
from tests.naive import geometry as naive

Segment = tuple[tuple[float, float], tuple[float, float]]
H, W = 7, 9
FAMILIES = ("lattice", "quarters", "corner", "axis", "far", "decimal", "free")
EXACT = ("lattice", "quarters", "corner", "far")
"""Families whose sums and products have no rounding, so that hit or miss must be exact."""


def segments(family: str, count: int) -> Iterator[Segment]:
    rng = np.random.default_rng(FAMILIES.index(family))
    for _ in range(count):
        a, b = draw(family, rng), draw(family, rng)
        if family == "corner":  # through a corner, further on by any share of the way
            corner = np.array([rng.integers(0, W + 1), rng.integers(0, H + 1)])
            way = rng.integers(-24, 25, 2) / 8
            a, b = corner - way * rng.integers(0, 4), corner + way * rng.integers(0, 4)
        elif family == "axis":
            axis = rng.integers(2)
            b[axis] = a[axis]
        elif family == "far":
            a = a * 2.0 ** rng.integers(0, 30)
        if rng.random() < 0.05:
            b = a
        yield (float(a[0]), float(a[1])), (float(b[0]), float(b[1]))


def draw(family: str, rng: np.random.Generator) -> np.ndarray:
    low, high = np.array([-3, -3]), np.array([W + 3, H + 3])
    if family == "lattice" or (family == "axis" and rng.random() < 0.5):
        return rng.integers(low, high).astype(float)
    if family in ("quarters", "far"):
        return rng.integers(4 * low, 4 * high) / 4
    if family == "decimal":
        return rng.integers(10 * low, 10 * high) / 10
    return rng.uniform(low, high)


def grid(rng: np.random.Generator) -> np.ndarray:
    return (rng.random((H, W)) < rng.choice([0.02, 0.15])).astype(np.uint8)


def grown(box: naive.Box, by: float) -> naive.Box:
    return (box[0] - by, box[1] - by, box[2] + by, box[3] + by)


def near_miss(segment: Segment, boxes: list[naive.Box]) -> bool:
    """Whether the segment passes one of the boxes within a few roundings."""
    slack = 1e-14 * max(1.0, *map(abs, (*segment[0], *segment[1])))
    return any(naive.first_box(*segment, grown(box, slack)) is not None for box in boxes)


def judge(got: float, exact: object, segment: Segment, boxes: list[naive.Box], sure: bool) -> None:
    if exact is not None:
        assert abs(got - exact) < 1e-9, (segment, boxes)  # type: ignore[operator]
    elif got != k.MISS:
        assert 0.0 <= got <= 1.0
        assert not sure, (segment, boxes)
        assert near_miss(segment, boxes), (segment, boxes)


@pytest.mark.kernels
@pytest.mark.parametrize("family", FAMILIES)
def test_boxes_are_met_where_exact_arithmetic_meets_them(family: str) -> None:
    rng = np.random.default_rng(1)
    for segment in segments(family, 700):
        low = rng.integers((0, 0), (W, H))
        box = np.array([*low, *(low + rng.integers(0, 4, 2))], dtype=float)
        got = k.first_box(*segment[0], *segment[1], box)
        exact = naive.first_box(*segment, box)
        judge(got, exact, segment, [box.tolist()], family in EXACT)


@pytest.mark.kernels
@pytest.mark.parametrize("family", FAMILIES)
def test_cells_are_met_where_exact_arithmetic_meets_them(family: str) -> None:
    rng = np.random.default_rng(2)
    for number, segment in enumerate(segments(family, 500)):
        if number % 10 == 0:
            blocked = grid(rng)
        got = k.first_cell(*segment[0], *segment[1], blocked)
        exact = naive.first_cell(*segment, blocked)
        judge(got, exact, segment, list(naive.cells(blocked)), family in EXACT)


@pytest.mark.kernels
@pytest.mark.parametrize("family", FAMILIES)
def test_a_segment_meets_the_same_from_either_end(family: str) -> None:
    rng = np.random.default_rng(3)
    for number, (a, b) in enumerate(segments(family, 1000)):
        if number % 10 == 0:
            blocked = grid(rng)
            box = np.sort(rng.uniform(0, 6, (2, 2)), axis=0).ravel()
        assert (k.first_box(*a, *b, box) <= 1) == (k.first_box(*b, *a, box) <= 1), (a, b, box)
        assert (k.first_cell(*a, *b, blocked) <= 1) == (k.first_cell(*b, *a, blocked) <= 1), (a, b)


@pytest.mark.kernels
@pytest.mark.parametrize("far", [1, 3, 6])
@pytest.mark.parametrize("turn", [1, -1])
def test_a_long_walk_still_sees_the_cells_beside_a_corner(far: int, turn: int) -> None:
    a, b = (0.0, 0.0), (9996.0, 7.0)  # through the corners (1428 i, i)
    for row, column in ((far - 1, 1428 * far), (far, 1428 * far - 1)):
        blocked = np.zeros((8, 9997), np.uint8)
        blocked[row, column] = 1
        t = k.first_cell(*a, *b, blocked) if turn == 1 else k.first_cell(*b, *a, blocked)
        assert t == pytest.approx(far / 7 if turn == 1 else 1 - far / 7, abs=1e-12)
