from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from numpy.testing import assert_allclose

from rovernav.sim import load_trace
from rovernav.terrain import read_terrain
from tests.cli.runner import run, tell, write_ground

ACROSS = ("--from", "-5,-8", "--to", "20,-6.5")
BLOCKED = ("--from", "6,-1.25", "--to", "20,-1.25")


@pytest.fixture
def ground(here: Path) -> str:
    write_ground(here / "ground.tif")
    return "ground.tif"


def test_json_says_how_it_went(ground: str) -> None:
    report = tell("drive", "--terrain", ground, *ACROSS)
    assert report["outcome"] == "reached"
    assert_allclose(report["straight_m"], np.hypot(25.0, 1.5), rtol=1e-12)
    assert report["straight_m"] <= report["length_m"] < 1.1 * report["straight_m"]
    assert report["time_s"] == report["steps"] > 25 / 0.83
    assert 0.0 < report["max_slope_deg"] < 20.0
    assert report["closest_m"] > 0.5
    assert_allclose(report["start_map"], (-5.0, -8.0), rtol=0, atol=1e-12)
    assert_allclose(report["end_map"], (20.0, -6.5), rtol=0, atol=1e-9)


def test_a_wall_in_the_way_is_a_result_unless_the_goal_is_required(ground: str) -> None:
    words = ("drive", "--terrain", ground, *BLOCKED)
    report = tell(*words)
    assert report["outcome"] == "collided"
    assert report["closest_m"] == 0.0
    assert tell(*words, "--require", "reached", code=1)["outcome"] == report["outcome"]
    assert run(*words, "--require", report["outcome"]).code == 0


def test_the_three_frames_name_the_same_places(ground: str) -> None:
    poses = [
        load_trace(Path(tell("drive", "--terrain", ground, *words)["files"][3])).pose
        for words in (
            ("--from", "-5.25,-8.25", "--to", "20.25,-6.75"),
            ("--from=1.75,2.75", "--to=27.25,4.25", "--frame", "local"),
            ("--from", "3,34", "--to", "54,31", "--frame", "pixel"),
        )
    ]
    assert_allclose(poses[0][0, 0, :2], (1.75, 2.75), rtol=0, atol=0)
    assert np.array_equal(poses[0], poses[1])
    assert np.array_equal(poses[0], poses[2])


def test_csv_and_geojson_are_in_the_terrains_coordinates(ground: str) -> None:
    files = tell("drive", "--terrain", ground, *ACROSS)["files"]
    trace, terrain = load_trace(Path(files[3])), read_terrain(ground)
    with Path(files[1]).open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == trace.steps[0] + 1
    for name, wanted in (("map_x", (-5.0, 20.0)), ("map_y", (-8.0, -6.5))):
        assert_allclose([float(rows[k][name]) for k in (0, -1)], wanted, rtol=0, atol=1e-9)
    local = np.array([[float(row["x_m"]), float(row["y_m"])] for row in rows])
    assert np.array_equal(local, trace.path())
    heights = [float(row["elevation_m"]) for row in rows]
    assert_allclose(heights, terrain.elevation_at(*trace.path().T), rtol=0, atol=0)

    line, start, goal = json.loads(Path(files[2]).read_text())["features"]
    on_map = trace.path() + np.array([-7.0, -11.0])
    assert_allclose(line["geometry"]["coordinates"], on_map, rtol=0, atol=1e-9)
    assert start["geometry"]["coordinates"] == [-5.0, -8.0]
    assert goal["geometry"]["coordinates"] == [20.0, -6.5]
    assert "UTM zone 33N" in json.loads(Path(files[2]).read_text())["crs_wkt"]


def scenario(**keys: Any) -> Path:
    path = Path("drive.yaml")
    path.write_text(yaml.safe_dump(keys))
    return path


def test_a_scenario_file_is_the_same_options(ground: str) -> None:
    words = ("--terrain", ground, *ACROSS, "--seed", "5")
    tell("drive", *words, "--out", "a")
    keys = {"terrain": ground, "from": [-5, -8], "to": [20, -6.5], "seed": 5}
    tell("drive", scenario(**keys), "--out", "b")
    assert Path("a/trace.npz").read_bytes() == Path("b/trace.npz").read_bytes()
    assert Path("a/drive.png").read_bytes() == Path("b/drive.png").read_bytes()


def test_a_scenario_file_names_files_beside_itself(ground: str) -> None:
    tell("paper", "--out", "sub")
    write_ground(Path("sub/here.tif"))
    keys = {"terrain": "here.tif", "from": [-5, -8], "to": [20, -6.5],
            "controller": "network.safetensors"}  # fmt: skip
    scenario(**keys).replace("sub/drive.yaml")
    report = tell("drive", "sub/drive.yaml")
    assert report["settings"]["terrain"] == "sub/here.tif"
    assert report["settings"]["controller"] == "sub/network.safetensors"
    assert report["length_m"] == tell("drive", "--terrain", ground, *ACROSS)["length_m"]


def test_options_overrule_a_scenario_file(ground: str) -> None:
    keys = {"terrain": ground, "from": [-5, -8], "to": [20, -6.5], "seed": 5}
    assert tell("drive", scenario(**keys))["settings"]["seed"] == 5
    assert tell("drive", scenario(**keys), "--seed", "0")["settings"]["seed"] == 0


@pytest.mark.parametrize("frame", ["crs", "pixel"])
def test_the_settings_in_a_trace_repeat_the_drive(ground: str, frame: str) -> None:
    ends = ACROSS if frame == "crs" else ("--from", "3,34", "--to", "54,31", "--frame", "pixel")
    tell("drive", "--terrain", ground, *ends, "--out", "a")
    settings = dict(load_trace(Path("a/trace.npz")).settings)
    tell("drive", scenario(**settings), "--out", "b")
    assert Path("a/trace.npz").read_bytes() == Path("b/trace.npz").read_bytes()


def test_the_settings_of_a_named_scenario_repeat_it() -> None:
    tell("drive", "hills-v1", "--seed", "3", "--out", "a")
    settings = load_trace(Path("a/trace.npz")).settings
    tell("drive", settings["scenario"], "--seed", settings["seed"], "--controller",
         settings["controller"], "--out", "b")  # fmt: skip
    assert Path("a/trace.npz").read_bytes() == Path("b/trace.npz").read_bytes()
    assert settings["seed"] == 3


def test_boxes_make_the_papers_test_case() -> None:
    keys = {"boxes": [[4.365, -1, 7.365, 3.75]], "from": [0, 0], "to": [11.73, 0]}
    boxes, named = tell("drive", scenario(**keys)), tell("drive", "bassil-v1")
    assert (boxes["length_m"], boxes["steps"]) == (named["length_m"], named["steps"])
    assert boxes["closest_m"] == named["closest_m"]
    assert boxes["max_slope_deg"] is None


def test_nothing_to_touch_and_nowhere_to_go() -> None:
    report = tell("drive", scenario(**{"from": [-2, -1], "to": [-2, -1]}))
    assert (report["outcome"], report["steps"], report["length_m"]) == ("reached", 0, 0.0)
    assert report["closest_m"] is None
    said = run("drive", "drive.yaml")
    assert "Drove 0.00 m for 0.00 m in a straight line." in said.out
    assert "Closest" not in said.out


def test_a_rover_file_of_ones_own(ground: str) -> None:
    preset = Path(__file__).parents[2] / "src/rovernav/rover/presets/paper-point.yaml"
    weak = preset.read_text().replace("max_slope_deg: 20.0", "max_slope_deg: 1.0")
    Path("weak.yaml").write_text(weak)
    words = ("drive", "--terrain", ground, *ACROSS)
    assert tell(*words)["outcome"] == "reached"
    said = run(*words, "--rover", "weak.yaml")
    assert said.code == 2
    assert "cannot stand at the start: the slope is 2.6 deg, its limit 1.0 deg" in said.err


def test_a_npy_terrain_needs_its_cell() -> None:
    np.save("flat.npy", np.zeros((30, 50)))
    ends = ("--from", "2,3", "--to", "20,3", "--frame", "local")
    assert run("drive", "--terrain", "flat.npy", *ends).code == 2
    assert tell("drive", "--terrain", "flat.npy", "--cell", "0.5", *ends)["outcome"] == "reached"


def test_dollars_and_foreign_letters_in_names(ground: str) -> None:
    Path(ground).rename("o$_{$ ö.tif")
    assert run("drive", "--terrain", "o$_{$ ö.tif", *ACROSS, "--out", "ö $").code == 0
    assert Path("ö $/drive.png").exists()


def test_words(ground: str) -> None:
    said = run("drive", "--terrain", ground, *BLOCKED)
    assert said.err == ""
    lines = said.out.splitlines()
    assert lines[0].startswith("ground: ")
    assert lines[1].startswith("Drove ")
    assert lines[1].split(" for ")[1].startswith("14.00 m in a straight line, ")
    assert any(line.startswith("Ended ") for line in lines)
    assert "Closest approach" in said.out
    assert "Steepest ground" in said.out
    assert max(map(len, lines)) <= 80


def test_a_body_tells_energy_tilt_and_slip(ground: str) -> None:
    words = ("drive", "--terrain", ground, *ACROSS, "--rover", "research", "--controller",
             "goal-seeker")  # fmt: skip
    point = tell(*words)
    body = tell(*words, "--body", "--soil", "loose-sand", "--out", "body")
    assert [point[key] for key in ("energy_kj", "worst_tilt_deg", "mean_slip", "soil")] == [
        None
    ] * 4
    assert body["outcome"] == "reached"
    assert body["time_s"] > point["time_s"]  # it slips
    assert 0.015 * body["time_s"] < body["energy_kj"] < 0.1 * body["time_s"]
    assert 1.0 < body["worst_tilt_deg"] < 4.0  # the plane's 1.3 degrees, and stones of the wall
    assert 0.04 < body["mean_slip"] <= body["worst_slip"] < 0.2
    assert body["soil"] == "loose-sand"
    said = run("inspect", "body/trace.npz")
    assert f"energy      {body['energy_kj']:.3f} kJ" in said.out
    assert "worst tilt" in said.out
    assert tell("inspect", "body/trace.npz")["body_of_first"]["energy_kj"] == body["energy_kj"]


def test_a_body_is_stopped_by_the_wall_itself(ground: str) -> None:
    words = ("drive", "--terrain", ground, *BLOCKED[:1], "4,-1.25", *BLOCKED[2:], "--rover",
             "research", "--controller", "goal-seeker")  # fmt: skip
    report = tell(*words, "--body")
    assert report["outcome"] in ("collided", "timed_out")
    assert report["energy_kj"] > 0.0


def test_a_body_needs_wheels_ground_and_the_word(ground: str) -> None:
    words = ("drive", "--terrain", ground, *ACROSS)
    said = run(*words, "--body")
    assert (said.code, said.out) == (2, "")
    assert "rover paper-point has no wheels to set onto the ground" in said.err
    said = run(*words, "--rover", "research", "--soil", "crust")
    assert said.code == 2
    assert "that goes with a body" in said.err
    said = run(*words, "--rover", "research", "--body", "--soil", "custard")
    assert said.code == 2
    assert "custard" in said.err
    said = run("drive", "bassil-v1", "--body")
    assert "--body does not go with the named scenario bassil-v1" in said.err
