"""Routes from GeoJSON: what is written is read back, and what is damaged is told."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.core import FileError, Frame, InputError
from rovernav.export import write_route_geojson
from rovernav.plan import CostMap, any_angle, read_route
from rovernav.terrain import Terrain
from tests.plan.test_zones import MARS

PLAIN = Frame(cell=1.0, shape=(30, 40), origin=(100.0, -50.0))


def line(*points: Any, **members: Any) -> dict[str, Any]:
    return {"type": "LineString", "coordinates": [list(p) for p in points], **members}


def write(path: Path, data: Any) -> Path:
    path.write_text(data if isinstance(data, str) else json.dumps(data))
    return path


@pytest.mark.parametrize("crs", [None, MARS])
def test_a_written_route_is_read_back(crs: str | None, tmp_path: Path) -> None:
    frame = Frame(cell=1.0, shape=(30, 40), origin=(100.0, -50.0), crs=crs)
    terrain = Terrain(
        frame=frame, height=np.zeros(frame.shape, np.float32), offset=0.0, name="t", source="t"
    )
    blocked = np.zeros(frame.shape)
    blocked[5:25, 20] = 1
    route = any_angle(CostMap.of(1.0, frame, forbidden=blocked), (5.5, 15.0), (35.5, 15.0))
    file = tmp_path / "route.geojson"
    write_route_geojson(route, file, terrain=terrain)
    assert_allclose(read_route(file, frame), route.points, atol=1e-6)


def test_legs_are_joined_and_points_left_out(tmp_path: Path) -> None:
    data = {
        "type": "FeatureCollection",
        "features": [
            {"type": "Feature", "geometry": line((101, -49), (103, -49))},
            {"type": "Feature", "geometry": {"type": "Point", "coordinates": [0, 0]}},
            {"type": "Feature", "geometry": None},
            {"type": "Feature", "geometry": line((103, -49, 7.0), (103, -45))},
        ],
    }
    points = read_route(write(tmp_path / "a.geojson", data), PLAIN)
    assert_array_equal(points, [[1, 1], [3, 1], [3, 5]])


def test_longitude_and_latitude_are_brought_to_the_map(tmp_path: Path) -> None:
    frame = Frame(cell=1.0, shape=(30, 40), crs=MARS)
    metre = math.degrees(1.0 / 3396190.0)
    file = write(tmp_path / "a.geojson", line((2 * metre, 3 * metre), (9 * metre, 3 * metre)))
    assert_allclose(read_route(file, frame), [[2, 3], [9, 3]], atol=1e-6)


BAD: list[tuple[Any, type, str]] = [
    ("nonsense", FileError, "is no GeoJSON"),
    ({"type": "Point", "coordinates": [0, 0]}, FileError, "holds no line; a route is a LineString"),
    ({"type": "FeatureCollection", "features": []}, FileError, "holds no line"),
    (line((0, 0), (1,)), FileError, "a line's coordinates are damaged"),
    (line((0, 0), ("a", 1)), FileError, "a line's coordinates are damaged"),
    (line(), FileError, "a line's coordinates are damaged"),
    (line((0, 0), (math.nan, 1)), FileError, "needs points of two finite numbers"),
    (line((0, 0), (1, 1), crs_wkt="Atlantis"), InputError, "a coordinate system that nobody knows"),
]


@pytest.mark.parametrize(("data", "error", "message"), BAD)
def test_what_is_no_route_is_told(
    data: Any, error: type[Exception], message: str, tmp_path: Path
) -> None:
    frame = Frame(cell=1.0, shape=(30, 40), crs=MARS)
    with pytest.raises(error, match=message):
        read_route(write(tmp_path / "bad.geojson", data), frame)


def test_a_missing_file_is_told(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="there is no file"):
        read_route(tmp_path / "none.geojson", PLAIN)
