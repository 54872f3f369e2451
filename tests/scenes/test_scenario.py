from __future__ import annotations

import dataclasses
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError
from shapely import LineString, Point, Polygon

from rovernav.core import Outcome, RovernavError, SettingError
from rovernav.learn import find_controller
from rovernav.rover import read_rover, standing
from rovernav.scenes import (
    Ground,
    Hills,
    Scenario,
    Scene,
    generate,
    nearest_free,
    read_scenario,
    scenario_text,
    set_scene,
)
from rovernav.sim import Body, clearance, simulate
from tests.cli.runner import write_ground

number = st.floats(-9e4, 9e4)
point = st.tuples(number, number)
box = st.tuples(number, number, st.floats(0, 5e3), st.floats(0, 5e3)).map(
    lambda b: (b[0], b[1], b[0] + b[2], b[1] + b[3])
)


def scenario(start: Any, goal: Any, **keys: Any) -> Scenario:
    return Scenario.model_validate({"from": start, "to": goal, **keys})


def write(path: Path, **keys: Any) -> Path:
    path.write_text(yaml.safe_dump(keys))
    return path


@given(
    start=point,
    goal=point,
    boxes=st.lists(box, max_size=3),
    circles=st.lists(st.tuples(number, number, st.floats(1e-3, 1e3)), max_size=2),
    polygons=st.lists(st.lists(point, min_size=3, max_size=5), max_size=2),
    seed=st.integers(0, 2**63 - 1),
)
def test_a_written_scenario_reads_back(  # noqa: PLR0913
    tmp_path_factory, start, goal, boxes, circles, polygons, seed
) -> None:
    keys = {"boxes": boxes, "circles": circles, "polygons": polygons, "seed": seed}
    whole = scenario(start, goal, **keys)
    plain = whole.model_dump(mode="json", by_alias=True, exclude_none=True)
    path = write(tmp_path_factory.mktemp("s") / "drive.yaml", **plain)
    assert read_scenario(path) == whole
    path.write_text(scenario_text(whole))
    assert read_scenario(path) == whole


def test_files_lie_beside_the_scenario(tmp_path: Path) -> None:
    keys = {"terrain": "a/b.tif", "rover": "mine.yaml", "controller": "net.safetensors"}
    whole = read_scenario(write(tmp_path / "d.yaml", **{"from": [1, 2], "to": [3, 4]}, **keys))
    assert whole.terrain == tmp_path / "a/b.tif"
    assert whole.rover == str(tmp_path / "mine.yaml")
    assert whole.controller == str(tmp_path / "net.safetensors")


def test_a_scenario_with_a_body_is_whole_wherever_it_is_driven_from(tmp_path: Path) -> None:
    """Ground, soil, body and sensors in one file, and the files that it names beside it."""
    folder = tmp_path / "yard"
    folder.mkdir()
    np.save(folder / "ground.npy", np.zeros((90, 90), np.float32))
    soil = resources.files("rovernav.rover") / "soils" / "crust.yaml"
    (folder / "mine.yaml").write_text(soil.read_text(encoding="utf-8"))
    keys = {
        "terrain": "ground.npy", "cell": 0.1, "frame": "local", "rover": "research", "body": True,
        "soil": "mine.yaml", "slip_spread": 0.2, "sensing": "stereo+holes", "drift": True,
        "controller": "goal-seeker",
    }  # fmt: skip
    whole = read_scenario(write(folder / "d.yaml", **{"from": [2, 2], "to": [7, 7]}, **keys))
    assert whole.soil == str(folder / "mine.yaml")
    scene = set_scene(whole)
    assert isinstance(scene, Ground)
    assert isinstance(scene.scene.motion, Body)
    assert [each.name for each in scene.scene.sensors] == ["patch", "down", "tilt", "estimate"]
    missing = write(folder / "e.yaml", **{"from": [2, 2], "to": [7, 7]}, **keys | {"cell": None})
    with pytest.raises(RovernavError, match="or cell: METRES in a scenario"):
        set_scene(read_scenario(missing))
    walker = scenario([2, 2], [7, 7], generate=HILLS, frame="local", body=True)
    with pytest.raises(SettingError, match=r"paper-point has no wheels .* such as research"):
        set_scene(walker)


def test_names_are_names_and_absolute_paths_stay(tmp_path: Path) -> None:
    keys = {"terrain": "/a/b.tif", "rover": "research", "controller": "bassil"}
    whole = read_scenario(write(tmp_path / "d.yaml", **{"from": [1, 2], "to": [3, 4]}, **keys))
    assert (whole.terrain, whole.rover, whole.controller) == (
        Path("/a/b.tif"),
        "research",
        "bassil",
    )


@pytest.mark.parametrize(
    "keys",
    [
        {"from": "0,0"}, {"from": [0]}, {"from": [0, True]}, {"from": [0, "1"]}, {"from": {"x": 1}},
        {"from": [0, float("inf")]}, {"from": [0, 10**400]}, {"from": None}, {"to": [2e5, 0]},
        {"boxes": 3}, {"boxes": [[0, 0, 1]]}, {"boxes": [[2, 0, 1, 1]]},
        {"boxes": [[0, 0, 1e9, 1]]},
        {"seed": 1.5}, {"seed": True}, {"seed": -1}, {"seed": 2**63}, {"seed": "1"},
        {"time_limit_s": 0}, {"time_limit_s": 1e9}, {"time_limit_s": float("nan")},
        {"cell": 1.0}, {"frame": "pixel"}, {"frame": "Local"}, {"rover": 5}, {"controller": None},
        {"start": [0, 0]}, {"x": 1}, {"circles": [[0, 0]]}, {"circles": [[0, 0, -1]]},
        {"circles": [[1e9, 0, 1]]}, {"polygons": [[[0, 0], [1, 1]]]}, {"polygons": [[0, 0, 1]]},
        {"polygons": [[[0, 0], [1, 1], [1, float("nan")]]]}, {"rocks": 0.1},
        {"generate": {"side_m": 1}}, {"generate": {"craters": 2.5}}, {"generate": {"name": "sea"}},
        {"terrain": "a.tif", "generate": {}}, {"generate": {}, "cell": 1.0},
        {"terrain": "a.tif", "cell": 0}, {"terrain": ["a.tif"]}, {"heights": [0, 9]},
        {"generate": {}, "south_first": True}, {"terrain": "a.png", "heights": [9, 0]},
        {"terrain": "a.png", "heights": "0,9"}, {"terrain": "a.csv", "south_first": 1},
    ],
    ids=str,
)  # fmt: skip
def test_what_a_scenario_may_not_say(tmp_path: Path, keys: dict[str, Any]) -> None:
    path = write(tmp_path / "d.yaml", **{"from": [0, 0], "to": [5, 0], **keys})
    with pytest.raises(RovernavError) as caught:
        read_scenario(path)
    said = str(caught.value)
    assert said.startswith(f"{path}: ")
    assert "\n" not in said


@pytest.mark.parametrize("key", ["from", "to"])
def test_both_ends_are_needed(tmp_path: Path, key: str) -> None:
    keys = {name: [0, 0] for name in ("from", "to") if name != key}
    with pytest.raises(SettingError, match=f"the key '{key}' is missing; add it"):
        read_scenario(write(tmp_path / "d.yaml", **keys))


def test_python_is_refused_what_files_are() -> None:
    with pytest.raises(ValidationError, match="without a terrain"):
        scenario((0, 0), (1e6, 0))


def test_boxes_stand_on_flat_ground() -> None:
    scene = set_scene(scenario((-2, 1), (30, 1), boxes=[(3, 0, 4, 2)], seed=4))
    assert isinstance(scene, Scene)
    assert np.array_equal(scene.worlds.boxes, [[3, 0, 4, 2]])
    assert np.array_equal(scene.worlds.bounds, [[-60, -60, 60, 60]])
    assert scene.mission.time_limit == pytest.approx(5 * 32 / 0.8287)


def test_the_time_limit_is_the_scenarios() -> None:
    scene = set_scene(scenario((0, 0), (1, 0), time_limit_s=7))
    assert isinstance(scene, Scene)
    assert scene.mission.time_limit == 7.0


@pytest.mark.parametrize(
    ("frame", "start", "goal"),
    [("crs", (-5.25, -8.25), (20.25, -6.75)), ("local", (1.75, 2.75), (27.25, 4.25)),
     ("pixel", (3, 34), (54, 31))],
)  # fmt: skip
def test_frames_name_the_same_places(tmp_path: Path, frame: Any, start: Any, goal: Any) -> None:
    terrain = write_ground(tmp_path / "ground.tif")
    scene = set_scene(scenario(start, goal, terrain=terrain, frame=frame))
    assert isinstance(scene, Ground)
    assert np.array_equal(scene.scene.mission.start[0, :2], (1.75, 2.75))
    assert np.array_equal(scene.scene.mission.goal[0], (27.25, 4.25))


def test_a_rover_with_a_size_keeps_its_radius_off_what_is_drawn() -> None:
    whole = scenario((0, 0), (12, 0), boxes=[(4, -1, 7, 2)], circles=[(2, 3, 1)], rover="research")
    scene = set_scene(whole)
    assert isinstance(scene, Scene)
    radius = read_rover("research").radius
    shapes = scene.worlds.shapes_of()
    assert [shape.radius for shape in shapes] == pytest.approx([radius, 1 + radius])
    assert np.array_equal(shapes[0].corners, [[4, -1], [7, -1], [7, 2], [4, 2]])
    assert len(scene.worlds.boxes) == 0


def test_the_neural_driver_goes_round_what_is_drawn_on_flat_ground() -> None:
    around = [[[4, -2], [6, -2], [6, 2], [4, 2], [5, 0]]]
    whole = scenario((0, 0), (12, 0), polygons=around, circles=[(8, 1, 1)], rover="research")
    scene = set_scene(whole)
    assert isinstance(scene, Scene)
    trace = simulate(scene.drive(find_controller("neural")))
    assert trace.ended() is Outcome.REACHED
    gap = clearance(trace.path(), scene.worlds)
    outlines = [Polygon(around[0]), Point(8, 1).buffer(1, quad_segs=256)]
    there = min(LineString(trace.path()).distance(each) for each in outlines)
    assert gap == pytest.approx(there - read_rover("research").radius, abs=1e-3)
    assert gap > 0
    assert trace.length[0] > 12.2


def test_generated_ground_is_the_seeds_and_takes_obstacles_in_its_frame() -> None:
    keys = {"generate": {"side_m": 20, "relief_m": 0, "craters": 0}, "frame": "pixel"}
    disc = [(50, 60, 1.5)]  # column 50, row 60 from the top of 100 rows of 0.2 m
    one, same, other = (
        set_scene(scenario((10, 60), (90, 60), circles=disc, seed=seed, **keys))
        for seed in (3, 3, 4)
    )
    assert isinstance(one, Ground)
    assert isinstance(same, Ground)
    assert isinstance(other, Ground)
    assert one.terrain.frame.extent == (20.0, 20.0)
    assert np.array_equal(one.terrain.height, same.terrain.height)
    (shape,) = one.scene.worlds.shapes_of()
    assert np.allclose(shape.corners, [[10.1, 7.9]])
    assert simulate(one.scene.drive(find_controller("bassil"))).ended() is Outcome.COLLIDED


def test_hills_of_two_seeds_differ() -> None:
    a, b = (generate(Hills.model_validate({"side_m": 10.0}), seed=seed).height for seed in (0, 1))
    assert not np.array_equal(a, b)


def test_the_text_of_a_scenario_says_what_matters_and_no_more(tmp_path: Path) -> None:
    whole = scenario((5, 5), (20, 20), generate={"relief_m": 2}, circles=[(1e-5, 2, 3)], rocks=0.05)
    text = scenario_text(whole)
    path = tmp_path / "drive.yaml"
    path.write_text(text)
    assert read_scenario(path) == whole
    assert "time_limit" not in text
    assert "craters: 40" in text
    assert "seed: 0" in text


def test_the_nearest_free_place_is_free_and_nearest() -> None:
    terrain = generate(Hills.model_validate({"side_m": 20.0, "relief_m": 8.0}), seed=2)
    where = standing(terrain, read_rover("research"))
    assert where.share > 0.1
    x, y = nearest_free(where, (10.0, 10.0))
    free = np.argwhere(where.blocked == 0) + 0.5
    gaps = np.hypot(free[:, 1] * 0.2 - 10.0, free[:, 0] * 0.2 - 10.0)
    assert np.hypot(x - 10.0, y - 10.0) == pytest.approx(gaps.min())
    nowhere = dataclasses.replace(where, blocked=np.ones_like(where.blocked))
    with pytest.raises(SettingError, match="nowhere on this ground"):
        nearest_free(nowhere, (1.0, 1.0))


HILLS = {"name": "hills", "side_m": 20.0, "cell_m": 0.2, "relief_m": 0.3, "craters": 0}


def test_a_body_goes_with_ground_and_its_keys_with_a_body() -> None:
    message = (
        "a body goes with a terrain or generated ground, and there is none; write terrain: FILE"
    )
    with pytest.raises(ValidationError, match=message):
        scenario([0, 0], [5, 5], body=True)
    for key, item in (("soil", "crust"), ("slip_spread", 0.2)):
        with pytest.raises(ValidationError, match="that goes with a body; write body: true"):
            scenario([3, 3], [9, 9], generate=HILLS, frame="local", **{key: item})


def test_a_body_meets_obstacles_as_they_are_and_its_sensors_see_them_grown() -> None:
    keys: dict[str, Any] = {
        "generate": HILLS, "frame": "local", "rover": "research", "circles": [[9.0, 10.0, 1.0]],
    }  # fmt: skip
    point = set_scene(scenario([4, 10], [16, 10], **keys))
    body = set_scene(scenario([4, 10], [16, 10], **keys, body=True, soil="crust", slip_spread=0.1))
    assert isinstance(point, Ground)
    assert isinstance(body, Ground)
    assert point.scene.worlds.shapes_of()[0].radius > 1.3
    assert body.scene.worlds.shapes_of()[0].radius == 1.0
    grid = body.scene.worlds.grid
    assert grid is not None
    assert grid.blocked[50, 45 - 6] == 1  # 1.2 m off its middle: within the rover's radius
    assert grid.blocked[50, 45 - 8] == 0
    trace = simulate(body.scene.drive(find_controller("goal-seeker")), seed=0)
    assert trace.energy is not None
    far = np.hypot(*(trace.path() - (9.0, 10.0)).T).min()
    assert trace.ended() is not Outcome.COLLIDED or far == pytest.approx(1.25, abs=0.05)
    assert read_rover("research").radius > 0.3
