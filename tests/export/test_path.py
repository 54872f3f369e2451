from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.core import Frame, InputError
from rovernav.export import write_path_csv, write_path_geojson
from rovernav.sim import Trace, simulate
from rovernav.terrain import Terrain
from tests.sim.drives import Always, drive, mission

STARTS = ((1.0, 2.0, 0.0), (9.5, 0.0, 0.0), (10.0, 0.0, 0.0))


@pytest.fixture
def trace() -> Trace:
    """Three rovers: one that runs out of time, one that arrives soon, one that is there already."""
    there = mission(STARTS, (10.0, 0.2), radius=0.3, limit=6.0)
    return simulate(drive(Always(0.25, 0.1, 0.0), starts=STARTS, mission=there), seed=7)


@pytest.fixture
def terrain() -> Terrain:
    """A slope that falls to the west, between metres 100.25 and 120.25 east."""
    frame = Frame(cell=0.5, shape=(24, 40), origin=(100.25, -7.5), crs='LOCAL_CS["moon"]')
    heights = -2600.0 + 0.125 * np.tile(np.arange(40.0), (24, 1))
    return Terrain.from_heights(heights, frame, name="slope", source="a test")


def read(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("k", [0, 1, 2])
def test_csv_keeps_every_bit_of_one_rovers_path(trace: Trace, tmp_path: Path, k: int) -> None:
    write_path_csv(trace, tmp_path / "deep/p.csv", k=k)
    rows = read(tmp_path / "deep/p.csv")
    assert list(rows[0]) == ["time_s", "x_m", "y_m", "heading_rad"]
    points = np.array([[float(row["x_m"]), float(row["y_m"])] for row in rows])
    assert np.array_equal(points, trace.path(k))
    assert float(rows[-1]["time_s"]) == trace.time[-1, k]
    assert len(rows) == trace.steps[k] + 1


def test_csv_on_ground_has_map_coordinates_and_heights(
    trace: Trace, terrain: Terrain, tmp_path: Path
) -> None:
    write_path_csv(trace, tmp_path / "p.csv", terrain=terrain)
    rows = read(tmp_path / "p.csv")
    at = np.array([[float(row[name]) for name in ("map_x", "map_y")] for row in rows])
    assert_allclose(at, trace.path() + np.array([100.25, -7.5]), rtol=0, atol=1e-12)
    heights = [float(row["elevation_m"]) for row in rows]
    assert_allclose(heights, -2600.0 + 0.25 * (trace.path()[:, 0] - 0.25), rtol=0, atol=1e-4)


@pytest.mark.parametrize("k", [0, 1])
def test_geojson_is_a_line_with_its_ends(
    trace: Trace, terrain: Terrain, tmp_path: Path, k: int
) -> None:
    write_path_geojson(trace, tmp_path / "p.geojson", terrain=terrain, k=k)
    whole = json.loads((tmp_path / "p.geojson").read_text())
    assert (whole["type"], whole["crs_wkt"]) == ("FeatureCollection", 'LOCAL_CS["moon"]')
    line, start, goal = whole["features"]
    assert {feature["type"] for feature in (line, start, goal)} == {"Feature"}
    assert line["geometry"]["type"] == "LineString"
    on_map = trace.path(k) + np.array([100.25, -7.5])
    assert_allclose(line["geometry"]["coordinates"], on_map, rtol=0, atol=1e-12)
    assert line["properties"] == {
        "outcome": trace.ended(k).label, "length_m": trace.length[k],
        "time_s": trace.time[-1, k], "steps": trace.steps[k], "seed": 7,
    }  # fmt: skip
    assert_allclose(start["geometry"]["coordinates"], on_map[0], rtol=0, atol=1e-12)
    assert_allclose(goal["geometry"]["coordinates"], (110.25, -7.3), rtol=0, atol=1e-12)


def test_geojson_of_a_rover_that_never_left_is_a_point(trace: Trace, tmp_path: Path) -> None:
    write_path_geojson(trace, tmp_path / "p.geojson", k=2)
    line, *_ = json.loads((tmp_path / "p.geojson").read_text())["features"]
    assert line["geometry"] == {"type": "Point", "coordinates": [10.0, 0.0]}


def test_a_path_off_the_data_has_no_height(trace: Trace, tmp_path: Path) -> None:
    heights = np.full((24, 40), np.nan)
    heights[:, :3] = 1.0
    ground = Terrain.from_heights(
        heights, Frame(cell=0.5, shape=(24, 40)), name="hole", source="a test"
    )
    write_path_csv(trace, tmp_path / "p.csv", terrain=ground)
    found = [row["elevation_m"] for row in read(tmp_path / "p.csv")]
    assert found[0] == "1.0"
    assert found[-1] == "nan"
    write_path_geojson(trace, tmp_path / "p.geojson", terrain=ground)  # refuses NaN itself


@pytest.mark.parametrize("write", [write_path_csv, write_path_geojson])
def test_a_trace_without_its_path_is_refused(write, tmp_path: Path) -> None:
    ends = simulate(drive(Always(0.25, 0.1, 0.0)), record="none")
    with pytest.raises(InputError, match="record 'path' or 'all'"):
        write(ends, tmp_path / "p")
    assert list(tmp_path.iterdir()) == []


def test_geojson_of_all_rovers_names_each(trace: Trace, tmp_path: Path) -> None:
    write_path_geojson(trace, tmp_path / "all.geojson", k=None)
    features = json.loads((tmp_path / "all.geojson").read_text())["features"]
    assert [f["properties"]["rover"] for f in features] == [0, 0, 0, 1, 1, 1, 2, 2, 2]
    for k in (0, 1, 2):
        write_path_geojson(trace, tmp_path / "one.geojson", k=k)
        alone = json.loads((tmp_path / "one.geojson").read_text())["features"]
        for mine, its in zip(features[3 * k : 3 * k + 3], alone, strict=True):
            assert mine["geometry"] == its["geometry"]
            assert mine["properties"] == {**its["properties"], "rover": k}
