"""The patch and the hole sensor: what is hidden stays hidden, noise grows with distance squared."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.core import Frame, Mission, RoverState, SettingError
from rovernav.sim import Ground, HoleSensor, Patch, Rocks, Worlds, check_sensor
from tests.naive.elevation import ground_at, hidden

CELL = 0.25


def worlds_of(height: np.ndarray, rovers: int = 1, rocks: Any = None) -> Worlds:
    frame = Frame(cell=CELL, shape=(height.shape[-2], height.shape[-1]))
    ground = Ground(frame=frame, height=height.astype(np.float32))
    made = Worlds.single(ground=ground, rovers=rovers)
    if rocks is None:
        return made
    place = np.array(rocks, float).reshape(-1, 4)
    return dataclasses.replace(
        made, rocks=Rocks(place=place, offsets=np.array([0, len(place)], np.int64))
    )


def rough(rng: np.random.Generator) -> np.ndarray:
    y, x = np.indices((60, 60)) * CELL
    return np.sin(x) * 0.5 + np.cos(1.3 * y) * 0.4 + rng.normal(0, 0.05, (60, 60))


def state_at(poses: Any, attitude: Any = None) -> tuple[Mission, RoverState]:
    start = np.array(poses, float).reshape(-1, 3)
    mission = Mission(start=start, goal=start[:, :2], goal_radius=0.0, time_limit=1.0)
    state = RoverState.at_start(mission)
    if attitude is not None:
        state = dataclasses.replace(state, attitude=np.tile(attitude, (len(start), 1)))
    return mission, state


def read(sensor: Any, worlds: Worlds, poses: Any, attitude: Any = None) -> np.ndarray:
    mission, state = state_at(poses, attitude)
    return sensor.read(worlds, state, sensor.start(mission, np.random.default_rng(0)))[0]


def on_rough_ground(n: int, rng: np.random.Generator) -> tuple[Worlds, Mission, RoverState]:
    layers = np.stack([rough(rng), rough(rng)]).astype(np.float32)
    frame = Frame(cell=CELL, shape=(60, 60))
    worlds = Worlds(
        boxes=np.zeros((0, 4)), offsets=np.zeros(3, np.int64),
        bounds=np.tile((0.0, 0, 15, 15), (2, 1)),
        of=rng.integers(0, 2, n), ground=Ground(frame=frame, height=layers),
    )  # fmt: skip
    return worlds, *state_at(rng.uniform((3, 3, -3), (12, 12, 3), (n, 3)))


@pytest.mark.parametrize("sensor", [Patch(far=3.0, cell=0.4), HoleSensor()], ids=lambda s: s.name)
def test_sensors_of_the_ground_keep_their_contract(sensor: Any) -> None:
    check_sensor(sensor, on_rough_ground)


def test_a_patch_is_the_ground_where_it_is_seen_and_nothing_where_it_is_hidden(
    rng: np.random.Generator,
) -> None:
    height = rough(rng).astype(np.float32)
    sensor = Patch(far=4.0, cell=0.4, noise=0.0, lose=0.0, mast=0.6)
    seen = 0
    for pose in rng.uniform((3, 3, -3), (12, 12, 3), (6, 3)):
        patch = read(sensor, worlds_of(height), pose)[0]
        base = ground_at(height, CELL, pose[0], pose[1])
        eye = (pose[0], pose[1], base + 0.6)
        turn = complex(math.cos(pose[2]), math.sin(pose[2]))
        for (forward, left), got in zip(sensor.places, patch, strict=True):
            at = complex(pose[0], pose[1]) + turn * complex(forward, left)
            z = ground_at(height, CELL, at.real, at.imag)
            over = hidden(height, CELL, eye, (at.real, at.imag, z), 0.4)
            if np.isnan(got):
                assert np.isnan(z) or over > -1e-3
            else:
                seen += 1
                assert got == pytest.approx(z - base, abs=1e-6)
                assert over < 1e-3
    assert 100 < seen < 6 * len(sensor.places) - 50


def test_a_ridge_throws_a_shadow_as_long_as_geometry_says() -> None:
    height = np.zeros((80, 80))
    height[:, 40] = 0.5  # a wall 10.125 m east, 0.5 m high; the eye is 1 m up
    sensor = Patch(far=9.0, cell=0.25, view=math.radians(20), noise=0.0, lose=0.0)
    patch = read(sensor, worlds_of(height), (6.125, 10.0, 0.0))[0]
    ahead = sensor.places[:, 1] == 0.0
    x, z = sensor.places[ahead, 0], patch[ahead]
    assert np.isfinite(z[x <= 4.0]).all()
    assert z[x == 4.0] == pytest.approx(0.5)
    # the top hides what lies from 4 m to 8 m, but for what is within one place of its end
    assert np.isnan(z[(x > 4.3) & (x < 7.7)]).all()
    assert np.isfinite(z[x > 8.1]).all()


def test_height_noise_grows_with_distance_squared() -> None:
    worlds = worlds_of(np.zeros((60, 60)), rovers=400)
    sensor = Patch(far=6.0, cell=0.5, noise=0.004, lose=0.0)
    poses = np.tile([7.5, 7.5, 0.0], (400, 1))
    patch = read(sensor, worlds, poses)
    assert np.isfinite(patch).all()
    squared = (sensor.places**2).sum(axis=1) + 1.0
    assert_allclose(patch.std(axis=0), 0.004 * squared, rtol=0.2)
    ratio = float((patch / squared).std() / 0.004)
    assert ratio == pytest.approx(1.0, rel=0.01)


def test_some_places_have_no_match() -> None:
    patch = read(Patch(lose=0.25, noise=0.0), worlds_of(np.zeros((60, 60))), (7.5, 7.5, 0.0))
    assert np.isnan(patch).mean() == pytest.approx(0.25, abs=0.04)


def test_rocks_are_seen_and_hide_ground() -> None:
    worlds = worlds_of(np.zeros((60, 60)), rocks=[(9.1, 7.6, 0.6, 0.8)])
    sensor = Patch(far=6.0, cell=0.2, view=math.radians(30), noise=0.0, lose=0.0)
    bare = read(sensor, worlds_of(np.zeros((60, 60))), (6.1, 7.6, 0.0))[0]
    patch = read(sensor, worlds, (6.1, 7.6, 0.0))[0]
    assert np.isfinite(bare).all()
    assert np.nanmax(patch) > 0.6
    behind = (sensor.places[:, 0] > 3.8) & (sensor.places[:, 0] < 4.8)
    assert np.isnan(patch[behind & (abs(sensor.places[:, 1]) < 0.3)]).all()


def test_flat_worlds_are_level_ground() -> None:
    patch = read(Patch(noise=0.0, lose=0.0), Worlds.single(), (0.0, 0.0, 1.0))
    assert_array_equal(patch, np.zeros_like(patch))


def test_nothing_is_seen_beyond_the_map_or_from_ground_that_is_not_known() -> None:
    height = np.zeros((60, 60))
    assert np.isnan(read(Patch(lose=0.0), worlds_of(height), (14.9, 7.5, 0.0))).all()
    height[28:32, 28:32] = np.nan
    assert np.isnan(read(Patch(lose=0.0), worlds_of(height), (7.5, 7.5, 0.0))).all()


def holes(height: np.ndarray, pose: Any, attitude: Any = None) -> np.ndarray:
    sensor = HoleSensor(across=(0.0,))
    return sensor.holes(read(sensor, worlds_of(height), pose, attitude), 0.15)[0]


def test_a_hole_ahead_is_noticed_before_the_wheels_are_in_it() -> None:
    height = np.zeros((60, 60))
    height[:, 36:] = -1.0  # the edge lies 9 m east
    assert not holes(height, (7.0, 7.5, 0.0)).any()
    assert holes(height, (8.4, 7.5, 0.0)).all()
    assert not holes(height, (8.4, 7.5, math.pi)).any()


def test_a_hole_sensor_reads_what_geometry_says() -> None:
    sensor = HoleSensor(across=(0.0,), height=0.4, down=math.radians(60))
    level = worlds_of(np.zeros((60, 60)), rovers=300)
    poses = np.tile([7.5, 7.5, 0.7], (300, 1))
    got = np.median(read(sensor, level, poses))
    assert got == pytest.approx(0.4 / math.sin(math.radians(60)), abs=0.02)
    # nose down by 10 deg: the mount sinks, the beam is steeper
    pitch = -math.radians(10)
    up = 0.3 * math.sin(pitch) + 0.4 * math.cos(pitch)
    nose = np.median(read(sensor, level, poses, (0.0, pitch, 0.0)))
    # the maker's power fit, by which counts are read, is off its table by up to 2.5 cm here
    assert nose == pytest.approx(up / math.sin(math.radians(70)), abs=0.03)
    assert np.median(read(sensor, Worlds.single(rovers=300), poses)) == pytest.approx(got, abs=0.01)


BAD: list[tuple[Any, str]] = [
    (lambda: Patch(far=0.4), "must reach farther than 0.5 m"),
    (lambda: Patch(cell=0.001), "at most 400 cells"),
    (lambda: Patch(mast=math.nan), "needs a mast above 0"),
    (lambda: Patch(noise=-1.0), "noise must be 0 or more"),
    (lambda: HoleSensor("GP2D12"), "did you mean 'GP2D120'"),
    (lambda: HoleSensor(height=-1.0), "needs a height above 0 m"),
    (lambda: HoleSensor(height=3.0), "but level ground is 3.92 m away"),
]


@pytest.mark.parametrize(("make", "message"), BAD)
def test_absurd_eyes_are_refused(make: Any, message: str) -> None:
    with pytest.raises(SettingError, match=message):
        make()
