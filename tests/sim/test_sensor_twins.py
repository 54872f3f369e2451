"""Sensors of the ground, tilt and cones against plain Python."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.core import Frame, Mission, RoverState
from rovernav.kernels import noise as kernels
from rovernav.sim import Ground, HoleSensor, Patch, Tilt, Worlds
from rovernav.sim._noise import FAR
from tests.naive import noise as luck
from tests.naive import seeing
from tests.naive.elevation import ground_at

pytestmark = pytest.mark.kernels
CELL, H, W, N = 0.5, 11, 14, 10


def there(rng: np.random.Generator) -> tuple[Worlds, Mission, RoverState]:
    """Rovers that lean, on rough ground of two worlds; some of it is missing."""
    heights = rng.normal(0.0, 0.25, (2, H, W)).astype(np.float32)
    heights[0, 6, 6:8] = np.nan
    worlds = Worlds(
        boxes=np.empty((0, 4)), offsets=np.zeros(3, np.int64),
        bounds=np.tile([0.0, 0.0, CELL * W, CELL * H], (2, 1)), of=np.arange(N) % 2,
        ground=Ground(frame=Frame(cell=CELL, shape=(H, W)), height=heights),
    )  # fmt: skip
    low, high = (0.5, 0.5, -3.0), (CELL * W - 0.5, CELL * H - 0.5, 3.0)
    start = rng.uniform(low, high, (N, 3))
    mission = Mission(start=start, goal=start[:, :2], goal_radius=0.1, time_limit=1.0)
    state = RoverState.at_start(mission)
    return worlds, mission, dataclasses.replace(state, attitude=rng.normal(0.0, 0.2, (N, 3)))


def layer(worlds: Worlds, k: int) -> Any:
    assert worlds.ground is not None
    return worlds.ground.height[worlds.of[k]]


def test_patches_equal_their_twin(rng: np.random.Generator) -> None:
    worlds, mission, state = there(rng)
    sensor = Patch(near=0.4, far=2.5, cell=0.5, mast=0.9, noise=0.01, lose=0.1)
    memory = sensor.start(mission, rng)
    eyes = {"mast": 0.9, "noise": 0.01, "lose": 0.1, "slack": 0.5}
    for step in (1, 2):
        got, memory = sensor.read(worlds, state, memory)
        for k in range(N):
            own = (int(memory.keys[k]), step)
            want = seeing.patch(layer(worlds, k), CELL, state.pose[k], sensor.places, eyes, own)
            assert_allclose(got[k], want, rtol=0, atol=1e-6)
    assert 20 < np.isnan(got).sum() < got.size - 50


def test_hole_sensors_equal_their_twin(rng: np.random.Generator) -> None:
    worlds, mission, state = there(rng)
    sensor = HoleSensor(down=(0.7, 0.9))
    got, memory = sensor.read(worlds, state, sensor.start(mission, rng))
    beams = list(zip(sensor.mounts, sensor.depressions, strict=True))
    reach, read = FAR * sensor.curve.reach, set[float]()
    for k in range(N):
        if np.isnan(ground_at(layer(worlds, k), CELL, *state.pose[k, :2])):
            continue
        far = seeing.down(layer(worlds, k), CELL, state.pose[k], state.attitude[k], beams, reach)
        assert_allclose(got[k], seeing.infrared(far, int(memory.keys[k]), 1, sensor.curve))
        read |= set(got[k])
    assert len(read) > 10


def test_tilt_and_cones_equal_their_twins(rng: np.random.Generator) -> None:
    worlds, mission, state = there(rng)
    sensor = Tilt(bias=0.01, noise=0.002)
    got, memory = sensor.read(worlds, state, sensor.start(mission, rng))
    for k, a in np.ndindex(N, 2):
        key = int(memory.keys[k])
        error = 0.01 * luck.deviate(key, 0, a) + 0.002 * luck.deviate(key, 1, a)
        assert got[k, a] == pytest.approx(state.attitude[k, 1 + a] + error, abs=1e-14)
    ranges, cones = rng.uniform(size=(6, 12)), np.empty((6, 4))
    kernels.nearest_of(ranges, 3, cones)
    assert_array_equal(cones, ranges.reshape(6, 4, 3).min(axis=2))


@pytest.mark.parametrize(("roll", "pitch"), [(0.0, 0.0), (0.1, -0.2)])
def test_flat_worlds_are_level(roll: float, pitch: float) -> None:
    start = np.zeros((1, 3))
    mission = Mission(start=start, goal=start[:, :2], goal_radius=0.1, time_limit=1.0)
    lean = np.array([[0.0, pitch, roll]])
    state = dataclasses.replace(RoverState.at_start(mission), attitude=lean)
    sensor = HoleSensor()
    wide = np.zeros((40, 40), np.float32)
    level = Ground(frame=Frame(cell=1.0, shape=(40, 40)), height=wide)
    there = dataclasses.replace(state, pose=np.add(start, (20.0, 20.0, 0.0)))
    memory = sensor.start(mission, np.random.default_rng(0))
    flat, _ = sensor.read(Worlds.single(), state, memory)
    same, _ = sensor.read(Worlds.single(ground=level), there, memory)
    assert_allclose(flat, same)
