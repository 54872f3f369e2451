"""Range fans that look over the ground."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.core import Frame, Mission, RoverState, SettingError
from rovernav.kernels.geometry import first_boxes
from rovernav.rover import read_rover
from rovernav.sim import (
    LIDAR,
    Body,
    Drive,
    Grid,
    Ground,
    NoisyFan,
    RangeFan,
    Shape,
    Worlds,
    _tables,
    check_sensor,
    simulate,
)
from tests.naive import ridges as naive
from tests.sim.drives import Always

CELL = 0.5


def over(height: np.ndarray, **more: Any) -> Worlds:
    frame = Frame(cell=CELL, shape=(height.shape[0], height.shape[1]))
    return Worlds.single(ground=Ground(frame=frame, height=height.astype(np.float32)), **more)


def standing(poses: Any, pitch: Any = 0.0, roll: Any = 0.0) -> RoverState:
    poses = np.atleast_2d(np.asarray(poses, float))
    state = RoverState.at_start(
        Mission(start=poses, goal=np.zeros((len(poses), 2)), goal_radius=0.1, time_limit=9.0)
    )
    attitude = np.zeros((len(poses), 3))
    attitude[:, 1], attitude[:, 2] = pitch, roll
    return replace(state, attitude=attitude)


def read(fan: RangeFan, world: Worlds, state: RoverState) -> np.ndarray:
    return fan.read(world, state, None)[0]


def rough(seed: int, side: int = 60) -> np.ndarray:
    rng = np.random.default_rng(seed)
    i, j = np.mgrid[0:side, 0:side]
    return 0.5 * np.sin(0.2 * i) * np.cos(0.17 * j) + rng.normal(0.0, 0.05, (side, side))


AHEAD = RangeFan(reach=20.0, beams=3, view=math.pi, height=1.0)


def test_a_ridge_hides_what_lies_behind_it_and_a_low_one_does_not() -> None:
    wall = [(25.0, -99.0, 26.0, 99.0)]
    for top, want in ((1.5, 7.0), (0.9, 17.0)):
        height = np.zeros((60, 60))
        height[:, 30:] = top  # the ground rises from x = 14.75 m to 15.25 m
        height[:, 32:] = 0.0
        got = read(AHEAD, over(height, boxes=wall), standing([8.0, 15.0, 0.0]))[0, 1]
        if top < 1.0:
            assert got == want
        else:
            assert got == pytest.approx(14.75 + 0.5 / top - 8.0, abs=1e-6)


def test_level_ground_ends_beams_that_point_down_and_no_others() -> None:
    flat, nothing = over(np.full((200, 200), 3.0)), Worlds.single()
    for pitch, roll in ((-0.1, 0.0), (0.1, 0.0), (0.0, 0.2), (0.0, 0.0)):
        state = standing([50.0, 50.0, 0.7], pitch, roll)
        got = read(AHEAD, flat, state)[0]
        up = math.cos(pitch) * math.cos(roll)  # height of the eye
        sinks = (
            math.cos(pitch) * math.sin(roll),
            -math.sin(pitch),
            -math.cos(pitch) * math.sin(roll),
        )
        want = [min(20.0, up / sink) if sink > 0 else 20.0 for sink in sinks]
        assert_allclose(got, want, rtol=1e-6)
        assert_allclose(read(AHEAD, nothing, state)[0], want, rtol=1e-12)


def test_without_ground_and_attitude_it_is_the_level_fan() -> None:
    rng = np.random.default_rng(1)
    blocked = (rng.random((40, 40)) < 0.05).astype(np.uint8)
    grid = Grid(frame=Frame(cell=0.5, shape=(40, 40)), blocked=blocked)
    shapes = [Shape.disc(5.0, 5.0, 1.0), Shape.polygon([(12, 12), (15, 13), (13, 16)])]
    world = Worlds.single([(2.0, 9.0, 3.0, 11.0)], grid=grid, shapes=shapes, rovers=30)
    state = standing(rng.uniform((0, 0, -3), (20, 20, 3), (30, 3)))
    for _ in range(3):  # without and with the table
        level = read(RangeFan(reach=9.0, beams=31), world, state)
        got = read(RangeFan(reach=9.0, beams=31, height=1.0), world, state)
        assert_allclose(got, level, rtol=1e-12, atol=1e-12)


@pytest.mark.kernels
def test_readings_are_those_of_a_twin_that_tries_every_patch() -> None:
    rng, height = np.random.default_rng(2), rough(2, 16)
    height[4, 9] = np.nan
    boxes = [(5.0, 5.0, 5.5, 6.0)]
    world = over(height, boxes=boxes, rovers=6)
    poses = rng.uniform((2, 2, -3), (6, 6, 3), (6, 3))
    pitch, roll = rng.normal(0.0, 0.2, (2, 6))
    fan = RangeFan(reach=5.0, beams=9, view=2.0, height=0.4)
    got, met = read(fan, world, standing(poses, pitch, roll)), 0
    for k in range(6):
        turn = _turned(poses[k, 2], pitch[k], roll[k])
        base = _bilinear(world.ground.height, poses[k, 0], poses[k, 1])  # pyright: ignore
        eye = np.array([*poses[k, :2], base]) + turn @ (0.0, 0.0, 0.4)
        for b, a in enumerate(fan.angles):
            end = eye + 5.0 * (turn @ (math.cos(a), math.sin(a), 0.0))
            t = naive.first_rise(eye, end, world.ground.height, CELL)  # pyright: ignore
            box = first_boxes(eye[0], eye[1], end[0], end[1], np.array(boxes), 0, 1)
            want = 5.0 * min(1.0, math.inf if t is None else t, box)
            assert got[k, b] == pytest.approx(want, abs=1e-7)
            met += want < 5.0
    assert met > 10


def _turned(heading: float, pitch: float, roll: float) -> np.ndarray:
    (ch, sh), (cp, sp), (cr, sr) = ((math.cos(a), math.sin(a)) for a in (heading, pitch, roll))
    yaw = np.array([[ch, -sh, 0], [sh, ch, 0], [0, 0, 1]])
    nose_up = np.array([[cp, 0, -sp], [0, 1, 0], [sp, 0, cp]])
    left_up = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    return yaw @ nose_up @ left_up


def _bilinear(height: np.ndarray, x: float, y: float) -> float:
    u, v = x / CELL - 0.5, y / CELL - 0.5
    j, i = int(u), int(v)
    u, v = u - j, v - i
    low = (1 - u) * float(height[i, j]) + u * float(height[i, j + 1])
    return (1 - v) * low + v * ((1 - u) * float(height[i + 1, j]) + u * float(height[i + 1, j + 1]))


@settings(max_examples=25)
@given(
    quarters=st.integers(0, 3), cells=st.integers(0, 40), mirrored=st.booleans(),
    seed=st.integers(0, 99),
)  # fmt: skip
def test_turned_shifted_and_mirrored_ground_gives_the_same_readings(
    quarters: int, cells: int, mirrored: bool, seed: int
) -> None:
    rng, height = np.random.default_rng(seed), rough(seed)
    fan = RangeFan(reach=12.0, beams=21, view=4.0, height=0.4)
    x, y, heading = rng.uniform((6, 6, -3), (24, 24, 3))
    pitch, roll = rng.normal(0.0, 0.1, 2)
    here = read(fan, over(height), standing([x, y, heading], pitch, roll))[0]
    side = CELL * len(height)
    if mirrored:
        height, y, heading, roll = height[::-1], side - y, -heading, -roll
    for _ in range(quarters):
        height, x, y = height[::-1].T, side - y, x
        heading += math.pi / 2
    height = np.pad(height, ((0, 0), (cells, 0)), constant_values=np.nan)
    there = read(fan, over(height), standing([x + CELL * cells, y, heading], pitch, roll))[0]
    there = there[::-1] if mirrored else there
    # a beam that grazes may pass: the ground's rounding differs
    assert (abs(here - there) < 1e-6).mean() > 0.9


def test_it_never_reads_beyond_what_stands_in_the_way() -> None:
    rng, height = np.random.default_rng(4), rough(4)
    world = over(height, boxes=[(10.0, 10.0, 11.0, 14.0)], rovers=12)
    poses = rng.uniform((6, 6, -3), (24, 24, 3), (12, 3))
    pitch, roll = rng.normal(0.0, 0.1, (2, 12))
    fan, met = RangeFan(reach=5.0, beams=15, height=0.5), 0
    got = read(fan, world, standing(poses, pitch, roll))
    for k, (x, y, heading) in enumerate(poses):
        turn = _turned(heading, pitch[k], roll[k])
        eye = np.array([x, y, _bilinear(height, x, y)]) + turn @ (0.0, 0.0, 0.5)
        for angle, length in zip(fan.angles, got[k], strict=True):
            way = turn @ (math.cos(angle), math.sin(angle), 0.0)
            for far in np.arange(0.0, length - 1e-4, 0.05):
                px, py, pz = eye + far * way
                assert pz > _bilinear(height, px, py) - 1e-5
                assert not (10.0 <= px <= 11.0 and 10.0 <= py <= 14.0)
            met += length < 5.0
    assert met > 30


def test_rocks_on_the_ground_are_seen() -> None:
    flat = np.zeros((60, 60))
    rock = [(18.0, 15.0, 1.0, 2.0)]
    got = read(AHEAD, over(flat, rocks=rock), standing([8.0, 15.0, 0.0]))[0, 1]
    assert 8.5 < got < 9.5
    assert read(AHEAD, over(flat), standing([8.0, 15.0, 0.0]))[0, 1] == 20.0


def test_where_the_ground_is_not_known_only_obstacles_are_seen() -> None:
    world = over(np.full((60, 60), np.nan), boxes=[(20.0, -99.0, 21.0, 99.0)])
    assert read(AHEAD, world, standing([8.0, 15.0, 0.0], -0.3))[0, 1] == pytest.approx(
        (12.0 - math.sin(0.3)) / math.cos(0.3)  # the mast leans forward
    )


def drive(n: int, sensor: Any) -> Drive:
    height = rough(6, 100)
    rng = np.random.default_rng(6)
    mission = Mission(
        start=rng.uniform((15, 15, -3), (35, 35, 3), (n, 3)),
        goal=np.full((n, 2), 99.0), goal_radius=0.1, time_limit=4.0,
    )  # fmt: skip
    return Drive(
        worlds=over(height, rovers=n), mission=mission, sensors=(sensor,),
        controller=Always(0.3, 0.0, 0.1),
        motion=Body(read_rover("research"), period=0.5, spread=0.2),
    )  # fmt: skip


@pytest.mark.parametrize("noisy", [False, True])
def test_a_row_is_the_rover_alone_and_threads_change_nothing(noisy: bool) -> None:
    fan = RangeFan(reach=9.0, beams=20, height=0.5)
    whole = drive(70, NoisyFan(fan, LIDAR) if noisy else fan)
    trace, two = simulate(whole, seed=3), simulate(whole, seed=3, workers=2)
    assert trace.channels["beams"].min() < 9.0
    assert_array_equal(trace.channels["beams"], two.channels["beams"])
    ground = whole.worlds.ground
    assert ground is not None
    anew = replace(whole, worlds=replace(whole.worlds, ground=replace(ground)))
    again = simulate(anew, seed=3)
    assert_array_equal(trace.channels["beams"], again.channels["beams"])
    check_sensor(fan)


def test_the_table_is_made_once_it_pays_and_goes_with_its_ground() -> None:
    import gc

    from rovernav.sim._seeing import seen

    ground = seen(over(rough(7)))
    assert not len(_tables.tops_of(ground, beams=1).coarse)
    made = _tables.tops_of(ground, beams=60 * 60)
    assert len(made.coarse) == 1
    assert not made.coarse.flags.writeable
    assert _tables.tops_of(ground, beams=0) is made
    infinite = ground.heights.copy()
    infinite[0, 0, 0] = np.inf
    apart = ground._replace(heights=infinite)
    assert not len(_tables.tops_of(apart, beams=10**6).coarse)
    key = id(infinite)
    del apart, infinite
    gc.collect()
    assert key not in _tables._tops


@pytest.mark.parametrize("height", [0.0, -1.0, math.nan, math.inf])
def test_absurd_heights_are_refused(height: float) -> None:
    with pytest.raises(SettingError, match="needs a height above 0 m"):
        RangeFan(reach=1.0, height=height)
