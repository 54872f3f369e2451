"""Fans by table against the plain walk, bit for bit, and against every cell tried."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from rovernav.kernels import geometry, rays, shapes
from rovernav.kernels import ray_lanes as lanes
from rovernav.kernels._jit import kernel
from rovernav.kernels.drive import WorldArrays
from rovernav.sim import Shape, Shapes
from tests.naive import rays as naive

pytestmark = pytest.mark.kernels

EIGHTHS = np.arange(64) * math.pi / 32  # along axes and diagonals too
ODD = (0.0, -0.0, 1e-9, -1e-9, 5e-324, 1e5, -1e5, 1e18, -1e300, math.inf, -math.inf, math.nan)


def world(blocked: np.ndarray, of: Any, cell: float = 1.0, **more: Any) -> WorldArrays:
    layers = blocked if blocked.ndim == 3 else blocked[None]
    of = np.asarray(of, np.int64)
    count = int(of.max(initial=0)) + 1
    plain = {"boxes": np.empty((0, 4)), "offsets": np.zeros(count + 1, np.int64)}
    return WorldArrays(**{**plain, **more}, of=of, blocked=np.ascontiguousarray(layers), cell=cell)


def cones(where: WorldArrays) -> rays.ConeArrays:
    layers, h, w = where.blocked.shape
    free = np.empty((layers, rays.table_size(h, w)), np.uint8)
    rays.free_cones(where.blocked, free)
    return rays.ConeArrays(free=free)


NONE = rays.ConeArrays(free=np.zeros((0, 0), np.uint8))


def fan(pose: Any, angles: Any, reach: float, where: WorldArrays, table: Any) -> np.ndarray:
    pose, angles = np.atleast_2d(np.asarray(pose, float)), np.asarray(angles, float)
    out = np.full((len(pose), len(angles)), np.nan)
    ways = np.stack([np.cos(angles), np.sin(angles)])
    rays.range_fan(pose, ways, reach, where, table, out)
    return out


def both(pose: Any, angles: Any, reach: float, where: WorldArrays) -> np.ndarray:
    """The fan by table, after it was seen to be that of the plain walk."""
    quick = fan(pose, angles, reach, where, cones(where))
    plain = fan(pose, angles, reach, where, NONE)
    differ = quick.view(np.int64) != plain.view(np.int64)
    assert not differ.any(), (pose, np.argwhere(differ)[:4], quick[differ][:4], plain[differ][:4])
    return quick


def poses(rng: np.random.Generator, h: int, w: int, count: int) -> np.ndarray:
    """Free, on lattice lines and corners, a rounding beside them, on the edge and beyond it."""
    pose = rng.uniform((-4.0, -4.0, -7.0), (w + 4.0, h + 4.0, 7.0), (count, 3))
    kind = rng.integers(6, size=count)
    for k, (pick, row) in enumerate(zip(kind, pose, strict=True)):
        if pick in (1, 2, 3):
            row[: 2 if pick != 2 else 1] = np.round(row[: 2 if pick != 2 else 1])
        if pick == 3:
            row[:2] += rng.choice([0.0, 1e-15, -1e-12, 1e-9, -1e-7, 2e-6], 2)
        if pick in (1, 4):
            row[2] = rng.integers(-8, 9) * math.pi / 4
        if pick == 4:
            row[2] += rng.choice([0.0, 1e-12, -1e-9, 1e-6])
        if k % 7 == 0:
            row[:2] = (rng.choice([0.0, w]), rng.uniform(0, h))
    return pose


def grid(rng: np.random.Generator, h: int, w: int) -> np.ndarray:
    return (rng.random((h, w)) < rng.choice([0.0, 0.01, 0.1, 0.5, 1.0])).astype(np.uint8)


@pytest.mark.parametrize(
    ("h", "w"), [(1, 1), (1, 9), (13, 1), (8, 8), (7, 9), (16, 15), (40, 63), (70, 129)]
)
def test_the_table_changes_no_bit(h: int, w: int) -> None:
    rng = np.random.default_rng([h, w])
    for _ in range(12 if h * w < 1000 else 4):
        c, reach = float(rng.choice([1.0, 0.1, 0.3])), float(rng.choice([0.2, 2.0, 17.3, 300.0]))
        pose = poses(rng, h, w, 40)
        pose[:, :2] *= c
        layers = np.stack([grid(rng, h, w) for _ in range(3)])
        both(pose, EIGHTHS, reach * c, world(layers, rng.integers(0, 3, 40), c))
        both(pose, rng.uniform(-9, 9, 70), reach * c, world(layers[0], np.zeros(40), c))


@pytest.mark.parametrize("family", ["lattice", "quarters", "free"])
def test_a_beam_ends_at_the_nearest_of_all_cells(family: str) -> None:
    rng = np.random.default_rng(4)
    angles = EIGHTHS[::4] if family != "free" else rng.uniform(-4, 4, 16)
    ways = np.stack([np.cos(angles), np.sin(angles)])
    for _ in range(12):
        blocked = (rng.random((9, 12)) < 0.12).astype(np.uint8)
        pose = rng.uniform((-2, -2, -3), (14, 11, 3), (3, 3))
        if family != "free":
            pose[:, :2] = (
                np.round(pose[:, :2] * 4) / 4 if family == "quarters" else np.round(pose[:, :2])
            )
            pose[:, 2] = 0.0
        got = both(pose, angles, 9.0, world(blocked, np.zeros(3)))
        for k, row in enumerate(pose):
            want = [naive.beam(row, ways[:, b], 9.0, blocked, 1.0) for b in range(16)]
            assert_array_equal(got[k], want)


def test_coordinates_that_are_none_reach_as_far_as_nothing() -> None:
    where = world(np.ones((5, 6), np.uint8), np.zeros(len(ODD) ** 2))
    pose = np.array([(x, y, 0.5) for x in ODD for y in ODD])
    with np.errstate(all="ignore"):
        got = both(pose, EIGHTHS, 3.0, where)
        strange = ~np.isfinite(pose).all(axis=1)
        assert (got[strange] == 3.0).all()
        headings = np.array([[2.0, 2.0, a] for a in ODD])
        got = both(headings, EIGHTHS, 3.0, world(np.zeros((5, 6), np.uint8), np.zeros(len(ODD))))
        assert (got == 3.0).all()


def test_a_rover_in_or_at_a_blocked_cell_sees_nothing_but_that() -> None:
    blocked = np.zeros((20, 20), np.uint8)
    blocked[10, 10] = 1
    for x, y in ((10.5, 10.5), (10.0, 10.5), (11.0, 11.0), (10.0, 11.0), (10.5, 10.0)):
        assert (both((x, y, 0.3), EIGHTHS, 5.0, world(blocked, [0])) == 0.0).all()


def test_beams_along_cell_edges_and_through_corners_touch_both_sides() -> None:
    blocked = np.zeros((20, 20), np.uint8)
    blocked[10, 15] = 1
    along = both(
        [(5.0, 10.0, 0.0), (5.0, 11.0, 0.0), (5.0, 11.0 + 1e-9, 0.0)],
        [0.0],
        12.0,
        world(blocked, [0] * 3),
    )
    assert_array_equal(along[:, 0], [10.0, 10.0, 12.0])
    corner = both(
        [(10.0, 5.0, 0.0), (10.0, 16.0, 0.0)],
        [math.pi / 4, -math.pi / 4],
        12.0,
        world(blocked, [0] * 2),
    )
    np.testing.assert_allclose(corner[0, 0], 5.0 * math.sqrt(2), rtol=1e-15)
    np.testing.assert_allclose(corner[1, 1], 5.0 * math.sqrt(2), rtol=1e-15)


def test_the_table_tells_the_nearest_cell_of_each_cone(rng: np.random.Generator) -> None:
    for h, w in ((1, 1), (5, 9), (17, 8), (30, 21)):
        blocked = (rng.random((h, w)) < 0.06).astype(np.uint8)
        free = cones(world(blocked, [0])).free[0]
        tile, at = lanes.TILE, 0
        for step, (n, rows) in (
            ((0, 1), (w, h)), ((0, -1), (w, h)), ((1, 0), (h, w)), ((-1, 0), (h, w))
        ):  # fmt: skip
            high = -(-(rows + 4) // tile)
            for column in range(n):
                for row in range(rows):
                    k, m = row + 2, column
                    entry = free[
                        at + (m // tile * high + k // tile) * 64 + m % tile * tile + k % tile
                    ]
                    i, j = (row, column) if step[0] == 0 else (column, row)
                    assert entry & 15 == naive.cone(blocked, i, j, step, 15)
                    if row + 1 < rows:
                        i, j = (i + 1, j) if step[0] == 0 else (i, j + 1)
                        assert entry >> 4 == naive.cone(blocked, i, j, step, 15)
            at += 64 * high * -(-n // tile)
        assert at + rays.SPARE == len(free)


@kernel()
def march_all(table: Any, base: int, state: Any, bits: int) -> None:
    for first in range(0, state.shape[1], lanes.LANES):
        lanes.march(table, base, state, first, bits)


def test_lanes_march_as_single_rays_do() -> None:
    rng, bits, room = np.random.default_rng(3), 20, 4 * lanes.LANES
    table = rng.choice(
        np.array([0, 1, 2, 9, 16, 34, 128, 255], np.uint8), 90_000, p=[0.02] + [0.14] * 7
    )
    state = np.zeros((lanes.STATE, room), np.int32)
    state[lanes.SLOPE] = rng.integers(-(1 << bits) + 99, (1 << bits) - 99, room)
    state[lanes.LOW] = rng.integers(0, 1 << bits, room) + np.minimum(state[lanes.SLOPE], 0)
    state[lanes.SPREAD] = abs(state[lanes.SLOPE]) + 100
    state[lanes.PLACE], state[lanes.TILES] = rng.integers(0, 999, room), 64 * 9
    state[lanes.COLUMN] = rng.integers(300, 600, room)
    state[lanes.ADVANCE] = rng.choice([-1, 1], room)
    state[lanes.CORNER], state[lanes.LAST_ROW] = rng.integers(0, 66, room), 64
    state[lanes.START], state[lanes.STOP] = state[lanes.LOW] + 5000, 2**31 - 1
    state[lanes.LAST], state[lanes.GONE] = rng.integers(-1, 200, room), rng.integers(0, 3, room)
    quick, plain = state.copy(), state.copy()
    march_all(table, 7, quick, bits)
    for first in range(0, room, lanes.LANES):
        lanes.plain_march(table, 7, plain, first, bits)
    assert_array_equal(quick[lanes.GONE], plain[lanes.GONE])
    met = quick[lanes.GONE] <= quick[lanes.LAST]
    assert 0.2 < met.mean() < 1.0
    assert_array_equal(quick[lanes.ROW][met], plain[lanes.ROW][met])


def test_boxes_discs_and_polygons_stand_in_the_same_fan() -> None:
    rng = np.random.default_rng(8)
    blocked = (rng.random((30, 40)) < 0.02).astype(np.uint8)
    some = [Shape.disc(12.0, 8.0, 1.5), Shape.polygon([(20, 20), (25, 22), (21, 26)])]
    packed = Shapes.packed([some])
    boxes = np.array([[30.0, 3.0, 33.0, 9.0], [5.0, 20.0, 6.0, 29.0]])
    where = world(
        blocked, np.zeros(20), boxes=boxes, offsets=np.array([0, 2]), corners=packed.corners,
        ends=packed.ends, radius=packed.radius, shapes=packed.offsets,
    )  # fmt: skip
    pose, angles = poses(rng, 30, 40, 20), EIGHTHS[::5]
    got = both(pose, angles, 15.0, where)

    def others(ax: float, ay: float, bx: float, by: float) -> float:
        t = geometry.first_boxes(ax, ay, bx, by, boxes, 0, 2)
        which = (0, 2)
        met = shapes.first_shapes(ax, ay, bx, by, packed.corners, packed.ends, packed.radius, which)
        return min(t, met)

    ways = np.stack([np.cos(angles), np.sin(angles)])
    for k in range(0, 20, 5):
        want = [naive.beam(pose[k], ways[:, b], 15.0, blocked, 1.0, others) for b in range(13)]
        assert_array_equal(got[k], want)


def test_a_rover_has_the_readings_that_it_has_alone() -> None:
    rng = np.random.default_rng(9)
    layers = np.stack([grid(rng, 20, 30) for _ in range(4)])
    of, pose = rng.integers(0, 4, 50), poses(rng, 20, 30, 50)
    whole = both(pose, EIGHTHS[:49], 12.0, world(layers, of))
    for k in range(0, 50, 7):
        alone = both(pose[k], EIGHTHS[:49], 12.0, world(layers[of[k]], [0]))
        assert_array_equal(alone[0], whole[k])


quarter = st.integers(-20, 80).map(lambda n: n / 4)


@settings(max_examples=150)
@given(
    x=st.one_of(quarter, st.floats(-5, 20)),
    y=st.one_of(quarter, st.floats(-5, 20)),
    heading=st.one_of(st.integers(-8, 8).map(lambda n: n * math.pi / 4), st.floats(-1e6, 1e6)),
    reach=st.one_of(st.sampled_from([1e-4, 0.5, 3.0, 900.0, 5e3]), st.floats(1e-6, 60)),
    seed=st.integers(0, 2**32 - 1),
)
def test_whatever_the_beam_the_table_changes_no_bit(
    x: float, y: float, heading: float, reach: float, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    both((x, y, heading), EIGHTHS, reach, world(grid(rng, 15, 13), [0]))


@pytest.mark.long
def test_a_million_beams_have_the_bits_of_the_plain_walk() -> None:
    rng = np.random.default_rng(11)
    for _ in range(40):
        h, w = rng.integers(20, 300, 2).tolist()
        pose = poses(rng, h, w, 400)
        where = world(np.stack([grid(rng, h, w), grid(rng, h, w)]), rng.integers(0, 2, 400))
        both(pose, EIGHTHS + rng.choice([0.0, 0.1]), float(rng.uniform(1, 90)), where)
