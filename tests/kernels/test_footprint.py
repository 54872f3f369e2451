"""Footprints against obstacles, at rest and on the move: shapely decides."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
import shapely
from shapely import affinity
from shapely.geometry import MultiPoint, Point, Polygon, box

from rovernav.core import Frame
from rovernav.kernels import footprint as k
from rovernav.sim import Grid, Shape, Worlds

RECTANGLE = (-0.9, 0.7, -0.4, 0.5)
CLOSE = 1e-9
"""Gaps and overlaps smaller than this may be decided either way [m]."""


def rectangle_at(pose: Any, rectangle: Any = RECTANGLE) -> Polygon:
    rear, front, right, left = rectangle
    turned = affinity.rotate(box(rear, right, front, left), pose[2], (0, 0), use_radians=True)
    return affinity.translate(turned, pose[0], pose[1])


def hull_at(a: Any, b: Any | None = None) -> tuple[Any, int]:
    hull = np.empty((24, 2))
    first: Any = tuple(map(float, a))
    last: Any = first if b is None else tuple(map(float, b))
    return hull, k.hull_of(first, last, RECTANGLE, hull)


def compare(poses: Any, met: Any, others: Any) -> int:
    """Check what was met against shapely; returns how many touched."""
    touched = 0
    for pose, got, other in zip(poses, met, others, strict=True):
        mine = rectangle_at(pose)
        gap = mine.distance(other)
        deep = mine.intersection(other).area if gap == 0.0 else 0.0
        if gap > CLOSE:
            assert not got, (pose, gap)
        elif deep > CLOSE:
            assert got, (pose, deep)
            touched += 1
    return touched


def some_poses(rng: np.random.Generator, count: int) -> Any:
    return np.column_stack([rng.uniform(-2, 2, (count, 2)), rng.uniform(-math.pi, math.pi, count)])


def test_boxes_at_rest() -> None:
    rng = np.random.default_rng(0)
    poses = some_poses(rng, 3000)
    low = rng.uniform(-1.5, 1.0, (3000, 2))
    ends = np.concatenate([low, low + rng.uniform(0.01, 1.5, (3000, 2))], axis=1)
    met = [k.meets_box(*hull_at(p), *map(float, e)) for p, e in zip(poses, ends, strict=True)]
    assert 600 < compare(poses, met, [box(*e) for e in ends]) < 2500


def test_discs_at_rest() -> None:
    rng = np.random.default_rng(1)
    poses, at, r = some_poses(rng, 3000), rng.uniform(-1, 1, (3000, 2)), rng.uniform(0, 1, 3000)
    touched = 0
    for pose, (x, y), radius in zip(poses, at.tolist(), r.tolist(), strict=True):
        hull, m = hull_at(pose)
        got = k.meets_disc(hull, m, x, y, radius)
        gap = rectangle_at(pose).distance(Point(x, y)) - radius
        if abs(gap) > CLOSE:
            assert got == (gap < 0.0)
        assert got == k.meets_shape(hull, m, np.array([[x, y]]), radius) or abs(gap) < CLOSE
        touched += got
    assert 800 < touched < 2500


def star(rng: np.random.Generator) -> Any:
    """A polygon that is not convex, around a point."""
    turn = np.sort(rng.uniform(0, 2 * math.pi, 7))
    far = rng.uniform(0.15, 1.2, 7)
    corners = np.stack([far * np.cos(turn), far * np.sin(turn)], axis=1)
    return corners + rng.uniform(-1.2, 1.2, 2)


def test_polygons_at_rest() -> None:
    rng = np.random.default_rng(2)
    poses = some_poses(rng, 3000)
    stars = [star(rng) for _ in poses]
    met = [k.meets_shape(*hull_at(p), s, 0.0) for p, s in zip(poses, stars, strict=True)]
    assert 800 < compare(poses, met, [shapely.make_valid(Polygon(s)) for s in stars]) < 2500


def test_cells_at_rest() -> None:
    rng = np.random.default_rng(3)
    blocked = (rng.random((20, 20)) < 0.03).astype(np.uint8)
    cells = shapely.union_all(
        [box(j * 0.25, i * 0.25, (j + 1) * 0.25, (i + 1) * 0.25) for i, j in np.argwhere(blocked)]
    )
    poses = some_poses(rng, 1500) + np.array([2.5, 2.5, 0.0])
    worlds = Worlds.single(grid=Grid(frame=Frame(cell=0.25, shape=(20, 20)), blocked=blocked))
    met = [k.meets_world(*hull_at(p), 0, worlds.arrays(), True, 0.0) for p in poses]
    assert 300 < compare(poses, met, [cells] * 1500) < 1400
    hull, m = hull_at(poses[int(np.argmax(met))])
    assert not k.meets_world(hull, m, 0, worlds.arrays(), False, 0.0)


@pytest.mark.parametrize("turning", [False, True])
def test_what_a_moving_footprint_sweeps(turning: bool) -> None:
    """Nothing swept is missed, and nothing farther off than the bulge is called touched."""
    rng = np.random.default_rng(4 + turning)
    touched = 0
    for _ in range(1000):
        start = some_poses(rng, 1)[0]
        step = rng.uniform(-1, 1, 3) * (1.5, 0.5 if turning else 0.3, 1.5 if turning else 0.0)
        disc = Point(*rng.uniform(-1.5, 1.5, 2)).buffer(0.3, quad_segs=32)
        corners = np.array(disc.exterior.coords[:-1])
        bulge, blur = k.spread_of(step, math.hypot(0.9, 0.5))
        parts = 1
        while blur / parts + 2.0 * bulge / parts**2 > 1e-3:
            parts += 1
        bulge /= parts**2
        assert turning or (parts == 1 and bulge == 0.0)
        at = [k.along_arc(start, step, i / parts) for i in range(parts + 1)]
        got = any(k.meets_shape(*hull_at(a, b), corners, bulge) for a, b in itertools.pairwise(at))
        passed = [k.along_arc(start, step, t) for t in np.linspace(0, 1, 40)]
        swept = [rectangle_at(p) for p in passed]
        near = min(s.distance(disc) for s in swept)
        if near == 0.0 and max(s.intersection(disc).area for s in swept) > CLOSE:
            assert got
            touched += 1
        if near > 2e-3 and turning:  # forty poses leave gaps of their own: below 1 mm
            hulls = [
                MultiPoint([*a.exterior.coords, *b.exterior.coords]).convex_hull
                for a, b in itertools.pairwise(swept)
            ]
            if min(h.distance(disc) for h in hulls) > 2e-3:
                assert not got
        if not turning:
            both = MultiPoint([*swept[0].exterior.coords, *swept[-1].exterior.coords]).convex_hull
            gap = both.distance(disc)
            assert got == (gap == 0.0) or gap < CLOSE
    assert 150 < touched < 900


def test_hulls_are_those_of_shapely() -> None:
    rng = np.random.default_rng(6)
    for _ in range(500):
        a, b = some_poses(rng, 2)
        hull, m = hull_at(a, b)
        both = MultiPoint(
            [*rectangle_at(a).exterior.coords, *rectangle_at(b).exterior.coords]
        ).convex_hull
        assert Polygon(hull[:m]).area == pytest.approx(both.area, rel=1e-12)
        assert Polygon(hull[:m]).exterior.is_ccw


def test_a_world_is_seen_with_all_its_obstacles() -> None:
    hull, m = hull_at((0.0, 0.0, 0.3))
    for worlds in (
        Worlds.single([(0.2, 0.2, 9.0, 9.0)]),
        Worlds.single(shapes=[Shape.disc(0.0, 0.9, 0.45)]),
        Worlds.single(shapes=[Shape.polygon([(-0.1, -0.1), (0.1, -0.1), (0.0, 0.1)])]),
    ):
        assert k.meets_world(hull, m, 0, worlds.arrays(), True, 0.0)
    far = Worlds.single([(2, 2, 3, 3)], shapes=[Shape.disc(0.0, 0.98, 0.3)])
    assert not k.meets_world(hull, m, 0, far.arrays(), True, 0.0)
