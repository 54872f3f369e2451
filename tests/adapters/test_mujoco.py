"""MuJoCo's rover: masses, places, joints and ground are ours, and it comes to rest as ours does."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from typing import Any
from xml.etree import ElementTree as Xml

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.adapters import Physics
from rovernav.adapters._mujoco_model import heights, middle_mass, mjcf, wheel_names, wheel_places
from rovernav.core import Frame, InputError, MissingExtraError, SettingError, ShapeError
from rovernav.rover import Rover, read_rover, settle, surface
from rovernav.terrain import Terrain

SIX, FRONT, FOUR, RIGID = "perseverance", "sojourner", "research", "jackal"
DEGREE = math.pi / 180.0


@pytest.fixture(scope="module")
def mujoco():
    """MuJoCo, or a skip."""
    return pytest.importorskip("mujoco", reason="needs the extra 'physics'")


def _ground(name: str = "hill", *, cell: float = 0.1, side: float = 12.0) -> Terrain:
    """Flat, tilted or hilly ground, nothing the same in two directions."""
    count = round(side / cell)
    y, x = (np.indices((count, count + 7)) + 0.5) * cell
    z = {
        "flat": 0.0 * x,
        "tilted": 0.15 * x - 0.1 * y,
        "hill": 0.25 * np.sin(x / 1.9) * np.cos(y / 1.6 + 0.3) + 0.06 * x,
    }[name]
    frame = Frame(cell=cell, shape=z.shape)
    return Terrain.from_heights(z + 1000.0, frame, name=name, source="test")


def _rover(name: str) -> Rover:
    """A preset; the rigid one leans on its rear wheels, as settling takes it to."""
    rover = read_rover(name)
    if name != RIGID:
        return rover
    assert rover.chassis is not None
    return replace(rover, chassis=replace(rover.chassis, mass_x=-0.02))


def _poses(count: int) -> np.ndarray:
    rng = np.random.default_rng(5)
    return np.column_stack([rng.uniform(3.0, 9.0, (count, 2)), rng.uniform(-3.1, 3.1, count)])


class TestModel:
    """What is written for MuJoCo; MuJoCo itself is not needed."""

    def test_wheels_are_listed_from_front_to_rear_left_side_first(self):
        rover = read_rover(SIX)
        x, y = wheel_places(rover)
        assert wheel_names(rover)[:3] == ["wheel_left_0", "wheel_left_1", "wheel_left_2"]
        assert x[0] > x[1] > x[2]
        assert (y[:3] > 0.0).all()
        assert (y[3:] < 0.0).all()

    def test_mass_is_as_high_as_tips_the_rover_at_its_static_tilt(self):
        rover = read_rover(SIX)
        assert rover.chassis is not None
        high = middle_mass(rover)[1] + rover.wheel_radius
        assert_allclose(math.atan2(0.5 * rover.track, high), rover.chassis.static_tilt, rtol=1e-12)

    def test_heights_span_0_to_1_from_south_to_north(self):
        field = heights(_ground("tilted"))
        assert (field.min(), field.max()) == (0.0, 1.0)
        assert field[0, -1] == 1.0  # the south-east corner is the highest

    def test_every_suspension_is_written(self):
        for name, joints in ((SIX, 16), (FRONT, 16), (FOUR, 12), (RIGID, 10)):
            root = Xml.fromstring(mjcf(_ground(), read_rover(name)))
            assert len(list(root.iter("joint"))) - len(root.findall("equality/joint")) == joints
            assert len(root.findall("equality/joint")) == (name != RIGID)

    def test_ground_with_holes_is_refused(self):
        height = np.zeros((20, 20))
        height[3, 4] = np.nan
        frame = Frame(cell=0.1, shape=(20, 20))
        holed = Terrain.from_heights(height, frame, name="holed", source="test")
        with pytest.raises(InputError, match=r"holed: 0\.25% of the heights are missing"):
            mjcf(holed, read_rover(SIX))

    def test_a_rover_without_mass_is_refused(self):
        with pytest.raises(SettingError, match="paper-point says nothing of its mass and wheels"):
            mjcf(_ground(), read_rover("paper-point"))

    def test_unknown_words_name_the_known_ones(self):
        with pytest.raises(SettingError, match=r"unknown wheels 'cube'.*Allowed: cylinder, sphere"):
            mjcf(_ground(), read_rover(SIX), wheels="cube")  # pyright: ignore[reportArgumentType]
        with pytest.raises(
            SettingError, match=r"unknown steering 'corner'; did you mean 'corners'"
        ):
            mjcf(_ground(), read_rover(SIX), steering="corner")  # pyright: ignore[reportArgumentType]


def test_without_the_extra_one_sentence_says_what_to_install(monkeypatch):
    for name in ("mujoco", "mujoco.batch"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(MissingExtraError, match=r"pip install 'rovernav\[physics\]'"):
        Physics(_ground("flat"), read_rover(SIX))


@pytest.mark.parametrize("name", [SIX, FRONT, FOUR, RIGID])
def test_masses_and_wheels_are_the_rovers(mujoco, name):
    rover = _rover(name)
    model = Physics(_ground("flat"), rover)._loose
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert rover.mobility is not None
    assert_allclose(model.body("base").subtreemass, rover.mobility.mass, rtol=1e-9)
    assert_allclose(data.subtree_com[1], [middle_mass(rover)[0], 0.0, middle_mass(rover)[1]],
                    atol=1e-9)  # fmt: skip
    x, y = wheel_places(rover)
    for k, wheel in enumerate(wheel_names(rover)):
        assert_allclose(data.body(wheel).xpos, [x[k], y[k], 0.0], atol=1e-9)


def test_joints_turn_as_ours_do(mujoco):
    """The wheels of turned arms are where the settling kernel has them."""
    from rovernav.kernels.settle import wheel_places as ours

    for name in (SIX, FRONT):
        rover = read_rover(name)
        physics = Physics(_ground("flat"), rover)
        stands = physics.rest([[6.0, 6.0, 0.3]])
        angles = {"rocker": 0.1, "bogie_left": -0.07, "bogie_right": 0.2}
        turned = replace(stands, pitch=np.zeros(1), roll=np.zeros(1), pose=np.zeros((1, 3)),
                         z=np.array([physics.terrain.offset]),
                         **{key: np.array([angle]) for key, angle in angles.items()})  # fmt: skip
        data = mujoco.MjData(physics._loose)
        data.qpos[:] = physics._joints(turned)[0]
        mujoco.mj_kinematics(physics._loose, data)
        at = np.empty((6, 3))
        left, bogie, other = angles.values()
        ours(rover.chassis_array(), left, bogie, other, at)
        seen = np.array([data.body(wheel).xpos for wheel in wheel_names(rover)])
        # The kernel begins each side with the wheel on the rocker.
        order = [2, 1, 0, 5, 4, 3] if name == FRONT else list(range(6))
        assert_allclose(seen[order], at, atol=1e-9)


def test_the_ground_is_where_ours_is(mujoco: Any):
    terrain = _ground("hill")
    physics = Physics(terrain, read_rover(SIX))
    data = mujoco.MjData(physics._loose)
    mujoco.mj_forward(physics._loose, data)
    hit = np.zeros(1, np.int32)
    for row, column in ((5, 100), (80, 9), (60, 60)):
        x, y = terrain.frame.centre_of(row, column)
        way = mujoco.mj_ray(physics._loose, data, np.array([x, y, 50.0]),
                            np.array([0.0, 0.0, -1.0]), None, 1, -1, hit)  # fmt: skip
        assert_allclose(50.0 - way, terrain.height[row, column], atol=1e-4)


@pytest.mark.parametrize("name", [SIX, FRONT, FOUR, RIGID])
@pytest.mark.parametrize("ground", ["flat", "tilted", "hill"])
def test_it_rests_as_ours_does(mujoco, name, ground):
    """Within 0.5 deg and a hundredth of a wheel's radius plus what posts cut off its top."""
    del mujoco
    rover = _rover(name)
    cell = 0.4 * rover.wheel_radius if name == SIX else 0.05
    terrain = _ground(ground, cell=cell)
    poses = _poses(6)
    rests, ours = Physics(terrain, rover).rest(poses), settle(surface(terrain, rover), poses)
    assert rests.still.all()
    assert not rests.belly.any()
    assert (rests.wheels == (3 if name == RIGID and ground == "hill" else len(wheel_names(rover)))
            ).all()  # fmt: skip
    assert_allclose(rests.pose, poses, atol=1e-4)
    # A sphere on facets between posts stands up to c^2 / 8 r higher than on the posts alone.
    slack = 0.01 * rover.wheel_radius + cell**2 / (8.0 * rover.wheel_radius)
    assert_allclose(rests.z, ours.z, atol=slack if ground != "flat" else 3e-4)
    loose = 0.02 * DEGREE if ground == "flat" else 0.5 * DEGREE
    for angle in ("pitch", "roll", "rocker", "bogie_left", "bogie_right"):
        assert_allclose(getattr(rests, angle), getattr(ours, angle), atol=loose, err_msg=angle)


def _facets(terrain: Terrain, times: int) -> Terrain:
    """More posts on the two triangles that MuJoCo spans between four, split from south-west."""
    (h, w), z = terrain.frame.shape, terrain.height.astype(float)
    at = [np.clip((np.arange(n * times) + 0.5) / times - 0.5, 0.0, n - 1.0) for n in (h, w)]
    v, u = np.meshgrid(*at, indexing="ij")
    i, j = np.minimum(v.astype(int), h - 2), np.minimum(u.astype(int), w - 2)
    v, u = v - i, u - j
    a, b, c, d = z[i, j], z[i, j + 1], z[i + 1, j], z[i + 1, j + 1]
    heights = np.where(u >= v, a + u * (b - a) + v * (d - b), a + v * (c - a) + u * (d - c))
    frame = Frame(cell=terrain.frame.cell / times, shape=heights.shape)
    return Terrain.from_heights(heights + terrain.offset, frame, name="facets", source="test")


def test_settling_on_its_facets_comes_as_near_as_posts_are_dense(mujoco, rng):
    """Rough ground: what differs is what settling cannot know between posts, and vanishes."""
    del mujoco
    rover, smooth = read_rover(SIX), _ground("hill")
    heights = smooth.height + smooth.offset + rng.normal(0.0, 0.02, smooth.frame.shape)
    terrain = Terrain.from_heights(heights, smooth.frame, name="rough", source="test")
    rests, worst = Physics(terrain, rover).rest(poses := _poses(8)), []
    for times in (1, 3, 9):  # odd, so that the old posts are among the new ones
        ours = settle(surface(_facets(terrain, times), rover), poses)
        off = [
            np.abs(getattr(rests, part) - getattr(ours, part)).max() for part in ("pitch", "roll")
        ]
        worst.append((max(off), np.abs(rests.z - ours.z).max()))
    angle, height = np.array(worst).T
    assert (np.diff(angle) < 0.0).all()
    assert (np.diff(height) < 0.0).all()
    assert angle[-1] < 0.1 * DEGREE
    assert height[-1] < 2e-3


def test_commands_are_followed(mujoco):
    """A metre ahead is a metre; an arc turns as far as told where corners are steered."""
    del mujoco
    terrain, rover = _ground("flat"), read_rover(SIX)
    rover = replace(rover, speed=0.25)
    twists = np.tile([0.25, 0.1], (1, 4, 1))
    stands = Physics(terrain, rover, steering="corners").drive(
        [[6.0, 6.0, 0.5]], twists, period=1.0
    )
    assert len(stands) == 5
    x, y, heading = stands[-1].pose[0]
    assert_allclose(heading, 0.9, atol=0.02)
    chord = 2.0 * 2.5 * math.sin(0.2)
    assert_allclose((x - 6.0, y - 6.0), chord * np.array([math.cos(0.7), math.sin(0.7)]), atol=0.05)


def test_rows_do_not_see_each_other(mujoco):
    del mujoco
    physics, poses = Physics(_ground("hill"), read_rover(SIX), threads=2), _poses(3)
    together = physics.rest(poses)
    for row in range(3):
        alone = physics.rest(poses[row : row + 1])
        assert (alone.z[0], alone.pitch[0]) == (together.z[row], together.pitch[row])


def test_what_does_not_fit_is_told(mujoco):
    del mujoco
    physics = Physics(_ground("flat"), read_rover(SIX))
    with pytest.raises(InputError, match=r"pose at \(0\.5, 6\) m is nearer than .* to the edge"):
        physics.rest([[0.5, 6.0, 0.0]])
    with pytest.raises(ShapeError, match=r"twists must be \(1, k, 2\).*got shape \(4, 2\)"):
        physics.drive([[6.0, 6.0, 0.0]], np.zeros((4, 2)), period=1.0)
