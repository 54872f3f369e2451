from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.core import InputError, SettingError, ShapeError
from rovernav.rover import Pose, read_rover, settle, surface
from rovernav.terrain import Terrain
from tests.naive import settle as naive
from tests.rover.rough_ground import poses, rough_ground
from tests.rover.test_rovers import POINT, ROBOT, WHEELED, made
from tests.terrain.ground import ground, plane

JOINTED = ("perseverance", "sojourner", "research")
ANGLES = ("pitch", "roll", "tilt", "rocker", "bogie_left", "bogie_right")


@settings(max_examples=15)
@given(angle=st.floats(0.0, 0.45), way=st.floats(-3.1, 3.1), heading=st.floats(-3.1, 3.1))
@pytest.mark.parametrize("name", WHEELED)
def test_a_plane_gives_its_own_attitude(
    name: str, angle: float, way: float, heading: float
) -> None:
    rover = read_rover(name)
    cell = rover.wheel_radius / 1.6
    rise = math.tan(angle)
    terrain = plane(rise * math.cos(way), rise * math.sin(way), shape=(90, 90), cell=cell)
    pose = [45 * cell, 45 * cell, heading]
    stands = settle(surface(terrain, rover), [pose])
    along, across = rise * math.cos(way - heading), rise * math.sin(way - heading)
    assert_allclose(stands.tilt, angle, atol=5e-5)
    assert_allclose(stands.pitch, math.atan(along), atol=2e-5)
    assert_allclose(stands.roll, math.atan2(across, math.hypot(1.0, along)), atol=2e-5)
    for name in ("rocker", "bogie_left", "bogie_right"):
        assert_allclose(getattr(stands, name), 0.0, atol=1e-4)
    if angle == 0.0:
        assert_allclose(stands.clearance, rover.clearance, atol=1e-5)


@pytest.mark.kernels
@pytest.mark.parametrize("missing", [0.0, 0.02])
@pytest.mark.parametrize("radius", [0.05, 0.26, 0.4])
def test_wheel_centres_equal_their_twin(radius: float, missing: float) -> None:
    from tests.terrain.ground import rough

    terrain = ground(rough(np.random.default_rng(4), (9, 13), missing), 0.1)
    rover = made(ROBOT, wheel_radius=radius, length=2.0, track=0.3)
    expected = naive.wheel_centres(terrain.height, 0.1, radius)
    assert_allclose(surface(terrain, rover).wheel, expected, rtol=0, atol=2e-6)


@pytest.mark.kernels
@pytest.mark.parametrize("name", JOINTED)
@pytest.mark.parametrize("cover", [0.0, 0.1])
def test_settling_equals_newtons_method(name: str, cover: float) -> None:
    rover = read_rover(name)
    scale = rover.length / 3.0
    terrain = rough_ground(3, slope=0.15, cover=cover, cell=0.1, cells=90)
    shrunk = ground(terrain.height.astype(float) * scale, 0.1 * scale)
    made_ready = surface(shrunk, rover)
    rows = poses(np.random.default_rng(8), shrunk, 12, 2.6 * scale)
    stands, found = settle(made_ready, rows), 0
    for n, pose in enumerate(rows):
        twin = naive.settle(made_ready.wheel, shrunk.frame.cell, rover, pose)
        if twin["gap"] > 1e-9 or stands.error[n] > 1e-6:
            continue  # a wheel on an edge: no attitude, or several
        found += 1
        for key in ("pitch", "roll", "rocker", "bogie_left", "bogie_right"):
            assert getattr(stands, key)[n] == pytest.approx(twin[key], abs=3e-6)
        assert stands.z[n] - shrunk.offset == pytest.approx(twin["z"], abs=3e-6)
        gap = naive.clearance(shrunk.height, shrunk.frame.cell, rover, pose, twin)
        assert stands.clearance[n] == pytest.approx(gap, abs=1e-4)
    assert found >= 9


@pytest.mark.parametrize("seed", range(3))
def test_a_rigid_body_stands_on_three_wheels(seed: int) -> None:
    rover = read_rover("jackal")
    terrain = rough_ground(seed, slope=0.1, cell=0.02, cells=120)
    made_ready = surface(terrain, rover)
    rows = poses(np.random.default_rng(seed), terrain, 40, 0.5)
    stands = settle(made_ready, rows)
    for n, (x, y, heading) in enumerate(rows):
        spin = naive.rotation(stands.pitch[n], stands.roll[n], heading)
        gaps = []
        for point in naive.wheels(rover, 0.0, (0.0, 0.0)):
            at = np.array([x, y, stands.z[n] - terrain.offset]) + spin @ point
            gaps.append(at[2] - naive.bilinear(made_ready.wheel, 0.02, at[0], at[1]))
        assert sum(abs(gap) < 1e-6 for gap in gaps) >= 3
        assert min(gaps) > -1e-6


def turned(terrain: Terrain) -> Terrain:
    """The same ground after a quarter turn to the left."""
    return ground(np.rot90(terrain.height, -1).astype(float), terrain.frame.cell)


@pytest.mark.parametrize("name", ["perseverance", "jackal"])
def test_shifting_turning_and_mirroring_the_world(name: str) -> None:
    rover = read_rover(name)
    terrain = rough_ground(5, slope=0.1, cover=0.07 if name == "perseverance" else 0.0)
    rows = poses(np.random.default_rng(2), terrain, 60, 3.0)
    cell, extent = terrain.frame.cell, terrain.frame.extent[0]
    stands = settle(surface(terrain, rover), rows)
    assert (stands.error < 1e-6).sum() >= 55
    calm = stands.error < 1e-6
    wide = ground(np.pad(terrain.height.astype(float), ((7, 0), (4, 0)), mode="edge"), cell)
    shifted = settle(surface(wide, rover), rows + np.array([4 * cell, 7 * cell, 0.0]))
    quarter = np.stack([extent - rows[:, 1], rows[:, 0], rows[:, 2] + math.pi / 2], axis=1)
    after = settle(surface(turned(terrain), rover), quarter)
    flipped = ground(terrain.height[::-1].astype(float), cell)
    mirror = rows * [1.0, -1.0, -1.0] + [0.0, extent, 0.0]
    seen = settle(surface(flipped, rover), mirror)
    for key in ("pitch", "tilt", "clearance", "step"):
        for other in (shifted, after, seen):
            assert_allclose(getattr(other, key)[calm], getattr(stands, key)[calm], atol=5e-6)
    assert_allclose(after.roll[calm], stands.roll[calm], atol=5e-6)
    assert_allclose(seen.roll[calm], -stands.roll[calm], atol=5e-6)
    assert_allclose(seen.rocker[calm], -stands.rocker[calm], atol=5e-6)
    assert_allclose(seen.bogie_left[calm], stands.bogie_right[calm], atol=5e-6)
    assert_array_equal(seen.code[calm], stands.code[calm])


def test_a_row_of_a_batch_is_that_pose_alone() -> None:
    rover = read_rover("perseverance")
    terrain = rough_ground(6, cover=0.1)
    made_ready = surface(terrain, rover)
    rows = poses(np.random.default_rng(3), terrain, 20, 3.0)
    together = settle(made_ready, rows)
    for n in range(len(rows)):
        alone = settle(made_ready, rows[n : n + 1])
        for name in (*ANGLES, "clearance", "step", "error"):
            assert getattr(alone, name)[0] == getattr(together, name)[n]


def flat(change: Any = None) -> np.ndarray:
    heights = np.zeros((80, 80))
    if change is not None:
        heights[change] = np.nan
    return heights


def test_every_limit_has_its_code() -> None:
    rover = read_rover("perseverance")

    def code(heights: np.ndarray, at: tuple[float, float, float] = (4.0, 4.0, 0.0)) -> int:
        return int(settle(surface(ground(heights, 0.1), rover), [at]).code[0])

    assert code(flat()) == Pose.SAFE
    assert code(flat((40, 41))) == Pose.NO_DATA
    assert code(flat(), (0.3, 4.0, 0.0)) == Pose.NO_DATA
    assert code(flat(), (-30.0, 4.0, 0.0)) == Pose.NO_DATA
    assert code(np.indices((80, 80))[1] * 0.1 * math.tan(0.6)) == Pose.TILT
    rock = flat()
    rock[38:42, 38:42] = 0.7
    assert code(rock) == Pose.BELLY
    rock[38:42, 38:42] = 0.5
    assert code(rock) == Pose.SAFE
    ledge = flat()
    ledge[40:, 50:] = 0.45
    assert code(ledge, (4.0, 3.5, 0.0)) in (Pose.STEP, Pose.SUSPENSION)
    cliff = flat()
    cliff[:, 51:] = 1.4
    cliff[:, :30] = 1.4
    assert code(cliff, (4.0, 4.0, 0.0)) in (Pose.SUSPENSION, Pose.BELLY, Pose.TILT)


def test_rocks_tilt_a_rover_by_what_its_suspension_lets_through() -> None:
    rover = read_rover("perseverance")
    bump = flat()
    bump[48:53, 48:53] = 0.2  # under the left front wheel
    stands = settle(surface(ground(bump, 0.1), rover), [(3.91, 3.97, 0.0)])
    assert 0.0 < stands.pitch[0] < math.asin(0.2 / 2.2)
    assert 0.0 < stands.roll[0] < math.asin(0.2 / 2.1)
    assert stands.rocker[0] > 0.0


def test_poses_are_checked() -> None:
    made_ready = surface(ground(flat(), 0.1), read_rover("research"))
    with pytest.raises(
        ShapeError, match=r"poses must be \(n, 3\): x, y, heading, got shape \(3,\)"
    ):
        settle(made_ready, [1.0, 1.0, 0.0])
    with pytest.raises(InputError, match="poses must be finite numbers"):
        settle(made_ready, [[1.0, math.nan, 0.0]])
    assert len(settle(made_ready, np.empty((0, 3))).code) == 0


def test_a_rover_without_wheels_cannot_settle() -> None:
    with pytest.raises(
        SettingError, match="rover robot has no wheels to set onto the ground; give"
    ):
        surface(ground(flat(), 0.1), made(POINT))
