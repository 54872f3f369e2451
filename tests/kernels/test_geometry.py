from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from rovernav.kernels import geometry as k
from tests.naive import geometry as naive

pytestmark = pytest.mark.kernels

Point = tuple[float, float]
Segment = tuple[Point, Point]
H, W = 7, 9
FAMILIES = ("lattice", "quarters", "corner", "axis", "far", "decimal", "free")
EXACT = ("lattice", "quarters", "corner", "far")
"""Families whose sums and products have no rounding, so that hit or miss must be exact."""


def segments(family: str, count: int) -> Iterator[Segment]:
    """Seeded segments on and around a grid of H rows and W columns; some have no length."""
    rng = np.random.default_rng(FAMILIES.index(family))
    for _ in range(count):
        a, b = draw(family, rng), draw(family, rng)
        if family == "corner":
            corner = rng.integers((0, 0), (W + 1, H + 1))
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


def grid(rng: np.random.Generator, shape: tuple[int, int] = (H, W)) -> np.ndarray:
    return (rng.random(shape) < rng.choice([0.02, 0.15])).astype(np.uint8)


def judge(got: float, exact: Fraction | None, segment: Segment, boxes: list[naive.Box]) -> None:
    """What is there must be met where it is; nothing else, but for what is grazed by a rounding."""
    if exact is not None:
        assert abs(got - exact) < 1e-9, (segment, boxes)
    elif got != k.MISS:
        slack = 1e-14 * max(1.0, *map(abs, (*segment[0], *segment[1])))
        grown = [(x0 - slack, y0 - slack, x1 + slack, y1 + slack) for x0, y0, x1, y1 in boxes]
        assert any(naive.first_box(*segment, box) is not None for box in grown), (segment, boxes)


@pytest.mark.parametrize("family", FAMILIES)
def test_boxes_are_met_where_exact_arithmetic_meets_them(family: str) -> None:
    rng = np.random.default_rng(1)
    for segment in segments(family, 1000):
        low = rng.integers((0, 0), (W, H))
        box = np.array([*low, *(low + rng.integers(0, 4, 2))], dtype=float)
        got = k.first_box(*segment[0], *segment[1], box)
        exact = naive.first_box(*segment, box.tolist())
        judge(got, exact, segment, [box.tolist()])
        assert family not in EXACT or (got != k.MISS) == (exact is not None), (segment, box)


@pytest.mark.parametrize("family", FAMILIES)
def test_cells_are_met_where_exact_arithmetic_meets_them(family: str) -> None:
    rng = np.random.default_rng(2)
    for number, segment in enumerate(segments(family, 600)):
        if number % 10 == 0:
            blocked = grid(rng)
        got = k.first_cell(*segment[0], *segment[1], blocked)
        exact = naive.first_cell(*segment, blocked)
        judge(got, exact, segment, list(naive.cells(blocked)))
        assert family not in EXACT or (got != k.MISS) == (exact is not None), (segment, blocked)


@pytest.mark.parametrize("family", FAMILIES)
def test_a_segment_meets_the_same_from_either_end(family: str) -> None:
    rng = np.random.default_rng(3)
    for number, (a, b) in enumerate(segments(family, 1000)):
        if number % 10 == 0:
            blocked = grid(rng)
            box = np.sort(rng.uniform(0, 6, (2, 2)), axis=0).ravel()
        assert (k.first_box(*a, *b, box) <= 1) == (k.first_box(*b, *a, box) <= 1), (a, b, box)
        assert (k.first_cell(*a, *b, blocked) <= 1) == (k.first_cell(*b, *a, blocked) <= 1), (a, b)


def through_a_corner(rng: np.random.Generator) -> tuple[Point, Point, Point]:
    """Ends of a segment and a corner exactly on it, too fine for their differences to be floats."""
    odd, way = 2 * rng.integers(2**18, 2**19) + 1, rng.integers(2**41, 2**42, 2)
    corner = (odd * way >> 10) + rng.integers(-(2**41), 2**41, 2)
    a, b = 2**10 * corner - odd * way, corner + 2**9 * way
    ends = np.ldexp(a, -62), np.ldexp(b, -52), np.ldexp(corner, -52)
    return tuple((float(x), float(y)) for x, y in ends)  # type: ignore[return-value]


def test_a_corner_on_the_line_is_touched_and_one_beside_it_is_not() -> None:
    rng = np.random.default_rng(7)
    for _ in range(1000):
        a, b, (x, y) = through_a_corner(rng)
        touching, beside = (x, y - 1.0, x + 1.0, y), (x + 1e-11, y - 1.0, x + 1.0, y - 1e-11)
        assert naive.first_box(a, b, touching) is not None
        assert k.first_box(*a, *b, touching) <= 1.0, (a, b)
        assert k.first_box(*b, *a, touching) <= 1.0, (a, b)
        assert k.first_box(*a, *b, beside) == k.MISS, (a, b)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("far", [1, 3, 6])
def test_a_long_walk_still_sees_the_cells_beside_a_corner(far: int, turned: bool) -> None:
    ends = ((0.0, 0.0), (9996.0, 7.0))  # through the corners (1428 i, i)
    for row, column in ((far - 1, 1428 * far), (far, 1428 * far - 1)):
        blocked = np.zeros((8, 9997), np.uint8)
        blocked[row, column] = 1
        a, b = ends[::-1] if turned else ends
        t = k.first_cell(*a, *b, blocked)
        assert t == pytest.approx(1 - far / 7 if turned else far / 7, abs=1e-12)


def test_a_walk_meets_what_dense_samples_meet() -> None:
    rng = np.random.default_rng(4)
    t = np.linspace(0.0, 1.0, 4001)
    for _ in range(150):
        blocked = grid(rng, (60, 80))
        ends = rng.uniform((-9, -9), (89, 69), (2, 2))
        a, b = ends
        x, y = (a + t[:, None] * (b - a)).T
        rows, columns = np.floor(y).astype(int), np.floor(x).astype(int)
        inside = (rows >= 0) & (rows < 60) & (columns >= 0) & (columns < 80)
        met = np.zeros(len(t), bool)
        met[inside] = blocked[rows[inside], columns[inside]] != 0
        ax, ay, bx, by = ends.ravel().tolist()
        got = k.first_cell(ax, ay, bx, by, blocked)
        if met.any():
            assert got <= t[met.argmax()]
        if got != k.MISS:
            p = a + got * (b - a)
            near = [cell for cell in naive.cells(blocked) if math.dist(cell[:2], p) < 2]
            assert min(naive.segment_box(p, p, cell) for cell in near) < 1e-12


ODD = (
    0.0,
    -0.0,
    4.0,
    4.5,
    -3.0,
    5e-324,
    1e-300,
    1e18,
    -1e100,
    1e308,
    math.inf,
    -math.inf,
    math.nan,
)


def test_no_coordinate_makes_a_walk_hang_or_read_beyond_the_grid() -> None:
    blocked, full = np.zeros((5, 6), np.uint8), np.ones((5, 6), np.uint8)
    box = np.array([0.0, 0.0, 6.0, 5.0])
    for ax in ODD:
        for ay in ODD:
            for bx in ODD:
                for by in ODD[::2]:
                    ends = (ax, ay, bx, by)
                    assert k.first_cell(*ends, blocked) == k.MISS
                    in_box, in_cells = k.first_box(*ends, box), k.first_cell(*ends, full)
                    if not all(map(math.isfinite, ends)):
                        assert in_box == in_cells == k.MISS
                    elif max(map(abs, ends)) <= 1e100:
                        assert in_cells == pytest.approx(in_box, abs=1e-12), ends


@pytest.mark.parametrize("shape", [(0, 0), (0, 3), (3, 0), (1, 1)])
def test_smallest_grids(shape: tuple[int, int]) -> None:
    t = k.first_cell(-1.0, 0.5, 3.0, 0.5, np.ones(shape, np.uint8))
    assert t == (0.25 if shape == (1, 1) else k.MISS)


def test_touching_counts_and_read_only_grids_will_do() -> None:
    blocked = np.zeros((3, 3), np.uint8)
    blocked[1, 1] = 1
    blocked.flags.writeable = False
    box = np.array([1.0, 1.0, 2.0, 2.0])
    for ends, t in (
        ((0, 0, 1, 1), 1.0),  # the end touches a corner
        ((0, 2, 3, 2), 1 / 3),  # along the upper edge
        ((2, 5, 2, 0), 0.6),  # along the right edge, downwards
        ((0, 3, 3, 0), 1 / 3),  # through two corners
        ((0, 2, 2, 0), 0.5),  # only the corner (1, 1) is touched
        ((2, 2, 9, 9), 0.0),  # begins on a corner
        ((1.5, 1.5, 1.5, 1.5), 0.0),  # a point inside
        ((2, 1.5, 2, 1.5), 0.0),  # a point on an edge
        ((0, 1, 0.999, 1), k.MISS),
        ((0, 2.001, 3, 2.001), k.MISS),
        ((2.001, 1.5, 2.001, 1.5), k.MISS),
        ((0, 1.999, 1.999, 0), k.MISS),
    ):
        ax, ay, bx, by = map(float, ends)
        assert k.first_box(ax, ay, bx, by, box) == pytest.approx(t, abs=1e-15), ends
        assert k.first_cell(ax, ay, bx, by, blocked) == pytest.approx(t, abs=1e-15), ends


@pytest.mark.parametrize("family", ["quarters", "axis", "free"])
def test_distances_are_exact(family: str) -> None:
    rng = np.random.default_rng(5)
    for a, b in segments(family, 200):
        p = (rng.uniform(-3, 9), rng.uniform(-3, 9))
        box = np.sort(rng.uniform(0, 6, (2, 2)), axis=0).ravel()
        point = k.segment_point(*a, *b, *p)
        assert_allclose(point, naive.segment_point(a, b, p), rtol=0, atol=1e-13)
        gap = k.segment_box(*a, *b, box)
        assert_allclose(gap, naive.segment_box(a, b, box.tolist()), rtol=0, atol=1e-13)
        x, y = (np.array(a) + np.linspace(0, 1, 3001)[:, None] * np.subtract(b, a)).T
        dx = np.maximum(0, np.maximum(box[0] - x, x - box[2]))
        dy = np.maximum(0, np.maximum(box[1] - y, y - box[3]))
        assert_allclose(gap, np.hypot(dx, dy).min(), rtol=0, atol=math.dist(a, b) / 6000 + 1e-12)
        assert_allclose(point, np.hypot(x - p[0], y - p[1]).min(), rtol=0, atol=0.004)


quarter = st.integers(-20, 60).map(lambda n: n / 4)
place = st.tuples(quarter, quarter)


@settings(max_examples=60)
@given(a=place, b=place, shift=st.tuples(st.integers(-99, 99), st.integers(-99, 99)))
def test_shifting_or_turning_everything_changes_nothing(
    a: Point, b: Point, shift: tuple[int, int]
) -> None:
    blocked = grid(np.random.default_rng(abs(shift[0])), (12, 10))
    box = (2.25, 3.0, 5.5, 8.75)
    dx, dy = shift
    moved = tuple(np.add(box, (dx, dy, dx, dy)))
    turned = (-box[3], box[0], -box[1], box[2])  # a quarter turn counter-clockwise
    turned_grid = np.ascontiguousarray(blocked[::-1].T)  # turned, then moved right by 12 columns
    (ax, ay), (bx, by) = a, b
    for measure in (k.first_box, k.segment_box):
        here = measure(ax, ay, bx, by, box)
        there = measure(ax + dx, ay + dy, bx + dx, by + dy, moved)
        assert_allclose(there, here, rtol=0, atol=1e-12)
        assert_allclose(measure(-ay, ax, -by, bx, turned), here, rtol=0, atol=1e-12)
    assert_allclose(
        k.first_cell(12 - ay, ax, 12 - by, bx, turned_grid),
        k.first_cell(ax, ay, bx, by, blocked),
        rtol=0,
        atol=1e-12,
    )


def test_first_boxes_takes_the_nearest_of_its_own() -> None:
    boxes = np.array([[8.0, -1, 9, 1], [4, -1, 5, 1], [6, -1, 7, 1], [1, -1, 2, 1]])
    assert k.first_boxes(0.0, 0.0, 10.0, 0.0, boxes, 0, 4) == 0.1
    assert k.first_boxes(0.0, 0.0, 10.0, 0.0, boxes, 0, 3) == 0.4
    assert k.first_boxes(0.0, 0.0, 10.0, 0.0, boxes, 2, 3) == 0.6
    assert k.first_boxes(0.0, 0.0, 10.0, 0.0, boxes, 2, 2) == k.MISS


def test_the_closest_cell_is_the_closest_of_all() -> None:
    rng = np.random.default_rng(6)
    for _ in range(20):
        blocked = grid(rng)
        points = rng.uniform((-3, -3), (W + 3, H + 3), (4, 2))
        segments = np.concatenate([points[:-1], points[1:]], axis=1)
        gaps = np.array(
            [
                min(
                    (naive.segment_box(a, b, cell) for cell in naive.cells(blocked)),
                    default=math.inf,
                )
                for a, b in pairwise(points)
            ]
        )
        order = np.argsort(gaps)
        least = np.maximum(gaps[order] - rng.uniform(0.0, 0.5, 3), 0.0)
        least = np.minimum.accumulate(least[::-1])[::-1]  # rising, and never above the truth
        got = k.closest_cell(segments[order], blocked, np.full(3, 30.0), least)
        assert_allclose(got, gaps.min(), rtol=0, atol=1e-12)
