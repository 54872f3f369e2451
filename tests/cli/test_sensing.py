"""`rovernav drive` with sensors that err, estimates that drift, and routes."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from rovernav.core import SettingError
from rovernav.mapping import ElevationMapper, LocalMapper
from rovernav.rover import read_rover
from rovernav.scenes import bassil_scene, ground_scene, sensed
from rovernav.sim import NoisyFan, Odometry, Patch, load_trace
from rovernav.terrain import read_terrain
from tests.cli.runner import run, tell, write_ground

ACROSS = ("--from", "-5,-8", "--to", "18,-6.5")
NEURAL = ("--controller", "goal-seeker", "--rover", "research")


@pytest.fixture
def ground(here: Path) -> str:
    write_ground(here / "ground.tif")
    return "ground.tif"


@pytest.mark.parametrize("sensing", ["lidar", "sonar", "stereo"])
def test_scenes_are_seen_with_sensors_that_err(sensing: str, ground: str) -> None:
    terrain = read_terrain(Path(ground))
    ideal = ground_scene(terrain, read_rover("research"), (2.0, 3.0), (25.0, 3.0))
    scene = sensed(ideal, sensing, drift=True).scene
    eyes, odometry = scene.sensors
    assert isinstance(eyes, Patch if sensing == "stereo" else NoisyFan)
    assert isinstance(odometry, Odometry)
    assert isinstance(scene.mapper, ElevationMapper if sensing == "stereo" else LocalMapper)
    assert sensed(ideal, "ideal") is ideal


def test_a_drive_by_drifting_odometry_is_told_apart_and_repeated(ground: str) -> None:
    words = ("drive", "--terrain", ground, *ACROSS, *NEURAL, "--sensing", "lidar", "--drift")
    first = tell(*words, "--out", "a")
    trace = load_trace(Path(first["files"][3]))
    assert {"beams", "estimate"} <= set(trace.channels)
    assert first["settings"]["sensing"] == "lidar"
    assert first["settings"]["drift"] is True
    again = load_trace(Path(tell(*words, "--out", "b")["files"][3]))
    assert np.array_equal(trace.pose, again.pose)
    other = load_trace(Path(tell(*words, "--seed", "4", "--out", "c")["files"][3]))
    assert not np.array_equal(trace.channels["estimate"], other.channels["estimate"])


def test_a_rover_led_astray_says_so_and_by_how_much(ground: str) -> None:
    words = ("drive", "--terrain", ground, *ACROSS, *NEURAL, "--drift", "--out", "a")
    told = tell(*words)
    trace = load_trace(Path(told["files"][3]))
    believed = trace.believed()
    assert told["outcome"] == "astray"
    assert believed is not None
    assert told["believed_end"] == pytest.approx(believed[-1].tolist())
    assert told["believed_to_goal_m"] <= trace.mission.goal_radius < told["to_goal_m"]
    assert told["believed_off_m"] == pytest.approx(np.hypot(*(believed[-1] - trace.path()[-1])))
    said = run(*words).out
    assert f"its odometry was {told['believed_off_m']:.2f} m off" in said
    assert "believed itself at the goal and stopped" in said
    run("export", told["files"][3], "--to", "page.html")
    page = Path("page.html").read_text(encoding="utf-8")
    found = re.search(r'<script id="data" type="application/json">(.*?)</script>', page, re.DOTALL)
    assert found is not None
    data = json.loads(found[1])
    was, thought = data["rovers"]
    assert was["colour"] != thought["colour"]
    assert thought["count"] == len(believed)
    assert f"at last {told['believed_off_m']:.1f} m off" in data["words"]
    ideal = tell(*words[: words.index("--drift")])
    assert ideal["believed_off_m"] is None


def test_a_route_is_driven_from_its_start_to_its_goal_where_no_ends_are_given(
    ground: str,
) -> None:
    way = ("--from", "6,-1.25", "--to", "20,-1.25")
    told = tell("route", ground, *way, "--rover", "research", "--out", "route", "--no-picture")
    line = next(str(name) for name in told["files"] if str(name).endswith("route.geojson"))
    words = ("drive", "--terrain", ground, *NEURAL, "--route", line)
    named, bare = tell(*words, *way), tell(*words)
    assert bare["start_map"] == pytest.approx([6.0, -1.25], abs=1e-5)
    assert bare["outcome"] == named["outcome"] == "reached"
    assert bare["straight_m"] == pytest.approx(14.0, abs=1e-5)
    half = run(*words, "--from", "6,-1.25")
    assert (half.code, half.err.splitlines()[0]) == (2, "error: --terrain needs --to X,Y as well")


def test_a_round_trip_is_not_said_to_be_driven(ground: str) -> None:
    ends = ("--from", "6,-1.25", "--via", "20,-1.25", "--to", "6,-1.0")
    told = tell("route", ground, *ends, "--rover", "research", "--out", "route", "--no-picture")
    line = next(str(name) for name in told["files"] if str(name).endswith("route.geojson"))
    done = run("drive", "--terrain", ground, *NEURAL, "--route", line, "--out", "drive")
    assert done.code == 2
    assert "comes back to within 0.25 m of its start, where the rover counts as arr" in done.err
    assert not Path("drive").exists()


def test_a_route_from_rovernav_route_is_driven(ground: str) -> None:
    """A wall stands in the straight line: alone the driver stops before it, routed it arrives."""
    way = ("--from", "6,-1.25", "--to", "20,-1.25")
    told = tell("route", ground, *way, "--rover", "research", "--out", "route")
    line = next(str(name) for name in told["files"] if str(name).endswith(".geojson"))
    words = ("drive", "--terrain", ground, *way, *NEURAL)
    assert tell(*words)["outcome"] != "reached"
    for route in (line, "plan"):
        report = tell(*words, "--route", route)
        assert report["outcome"] == "reached"
        assert report["settings"]["route"] == route
        assert report["length_m"] < 1.3 * told["length_m"]


def test_routes_and_sensors_that_cannot_be_are_one_sentence(ground: str) -> None:
    words = ("drive", "--terrain", ground, *ACROSS)
    cases = (
        ((*words, "--route", "plan"), "a route needs a rover that keeps a map"),
        ((*words, *NEURAL, "--route", "none.geojson"), "there is no file none.geojson"),
        ((*words, *NEURAL, "--sensing", "radar"), "sensing = 'radar'"),
        ((*words, "--sensing", "lidar"), "are for rovers with differential drive"),
        (("drive", "bassil-v1", "--drift"), "--drift does not go with the named scenario"),
    )
    for line, sentence in cases:
        done = run(*line)
        assert done.code == 2
        assert sentence in done.err
        assert "Traceback" not in done.err


def test_stereo_needs_heights_and_a_fan_to_take_its_place() -> None:
    with pytest.raises(SettingError, match="did you mean 'lidar'"):
        sensed(bassil_scene(), "lidars")
    with pytest.raises(SettingError, match="are for rovers with differential drive"):
        sensed(bassil_scene(), "stereo")
