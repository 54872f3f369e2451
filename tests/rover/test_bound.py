from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from rovernav.core import SettingError
from rovernav.rover import Bound, Pose, Settled, bound, read_rover, settle, surface
from tests.rover.rough_ground import poses, rough_ground
from tests.terrain.ground import ground, plane

ROVERS = ("perseverance", "sojourner", "research", "jackal")
SAMPLES = 40


def compare(
    name: str, seed: int, slope: float, cover: float, doubt: tuple[float, float], count: int
) -> tuple[Bound, Settled]:
    """Bounds for random poses, and those poses settled at many places of each box."""
    rover, rng = read_rover(name), np.random.default_rng(seed)
    cell = rover.wheel_radius / 2.6
    terrain = rough_ground(seed, slope=slope, cover=cover if cell > 0.05 else 0.0, cell=cell)
    made_ready = surface(terrain, rover)
    rows = poses(rng, terrain, count, 1.05 * rover.length)
    held = bound(made_ready, rows, position=doubt[0], heading=doubt[1])
    off = rng.uniform(-1.0, 1.0, (count, SAMPLES, 3))
    off[:, 0] = 0.0
    off[:, 1:13] = np.sign(off[:, 1:13])  # corners, where the worst often is
    within = rows[:, None] + off * [doubt[0], doubt[0], doubt[1]]
    return held, settle(made_ready, within.reshape(-1, 3))


def assert_held(held: Bound, stands: Settled) -> None:
    safe = held.safe
    grid = {
        key: getattr(stands, key).reshape(len(safe), SAMPLES)[safe]
        for key in ("code", "tilt", "pitch", "roll", "rocker", "bogie_left", "bogie_right")
    }
    assert (grid["code"] == Pose.SAFE).all()
    assert (grid["tilt"].max(1, initial=0.0) <= held.tilt[safe]).all()
    for key in ("pitch", "roll"):
        assert (grid[key].min(1, initial=9.0) >= getattr(held, key)[safe, 0]).all()
        assert (grid[key].max(1, initial=-9.0) <= getattr(held, key)[safe, 1]).all()
    assert (np.abs(grid["rocker"]).max(1, initial=0.0) <= held.rocker[safe] + 1e-12).all()
    for key in ("bogie_left", "bogie_right"):
        assert (np.abs(grid[key]).max(1, initial=0.0) <= held.bogie[safe] + 1e-12).all()
    clear = stands.clearance.reshape(len(safe), SAMPLES)[safe]
    assert (clear.min(1, initial=9.0) >= held.clearance[safe]).all()
    step = stands.step.reshape(len(safe), SAMPLES)[safe]
    assert (step.max(1, initial=0.0) <= held.step[safe]).all()


@settings(max_examples=25)
@given(
    seed=st.integers(0, 10**6),
    slope=st.floats(0.0, 0.35),
    cover=st.sampled_from([0.0, 0.03, 0.07, 0.15, 0.3]),
    position=st.floats(0.0, 0.12),
    heading=st.floats(0.0, 0.4),
)
@pytest.mark.parametrize("name", ROVERS)
def test_what_is_called_safe_is_safe(
    name: str, seed: int, slope: float, cover: float, position: float, heading: float
) -> None:
    size = read_rover(name).length
    assert_held(*compare(name, seed, slope, cover, (position * size, heading), 40))


@pytest.mark.long
@pytest.mark.parametrize("seed", range(40))
@pytest.mark.parametrize("name", ROVERS)
def test_what_is_called_safe_is_safe_in_many_cases(name: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    size = read_rover(name).length
    doubt = rng.uniform(0, 0.1) * size, rng.uniform(0, 0.3)
    cover = float(rng.choice([0.0, 0.05, 0.1, 0.2, 0.4]))
    assert_held(*compare(name, seed, rng.uniform(0, 0.4), cover, doubt, 1000))


def test_most_of_what_is_safe_is_called_safe() -> None:
    for slope in (0.0, math.radians(10.0)):
        held, stands = compare("perseverance", 1, slope, 0.07, (0.1, 0.05), 400)
        truly = stands.safe.reshape(400, SAMPLES).all(1)
        assert truly.mean() > 0.5
        assert (truly & ~held.safe).sum() <= 0.2 * truly.sum()


def test_on_a_plane_the_bound_is_the_plane() -> None:
    rover = read_rover("perseverance")
    terrain = plane(0.2, 0.0, shape=(100, 100), cell=0.1)
    held = bound(surface(terrain, rover), [[5.0, 5.0, 0.0]], position=0.3, heading=0.0)
    assert held.safe[0]
    assert_allclose(held.pitch[0], math.atan(0.2), atol=1e-4)
    assert_allclose(held.tilt[0], math.atan(0.2), atol=1e-4)
    assert_allclose(held.clearance[0], settle(surface(terrain, rover), [[5.0, 5.0, 0.0]]).clearance,
                    atol=1e-3)  # fmt: skip
    turning = bound(surface(terrain, rover), [[5.0, 5.0, 0.0]], position=0.3, heading=1.0)
    assert turning.pitch[0, 0] == pytest.approx(math.atan(0.2 * math.cos(1.0)), abs=2e-3)


@pytest.mark.kernels
@pytest.mark.parametrize("name", ROVERS)
def test_a_few_poses_are_held(name: str) -> None:
    size = read_rover(name).length
    held, stands = compare(name, 11, 0.1, 0.05, (0.02 * size, 0.03), 6)
    assert held.safe.any()
    assert_held(held, stands)


def test_more_doubt_never_makes_a_pose_safe() -> None:
    rover = read_rover("perseverance")
    terrain = rough_ground(9, slope=0.1, cover=0.1)
    rows = poses(np.random.default_rng(1), terrain, 300, 3.0)
    ready = surface(terrain, rover)
    little = bound(ready, rows, position=0.02, heading=0.01)
    much = bound(ready, rows, position=0.2, heading=0.2)
    assert (little.safe >= much.safe).all()
    both = little.safe & much.safe
    assert both.sum() > 50
    assert (much.tilt[both] >= little.tilt[both] - 1e-9).mean() > 0.95


def test_unknown_ground_is_never_safe() -> None:
    heights = np.zeros((100, 100))
    heights[50, 60] = np.nan
    ready = surface(ground(heights, 0.1), read_rover("perseverance"))
    held = bound(ready, [[5.0, 5.0, 0.0], [0.5, 5.0, 0.0], [99.0, 5.0, 0.0]])
    assert held.code.tolist() == [Pose.NO_DATA] * 3
    assert np.isnan(held.clearance).all()


def test_doubt_is_checked() -> None:
    ready = surface(ground(np.zeros((60, 60)), 0.1), read_rover("research"))
    with pytest.raises(SettingError, match="doubt of position must be 0 to 100 m, of heading 0 to"):
        bound(ready, [[3.0, 3.0, 0.0]], position=-0.1)
    with pytest.raises(SettingError, match="of heading 0 to 1 rad"):
        bound(ready, [[3.0, 3.0, 0.0]], heading=math.nan)
