from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from shapely import Point, Polygon, unary_union

from rovernav.core import Frame, ShapeError
from rovernav.kernels import drive
from rovernav.sim import Grid, Ground, Rocks, Shape, Shapes, Worlds

GRID = Grid(frame=Frame(cell=0.5, shape=(4, 6)), blocked=np.zeros((4, 6), np.uint8))


def parts(**changes: Any) -> dict[str, Any]:
    """Two worlds, with one box and with two, and three rovers."""
    good = {
        "boxes": np.array([[0.0, 0, 1, 1], [2, 2, 3, 3], [4, 4, 5, 6]]),
        "offsets": np.array([0, 1, 3]),
        "bounds": np.array([[-9.0, -9, 9, 9], [-8, -8, 8, 8]]),
        "of": np.array([1, 0, 1]),
    }
    return {**good, **changes}


def test_a_row_is_the_world_of_that_rover() -> None:
    worlds = Worlds(**parts(), grid=GRID)
    for k, boxes in ((0, worlds.boxes[1:]), (1, worlds.boxes[:1]), (2, worlds.boxes[1:])):
        row = worlds.row(k)
        assert_array_equal(row.boxes, boxes)
        assert_array_equal(row.offsets, [0, len(boxes)])
        assert_array_equal(row.bounds, worlds.bounds[[worlds.of[k]]])
        assert_array_equal(row.of, [0])
        assert row.grid is GRID


def test_worlds_may_have_ground_and_rocks_of_their_own() -> None:
    frame = Frame(cell=0.5, shape=(4, 6))
    blocked = np.zeros((2, 4, 6), np.uint8)
    blocked[1, 2, 3] = 1
    heights = np.arange(48, dtype=np.float32).reshape(2, 4, 6)
    rocks = np.array([[1.0, 1, 0.2, 0.1], [2, 1, 0.3, 0.4], [1, 2, 0.1, 0.1]])
    worlds = Worlds(
        **parts(),
        grid=Grid(frame=frame, blocked=blocked),
        ground=Ground(frame=frame, height=heights, offset=7.0),
        rocks=Rocks(place=rocks, offsets=np.array([0, 1, 3])),
    )
    for k, i in enumerate(worlds.of):
        row = worlds.row(k)
        assert row.grid is not None
        assert row.ground is not None
        assert row.rocks is not None
        assert_array_equal(row.grid.blocked, blocked[i])
        assert_array_equal(row.ground.height, heights[i])
        assert row.ground.offset == 7.0
        assert_array_equal(row.rocks.place, rocks[:1] if i == 0 else rocks[1:])
        assert_array_equal(row.rocks.offsets, [0, len(row.rocks.place)])
    arrays, at = worlds.arrays(), (1.75, 1.25)
    hit = [drive.first_contact(k, *at, *at, arrays) <= 1.0 for k in range(3)]
    assert_array_equal(hit, worlds.of == 1)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"grid": (3, 4, 6)}, r"2 worlds need one grid for all or one for each, got \(3, 4, 6\)"),
        ({"ground": (1, 4, 6)}, "2 worlds need one ground for all or one for each"),
        ({"rocks": [0, 0]}, "2 worlds need the rocks of each, got 1"),
    ],
)
def test_layers_are_those_of_the_worlds(change: dict[str, Any], message: str) -> None:
    frame = Frame(cell=0.5, shape=(4, 6))
    made: dict[str, Any] = {
        "grid": lambda shape: Grid(frame=frame, blocked=np.zeros(shape, np.uint8)),
        "ground": lambda shape: Ground(frame=frame, height=np.zeros(shape, np.float32)),
        "rocks": lambda ends: Rocks(place=np.empty((0, 4)), offsets=np.array(ends)),
    }
    given = {name: made[name](size) for name, size in change.items()}
    with pytest.raises(ShapeError, match=message):
        Worlds(**parts(), **given)


@pytest.mark.parametrize(
    ("place", "message"),
    [
        ([[0.0, 0, 1]], "rocks need finite x, y, radius, height"),
        ([[0.0, 0, 1, np.nan]], "rocks need finite"),
        ([[0.0, 0, 0, 1]], "a radius and a height above 0 m"),
    ],
)
def test_rocks_are_checked(place: list[list[float]], message: str) -> None:
    with pytest.raises(ShapeError, match=message):
        Rocks(place=np.array(place), offsets=np.array([0, len(place)]))


def test_ground_is_short_floats_of_its_frame() -> None:
    with pytest.raises(ShapeError, match="ground needs float32 heights of shape"):
        Ground(frame=Frame(cell=0.5, shape=(4, 6)), height=np.zeros((4, 6)))  # type: ignore[arg-type]


def test_one_world_for_many_rovers() -> None:
    worlds = Worlds.single([(0, 0, 1, 1)], rovers=3)
    assert_array_equal(worlds.of, [0, 0, 0])
    assert_array_equal(worlds.bounds, [[-np.inf, -np.inf, np.inf, np.inf]])
    assert_array_equal(Worlds.single(grid=GRID).bounds, [[0, 0, 3, 2]])
    assert_array_equal(Worlds.single(grid=GRID, bounds=(1, 1, 2, 2)).bounds, [[1, 1, 2, 2]])


def test_one_box_in_each_of_many_worlds() -> None:
    boxes = np.array([[0.0, 0, 1, 1], [2, 2, 3, 3]])
    worlds = Worlds.one_box_each(boxes, bounds=(-9, -9, 9, 9))
    for k in (0, 1):
        assert_array_equal(worlds.row(k).boxes, boxes[[k]])
        assert_array_equal(worlds.row(k).bounds, [[-9, -9, 9, 9]])


def test_kernels_get_contiguous_arrays() -> None:
    worlds = Worlds(**parts(boxes=np.asfortranarray(parts()["boxes"])), grid=GRID)
    arrays = worlds.arrays()
    assert all(a.flags.c_contiguous for a in (arrays.boxes, arrays.offsets, arrays.of))
    assert arrays.cell == 0.5
    assert arrays.blocked.shape == (1, 4, 6)
    assert Worlds(**parts()).arrays().blocked.shape == (0, 0, 0)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"boxes": np.zeros((3, 3))}, "boxes must have shape (m, 4), got (3, 3)"),
        ({"boxes": np.array([[1.0, 0, 0, 1]] * 3)}, "a box needs finite x0 <= x1 and y0 <= y1"),
        ({"boxes": np.full((3, 4), np.nan)}, "a box needs finite x0 <= x1 and y0 <= y1"),
        ({"offsets": np.array([1, 2, 3])}, "`offsets` must rise from 0 to the 3 boxes"),
        ({"offsets": np.array([0, 1, 2])}, "`offsets` must rise from 0 to the 3 boxes"),
        ({"offsets": np.array([0, 9, 3])}, "`offsets` must rise from 0 to the 3 boxes"),
        ({"offsets": np.array([], int)}, "`offsets` must rise from 0 to the 3 boxes"),
        ({"offsets": np.array([0, 3])}, "1 worlds need bounds (1, 4), got (2, 4)"),
        ({"bounds": np.array([[0.0, 0, -1, 1]] * 2)}, "an edge needs x0 <= x1 and y0 <= y1"),
        ({"bounds": np.full((2, 4), np.nan)}, "an edge needs x0 <= x1 and y0 <= y1"),
        ({"of": np.array([0, 2])}, "`of` must name worlds 0 to 1"),
        ({"of": np.array([-1, 0])}, "`of` must name worlds 0 to 1"),
    ],
)
def test_worlds_that_kernels_could_not_read_are_refused(
    changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(ShapeError, match=re.escape(message)):
        Worlds(**parts(**changes))


@pytest.mark.parametrize("blocked", [np.zeros((6, 4), np.uint8), np.zeros((4, 6), bool)])
def test_a_grid_must_fit_its_frame(blocked: Any) -> None:
    with pytest.raises(ShapeError, match=re.escape("a grid needs uint8 cells of shape (4, 6)")):
        Grid(frame=GRID.frame, blocked=blocked)


DISC, TRIANGLE = Shape.disc(1.0, 2.0, 0.5), Shape.polygon([(0, 0), (2, 0), (1, 1)])


def test_shapes_are_packed_world_by_world() -> None:
    shapes = Shapes.packed([[DISC, TRIANGLE], [TRIANGLE]])
    worlds = Worlds(**parts(), shapes=shapes)
    assert [len(worlds.shapes_of(k)) for k in (0, 1, 2)] == [1, 2, 1]
    for k in (0, 1):
        one = worlds.row(k)
        for got, there in zip(one.shapes_of(), worlds.shapes_of(k), strict=True):
            assert_array_equal(got.corners, there.corners)
            assert got.radius == there.radius
    assert_array_equal(worlds.arrays().shapes, [0, 2, 3])
    assert Worlds.single(shapes=[DISC]).shapes_of()[0].radius == 0.5
    assert Worlds.single().shapes_of() == []


def test_an_outline_covers_what_the_shape_covers() -> None:
    for shape in (DISC, TRIANGLE, TRIANGLE.grown(0.5), Shape.box(0, 0, 2, 1).grown(0.25)):
        drawn = unary_union([Polygon(each).buffer(0) for each in shape.outline(step=0.01)])
        body = Polygon(shape.corners) if len(shape.corners) > 2 else Point(*shape.corners[0])
        there = body.buffer(shape.radius, quad_segs=200)
        assert drawn.symmetric_difference(there).area < 1e-4


@pytest.mark.parametrize(
    ("what", "message"),
    [
        ({"corners": np.empty((0, 2))}, "a shape needs corners (m, 2), got (0, 2)"),
        ({"corners": np.array([[np.nan, 0.0]])}, "a corner of a shape is not a finite number"),
        ({"corners": np.zeros((1, 2)), "radius": -1.0}, "radius of a shape must be 0 m or more"),
        ({"corners": np.zeros((1, 2)), "radius": np.nan}, "radius of a shape must be 0 m or more"),
    ],
)
def test_shapes_that_are_none_are_refused(what: Any, message: str) -> None:
    with pytest.raises(ShapeError, match=re.escape(message)):
        Shape(**what)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"ends": np.array([0, 2])}, "`ends` of shapes must rise from 0 to 1"),
        ({"offsets": np.array([1, 1])}, "`offsets` of shapes must rise from 0 to 1"),
        ({"radius": np.zeros(1), "ends": np.array([0, 1, 1])}, "every shape needs a radius and"),
    ],
)
def test_packed_shapes_must_fit_each_other(changes: dict[str, Any], message: str) -> None:
    good: dict[str, Any] = {
        "corners": np.zeros((1, 2)),
        "ends": np.array([0, 1]),
        "radius": np.zeros(1),
        "offsets": np.array([0, 1]),
    }
    with pytest.raises(ShapeError, match=re.escape(message)):
        Shapes(**{**good, **changes})


def test_every_world_needs_its_shapes() -> None:
    with pytest.raises(ShapeError, match="2 worlds need the shapes of each, got 1"):
        Worlds(**parts(), shapes=Shapes.packed([[DISC]]))
