from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.kernels import drive, geometry
from rovernav.kernels import shapes as k
from tests.naive import shapes as naive

pytestmark = pytest.mark.kernels

SQUARE = np.array([[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]])
SAMPLES = 400


def random_shape(rng: np.random.Generator) -> tuple[np.ndarray, float]:
    corners = rng.uniform(-3, 3, (int(rng.integers(1, 7)), 2))
    radius = float(rng.choice([0.0, 0.2, 1.0]))
    return corners, radius if len(corners) > 1 else max(radius, 0.1)


def test_contact_is_where_dense_samples_find_it(rng: np.random.Generator) -> None:
    met = 0
    for _ in range(150):
        corners, radius = random_shape(rng)
        (ax, ay), (bx, by) = rng.uniform(-5, 5, (2, 2)).tolist()
        got = k.first_shape(ax, ay, bx, by, corners, radius)
        there = naive.first((ax, ay), (bx, by), corners.tolist(), radius, samples=SAMPLES)
        if there <= 1.0:  # samples can only be late, or miss a graze
            met += 1
            assert got <= there
        if got <= 1.0:
            p = (ax + got * (bx - ax), ay + got * (by - ay))
            assert naive.distance(p, corners.tolist()) == pytest.approx(radius, abs=1e-9) or (
                got == 0.0
            )
        for share in (0.25, 0.5, 0.99):  # nothing is met before it
            t = share * min(got, 1.0)
            if got > 0.0:
                p = (ax + t * (bx - ax), ay + t * (by - ay))
                assert naive.distance(p, corners.tolist()) > radius - 1e-12
    assert met > 40


def test_boxes_are_met_as_polygons_where_they_are_met_as_boxes(rng: np.random.Generator) -> None:
    for _ in range(2000):
        x0, y0 = rng.integers(-3, 3, 2)
        x1, y1 = x0 + rng.integers(0, 4), y0 + rng.integers(0, 4)
        box = np.array([x0, y0, x1, y1], dtype=float)
        corners = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], dtype=float)
        ax, ay, bx, by = (rng.integers(-16, 16, 4) / 4).tolist()
        assert_allclose(
            k.first_shape(ax, ay, bx, by, corners, 0.0),
            geometry.first_box(ax, ay, bx, by, box),
            rtol=0,
            atol=1e-12,
        )
        assert_allclose(
            k.segment_shape(ax, ay, bx, by, corners, 0.0),
            geometry.segment_box(ax, ay, bx, by, box),
            rtol=0,
            atol=1e-12,
        )


def test_a_segment_meets_the_same_from_either_end(rng: np.random.Generator) -> None:
    for _ in range(1000):
        corners = rng.integers(-8, 8, (5, 2)) / 2
        ax, ay, bx, by = (rng.integers(-10, 10, 4) / 2).tolist()
        one = k.first_shape(ax, ay, bx, by, corners, 0.0) <= 1.0
        assert one == (k.first_shape(bx, by, ax, ay, corners, 0.0) <= 1.0)


@pytest.mark.parametrize(
    ("ends", "radius", "t"),
    [
        ((0, 0, 1, 1), 0.0, 1.0),  # touches a corner
        ((0, 1, 3, 1), 0.0, 1 / 3),  # along a side
        ((1.5, 1.5, 1.5, 1.5), 0.0, 0.0),  # a point inside
        ((1.2, 1.8, 9, 9), 0.0, 0.0),  # begins inside
        ((2, 2, 3, 3), 0.0, 0.0),
        ((0, 0.999, 3, 0.999), 0.0, geometry.MISS),
        ((0, 0.5, 3, 0.5), 0.5, 1 / 3),  # grazes the grown side: closed
        ((0, 0.499, 3, 0.499), 0.5, geometry.MISS),
        ((0, 1.5, 1, 1.5), 0.25, 0.75),
        ((math.nan, 0, 1, 1), 0.0, geometry.MISS),
        ((0, 0, math.inf, 1), 0.0, geometry.MISS),
    ],
)
def test_touching_counts(ends: tuple[float, ...], radius: float, t: float) -> None:
    ax, ay, bx, by = map(float, ends)
    assert k.first_shape(ax, ay, bx, by, SQUARE, radius) == pytest.approx(t, abs=1e-12)


def test_a_disc_is_one_corner_with_a_radius() -> None:
    disc = np.array([[3.0, 0.0]])
    assert k.first_shape(0.0, 0.0, 4.0, 0.0, disc, 1.0) == pytest.approx(0.5, abs=1e-15)
    assert k.first_shape(0.0, 1.0, 6.0, 1.0, disc, 1.0) == pytest.approx(0.5, abs=1e-7)  # a tangent
    assert k.first_shape(0.0, 1.0 + 1e-9, 6.0, 1.0 + 1e-9, disc, 1.0) == geometry.MISS
    assert k.segment_shape(0.0, 0.0, 1.0, 0.0, disc, 1.0) == pytest.approx(1.0, abs=1e-15)
    assert k.first_shape(3.0, 0.0, 3.0, 0.0, disc, 0.0) == 0.0
    assert k.first_shape(0.0, 0.0, 1.0, 0.0, np.empty((0, 2)), 0.0) == geometry.MISS


def test_a_star_with_crossing_sides_has_a_hole() -> None:
    turns = 2 * math.pi * np.arange(5) * 2 / 5
    star = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    assert not k.inside(0.0, 0.0, star)
    assert k.inside(0.8, 0.0, star)


def test_distances_are_those_of_dense_samples(rng: np.random.Generator) -> None:
    for _ in range(60):
        corners, radius = random_shape(rng)
        a, b = rng.uniform(-5, 5, (2, 2))
        got = k.segment_shape(a[0], a[1], b[0], b[1], corners, radius)
        ways = [a + t * (b - a) for t in np.linspace(0, 1, 201)]
        there = min(max(0.0, naive.distance(p.tolist(), corners.tolist()) - radius) for p in ways)
        assert got == pytest.approx(there, abs=math.dist(a, b) / 400 + 1e-9)
        assert got <= there + 1e-12


def test_each_rover_meets_the_shapes_of_its_own_world() -> None:
    world = drive.WorldArrays(
        boxes=np.zeros((0, 4)),
        offsets=np.zeros(4, np.int64),
        of=np.array([2, 0, 1, 2]),
        blocked=np.zeros((0, 0, 0), np.uint8),
        cell=1.0,
        corners=np.concatenate([SQUARE, [[5.0, 1.5]], SQUARE + np.array([2.0, 0.0])]),
        ends=np.array([0, 4, 5, 9]),
        radius=np.array([0.0, 0.5, 0.0]),
        shapes=np.array([0, 1, 1, 3]),
    )
    before = np.tile([0.0, 1.5, 0.0], (4, 1))
    after = np.tile([10.0, 1.5, 0.0], (4, 1))
    ways = enumerate(zip(before, after, strict=True))
    out = [drive.first_contact(k, a[0], a[1], b[0], b[1], world) for k, (a, b) in ways]
    assert_allclose(out, [0.3, 0.1, geometry.MISS, 0.3], rtol=0, atol=1e-15)
