from __future__ import annotations

import csv
import json
import math
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.cli.runner import run, tell, write_ground

MAP = "type octile\nheight 3\nwidth 4\nmap\n.@..\n.@..\n...T\n"
SCEN = "version 1\n0\tm.map\t4\t3\t0\t0\t2\t0\t6.00000000\n0\tm.map\t4\t3\t2\t0\t2\t1\t1.00000000\n"


@pytest.fixture
def ground(tmp_path: Path) -> Path:
    return write_ground(tmp_path / "yard.tif")


def test_a_route_around_a_wall(ground: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    report = tell("route", ground, "--from", "5,0.5", "--to", "12,0.5", "--out", out)
    assert report["status"] == "found"
    assert report["reason"] is None
    assert report["straight_m"] == 7.0
    assert 9.0 < report["length_m"] < 14.0
    assert 0.0 < report["max_slope_deg"] < 15.0
    rows = list(csv.DictReader((out / "route.csv").read_text().splitlines()))
    assert len(rows) == report["points"]
    assert [float(rows[0][k]) for k in ("map_x", "map_y")] == [5.0, 0.5]
    assert float(rows[-1]["distance_m"]) == pytest.approx(report["length_m"])
    line = json.loads((out / "route.geojson").read_text())["features"][0]
    assert line["geometry"]["type"] == "LineString"
    assert line["geometry"]["coordinates"][-1] == [12.0, 0.5]
    assert line["properties"]["length_m"] == report["length_m"]
    assert (out / "route.png").stat().st_size > 10_000


def test_no_way_of_any_length_needs_no_explanation(ground: Path, tmp_path: Path) -> None:
    words = ("route", ground, "--from", "-6,-10", "--to", "-6,-10", "--why", "-6,-10")
    report = tell(*words, "--out", tmp_path / "o")
    assert (report["status"], report["length_m"], report["why"]) == ("found", 0.0, None)


def test_what_is_said(ground: Path, tmp_path: Path) -> None:
    said = run("route", ground, "--from", "-6,-10", "--to", "-5,-9", "--out", tmp_path / "o")
    assert said.code == 0
    assert said.out.startswith("Found a way of 1.41 m for 1.41 m in a straight line, 1.00 times.")


@pytest.mark.parametrize(
    ("goal", "way", "words"),
    [
        ("8.5,0.5", "goal_forbidden", "the goal (15.5, 11.5) m touches forbidden ground; the"),
        ("99,0", "goal_outside", "lies beyond the map, which is 30 m wide and 20 m high"),
    ],
)
def test_no_way_is_an_answer(ground: Path, tmp_path: Path, goal: str, way: str, words: str) -> None:
    out = tmp_path / "out"
    report = tell("route", ground, "--from", "-6,-10", "--to", goal, "--out", out)
    assert (report["status"], report["way"]) == ("unreachable", way)
    assert words in report["reason"]
    assert report["length_m"] is None
    assert json.loads((out / "route.geojson").read_text())["type"] == "FeatureCollection"
    assert (out / "route.csv").read_text().count("\n") == 1
    assert (out / "route.png").is_file()
    said = run("route", ground, "--from", "-6,-10", "--to", goal, "--out", out)
    assert said.code == 0
    assert "There is no way: the goal" in said.out


@pytest.mark.parametrize("command", ["route", "drive"])
def test_pictures_and_tables_are_ground_too(tmp_path: Path, command: str) -> None:
    """A wall in the north of a picture; the same table read from the south has it there."""
    greys = np.zeros((40, 60), np.uint8)
    greys[:15, 30:33] = 200
    Image.fromarray(greys).save(tmp_path / "ground.png")
    np.save(tmp_path / "ground.npy", greys / 100.0)
    first, more, table = {
        "route": ((), ("--no-picture",), "route.csv"),
        "drive": (("--terrain",), ("--controller", "planner"), "path.csv"),
    }[command]
    crossings: list[float] = []
    for file, words in (
        ("ground.png", ("--heights", "0,2.55")),
        ("ground.npy", ("--south-first",)),
    ):
        tell(command, *first, tmp_path / file, "--cell", "0.5", *words, "--rover", "research",
             "--from", "3,14", "--to", "27,14", "--out", tmp_path, *more)  # fmt: skip
        rows = list(csv.DictReader((tmp_path / table).read_text().splitlines()))
        x, y = (np.array([float(row[name]) for row in rows]) for name in ("x_m", "y_m"))
        assert (x[-1], y[-1]) == pytest.approx((27.0, 14.0), abs=1.0)
        crossings.append(float(np.interp(15.75, x, y)))
    assert crossings[0] < 12.5
    assert crossings[1] == pytest.approx(14.0, abs=0.5)


def test_an_enclosed_goal(tmp_path: Path) -> None:
    heights = np.zeros((40, 40), np.float32)
    heights[10:30, [10, 29]] = heights[[10, 29], 10:30] = 9.0
    path = tmp_path / "ring.npy"
    np.save(path, heights)
    words = ("route", path, "--cell", "0.5", "--frame", "pixel", "--rover", "paper-point")
    report = tell(*words, "--from", "2,2", "--to", "20,20", "--out", tmp_path / "o")
    assert report["way"] == "goal_enclosed"
    assert "forbidden ground encloses the goal" in report["reason"]
    assert report["nearest"] == report["nearest_map"]
    assert math.dist(report["nearest"], (10.25, 9.75)) < 8.0


def test_scenarios(tmp_path: Path) -> None:
    grid, scen = tmp_path / "m.map", tmp_path / "m.map.scen"
    grid.write_text(MAP)
    scen.write_text(SCEN)
    report = tell("route", grid, "--scen", scen)
    assert report["scenarios"] == 2
    assert report["lengths"] == [6.0, 1.0]
    assert report["max_rel_error"] == 0.0
    assert report["beyond_printed_digits"] == 0
    assert report["seconds"] >= 0.0
    assert "All lengths equal the published ones" in run("route", grid, "--scen", scen).out
    scen.write_text(SCEN.replace("6.0", "5.0"))
    assert tell("route", grid, "--scen", scen)["max_rel_error"] == pytest.approx(0.2)
    assert "1 lengths differ from the published" in run("route", grid, "--scen", scen).out


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("{map}",), "is a MovingAI map; give its scenarios too: --scen FILE.scen"),
        (("{map}", "--scen", "{map}", "--from", "1,1"), "--from does not go with a MovingAI map"),
        (("{map}", "--scen", "{map}"), "is no MovingAI scenario file"),
        (("{tif}", "--scen", "{map}"), "--scen goes with a MovingAI .map only"),
        (("{tif}", "--from", "1,1"), "a route needs --to X,Y as well"),
        (("{tif}", "--from", "1", "--to", "2,2"), "--from must be two numbers X,Y"),
        (("{tif}", "--from", "1,1", "--to", "2,2", "--frame", "x"), "--frame has no 'x'"),
        (("{tif}", "--from", "1,1", "--to", "2,2", "--rover", "x"), "rover"),
    ],
)
def test_wrong_words(ground: Path, tmp_path: Path, words: tuple[str, ...], told: str) -> None:
    grid = tmp_path / "m.map"
    grid.write_text(MAP)
    out = ("--out", str(tmp_path / "o"))
    said = run("route", *(word.format(map=grid, tif=ground) for word in words), *out)
    assert said.code == 2
    assert told in said.err
    assert "Traceback" not in said.err


@pytest.mark.data
@pytest.mark.long
def test_every_movingai_file_by_the_command(data_dir: Path) -> None:
    maps = sorted((data_dir / "movingai").glob("*/*.map"))
    assert len(maps) == 14
    for grid in maps:
        scen = grid.with_name(f"{grid.name}.scen")
        told = tell("route", grid, "--scen", scen)
        words = [line.split()[-1] for line in scen.read_text().splitlines()[1:] if line.strip()]
        assert told["scenarios"] == len(words) == len(told["lengths"])
        published = np.array(words, float)
        digits = np.array([len(word.partition(".")[2]) for word in words])
        allowed = 0.5 * 10.0**-digits + 1e-6 * published
        assert (np.abs(np.array(told["lengths"]) - published) <= allowed).all(), grid.name
        assert told["max_rel_error"] <= (allowed / np.maximum(published, 1e-9)).max()
