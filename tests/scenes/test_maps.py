"""Maps of free and blocked cells as ground: where a rover can stand, and what a body meets."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_array_equal

from rovernav.core import (
    Command,
    FileError,
    Frame,
    Mission,
    Observation,
    Outcome,
    SettingError,
)
from rovernav.learn import find_controller
from rovernav.rover import Reason, hazards, read_rover, standing
from rovernav.scenes import Ground, Scenario, Scene, set_scene
from rovernav.scenes._embodied import _walls
from rovernav.sim import simulate
from rovernav.terrain import Terrain, open_raster, read_terrain

CELL = 0.1


def map_file(folder: Path, blocked: np.ndarray, *, origin: str = "[-1.0, 2.0, 0.0]") -> Path:
    """map.yaml and map.pgm; `blocked` with row 0 south."""
    grey = np.where(blocked[::-1] != 0, 0, 254).astype(np.uint8)
    h, w = grey.shape
    (folder / "map.pgm").write_bytes(b"P5\n%d %d\n255\n" % (w, h) + grey.tobytes())
    text = f"image: map.pgm\nresolution: {CELL}\norigin: {origin}\nnegate: 0\n"
    (folder / "map.yaml").write_text(text + "occupied_thresh: 0.65\nfree_thresh: 0.196\n")
    return folder / "map.yaml"


def hall() -> np.ndarray:
    """12 x 8 m with walls around and one across it with a door of 1.4 m."""
    out = np.zeros((80, 120), np.uint8)
    out[[0, -1]] = 1
    out[:, [0, -1]] = 1
    out[:33, 60:63] = 1
    out[47:, 60:63] = 1
    return out


def scene_of(scenario: Scenario) -> Scene:
    ground = set_scene(scenario)
    assert isinstance(ground, Ground)
    return ground.scene


def test_a_map_is_level_ground_where_it_is_free(tmp_path: Path) -> None:
    blocked = hall()
    terrain = read_terrain(map_file(tmp_path, blocked))
    assert terrain.plain
    assert open_raster(tmp_path / "map.yaml").plain
    assert_array_equal(np.isnan(terrain.height), blocked != 0)
    assert terrain.span == (0.0, 0.0)
    assert terrain.frame.to_map(0.0, 0.0) == (-1.0, 2.0)
    assert terrain.frame.cell == CELL


def test_a_thin_wall_stays_where_cells_are_taken_together(tmp_path: Path) -> None:
    blocked = np.zeros((19, 23), np.uint8)
    blocked[:, 6] = blocked[0, 0] = 1
    path = map_file(tmp_path, blocked)
    for factor in (2, 4, 5):
        coarse = np.isnan(read_terrain(path, factor=factor).height)
        expected = np.zeros(coarse.shape, bool)
        for i, j in np.argwhere(blocked):
            expected[i // factor, j // factor] = True
        assert_array_equal(coarse, expected)


@settings(max_examples=40, deadline=None)
@given(arrays(np.uint8, (14, 17), elements=st.sampled_from([0, 0, 0, 0, 1])))
def test_only_the_radius_is_kept_from_what_stands_on_a_map(blocked: np.ndarray) -> None:
    if blocked.all():
        return
    heights = np.where(blocked != 0, np.nan, 0.0)
    frame = Frame(cell=CELL, shape=blocked.shape)
    terrain = Terrain.from_heights(heights, frame, name="map", source="a map", plain=True)
    rover = read_rover("research")
    rows, columns = np.nonzero(blocked)
    i, j = np.indices(blocked.shape)
    far = np.full(blocked.shape, np.inf)
    for row, column in zip(rows, columns, strict=True):
        far = np.minimum(far, CELL * np.hypot(i - row, j - column))
    for found in (standing(terrain, rover), hazards(terrain, rover).standing):
        assert_array_equal(found.blocked != 0, far <= rover.radius * (1 + 1e-12))
        assert_array_equal(found.reason == Reason.NO_DATA, blocked != 0)
        assert found.plain


@settings(max_examples=60, deadline=None)
@given(arrays(np.uint8, (9, 11), elements=st.integers(0, 1)))
def test_walls_cover_each_blocked_cell_once(blocked: np.ndarray) -> None:
    blocked[0, 0] = 0
    heights = np.where(blocked != 0, np.nan, 0.0)
    frame = Frame(cell=CELL, shape=blocked.shape)
    terrain = Terrain.from_heights(heights, frame, name="map", source="a map", plain=True)
    covered = np.zeros(blocked.shape, int)
    for wall in _walls(terrain):
        (x0, y0), (x1, y1) = wall.corners.min(axis=0), wall.corners.max(axis=0)
        a, b, c, d = (round(n / CELL) for n in (y0, y1, x0, x1))
        covered[a:b, c:d] += 1
    assert_array_equal(covered, blocked)


def test_a_body_drives_through_a_door_and_not_through_a_wall(tmp_path: Path) -> None:
    path = map_file(tmp_path, hall())
    outcomes = []
    for controller, y in (("neural", 6.0), ("goal-seeker", 8.0)):
        scenario = Scenario.model_validate(
            {"terrain": path, "from": (1.0, y), "to": (9.5, y), "rover": "research", "body": True,
             "controller": controller}
        )  # fmt: skip
        scene = scene_of(scenario)
        trace = simulate(scene.drive(find_controller(controller)), seed=0)
        outcomes.append(trace.ended())
    assert outcomes[0] is Outcome.REACHED
    assert outcomes[1] is not Outcome.REACHED
    shapes = scene.worlds.shapes
    assert shapes is not None
    assert len(shapes.radius) == 6


def test_a_body_that_heads_for_a_wall_collides(tmp_path: Path) -> None:
    class Blind:
        def start(self, mission: Mission, rng: np.random.Generator) -> Any:
            return None

        def act(self, observation: Observation, memory: Any) -> tuple[Command, Any]:
            return Command(twist=np.array([[0.3, 0.0, 0.0]])), memory

    scenario = Scenario.model_validate(
        {"terrain": map_file(tmp_path, hall()), "from": (3.0, 8.0), "to": (9.5, 8.0),
         "rover": "research", "body": True}
    )  # fmt: skip
    trace = simulate(scene_of(scenario).drive(Blind()), seed=0)
    assert trace.ended() is Outcome.COLLIDED
    front = trace.path()[-1][0] + read_rover("research").length / 2
    assert front == pytest.approx(6.0, abs=1e-6)  # where the wall begins, locally


def test_maps_that_are_no_ground_say_why(tmp_path: Path) -> None:
    turned = map_file(tmp_path, hall(), origin=f"[0.0, 0.0, {math.pi / 2}]")
    with pytest.raises(FileError, match=r"is turned by its origin's third number; set that to 0"):
        read_terrain(turned)
    path = map_file(tmp_path, np.ones((5, 5)))
    with pytest.raises(FileError, match=r"has no free cell; check its thresholds"):
        read_terrain(path)
    path = map_file(tmp_path, hall())
    with pytest.raises(SettingError, match=r"has its own cells of 0.1 m; leave --cell out"):
        read_terrain(path, cell=0.2)
    with pytest.raises(SettingError, match=r"which has its own order of rows; leave it out"):
        read_terrain(path, south_first=True)
    with pytest.raises(FileError, match=r"map.pgm is the picture of a map; give .*map.yaml"):
        read_terrain(path.with_suffix(".pgm"))
    scenario = tmp_path / "drive.yaml"
    scenario.write_text("from: [0, 0]\nto: [1, 0]\n")
    with pytest.raises(FileError, match=r"drive.yaml is no map, for it names no image; give a ROS"):
        read_terrain(scenario)
    path.unlink()
    with pytest.raises(FileError, match=r"map.pgm is the picture of a map; give its .yaml file"):
        read_terrain(path.with_suffix(".pgm"))


def test_stereo_needs_heights(tmp_path: Path) -> None:
    scenario = Scenario.model_validate(
        {"terrain": map_file(tmp_path, hall()), "from": (1.0, 6.0), "to": (3.0, 6.0),
         "rover": "research", "sensing": "stereo"}
    )  # fmt: skip
    with pytest.raises(SettingError, match=r"stereo sees heights, and map map.yaml says only"):
        set_scene(scenario)
