"""Zones: read from GeoJSON, burnt into the grid, kept out of, stayed within."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

from rovernav import plan
from rovernav.core import FileError, Frame, InputError, SettingError
from tests.plan.slopes import going_over

FLAT = np.zeros((40, 50)) + 0.001 * np.arange(50)
MARS = (
    'PROJCRS["Mars",BASEGEOGCRS["Mars",DATUM["Mars",ELLIPSOID["Mars",3396190,0]],'
    'PRIMEM["Reference",0],CS[ellipsoidal,2],AXIS["lat",north],AXIS["lon",east],'
    'ANGLEUNIT["degree",0.0174532925199433]],CONVERSION["Equirectangular",'
    'METHOD["Equidistant Cylindrical (Spherical)"],PARAMETER["Latitude of 1st standard parallel",'
    '0],PARAMETER["Longitude of natural origin",0]],CS[Cartesian,2],AXIS["x",east],'
    'AXIS["y",north],LENGTHUNIT["metre",1]]'
)


def write(path: Path, *rings: Any, **members: Any) -> Path:
    """A file of polygons, each a list of rings."""
    features = [
        {"type": "Feature", "geometry": {"type": "Polygon", "coordinates": list(polygon)}}
        for polygon in rings
    ]
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features, **members}))
    return path


def box(x0: float, y0: float, x1: float, y1: float) -> list[list[float]]:
    return [[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]]


def frame(crs: str | None = None) -> Frame:
    return Frame(cell=1.0, shape=(40, 50), crs=crs)


@pytest.mark.parametrize("seed", range(5))
def test_burning_agrees_with_every_cell_asked(seed: int) -> None:
    rng = np.random.default_rng(seed)
    shape = shapely.MultiPoint(rng.uniform(0, 40, (7, 2))).convex_hull
    shape = shape.difference(shapely.Point(*rng.uniform(10, 30, 2)).buffer(4.0))
    x, y = rng.uniform(-5, 45, 2)
    shape = shape.union(shapely.box(x, y, x + 3.5, y + 9.2))
    cells = [[shapely.box(j, i, j + 1, i + 1) for j in range(50)] for i in range(40)]
    touched = plan.Zones(avoid=shape).forbidden(frame())
    assert np.array_equal(touched, shapely.intersects(shape, cells))
    outside = plan.Zones(keep_in=shape).forbidden(frame())
    assert np.array_equal(outside, ~shapely.covers(shape, cells))


def test_margins_grow_what_is_avoided_and_shrink_what_is_kept() -> None:
    square = shapely.box(10, 10, 30, 30)
    avoid = plan.Zones(avoid=square, margin=2.5).forbidden(frame())
    assert avoid[20, 7:33].all()
    assert not avoid[20, [6, 33]].any()
    keep = plan.Zones(keep_in=square, margin=2.5).forbidden(frame())
    assert not keep[20, 13:27].any()
    assert keep[20, [12, 27]].all()


def test_routes_keep_their_margin_from_zones(tmp_path: Path) -> None:
    ground = going_over(FLAT, "distance")
    hole = [box(15, 5, 35, 35), box(20, 10, 30, 30)[::-1]]
    zones = plan.read_zones(ground.frame, avoid=write(tmp_path / "z.json", hole), margin=2.0)
    found = plan.directed(plan.within_zones(ground, zones), (3.0, 20.0), (47.0, 20.0))
    assert found.found
    assert shapely.LineString(found.points).distance(zones.avoid) >= 2.0
    assert found.length > 50.0
    inside = plan.directed(plan.within_zones(ground, zones), (24.0, 24.0), (26.0, 25.0))
    assert inside.found


def test_a_margin_in_the_way_says_how_far_it_must_fall(tmp_path: Path) -> None:
    ground = going_over(FLAT, "distance")
    gate = [box(20, -1, 25, 17), box(20, 24, 25, 41)]
    file = write(tmp_path / "z.json", *([ring] for ring in gate))
    zones = plan.read_zones(ground.frame, avoid=file, margin=5.0)
    trip = plan.travel(plan.within_zones(ground, zones), [(3.0, 20.0), (47.0, 20.0)])
    (barrier,) = trip.barriers
    assert barrier.limit == "margin"
    assert 2.9 <= barrier.needed <= 3.5
    assert "falls from 5 m to 3" in trip.reason
    narrower = plan.read_zones(ground.frame, avoid=file, margin=barrier.needed)
    assert plan.directed(plan.within_zones(ground, narrower), (3.0, 20.0), (47.0, 20.0)).found


def test_a_zone_in_the_way_is_named(tmp_path: Path) -> None:
    ground = going_over(FLAT, "distance")
    zones = plan.read_zones(ground.frame, avoid=write(tmp_path / "z.json", [box(20, -1, 25, 41)]))
    trip = plan.travel(plan.within_zones(ground, zones), [(3.0, 20.0), (47.0, 20.0)])
    assert [b.limit for b in trip.barriers] == ["zone"]
    assert "a way opens if the zones are lifted" in trip.reason


def test_longitude_and_latitude_on_mars(tmp_path: Path) -> None:
    metre = np.degrees(1.0 / 3396190.0)
    lonlat = (np.array(box(10, 10, 20, 30)) * metre).tolist()
    told = plan.read_zones(frame(MARS), avoid=write(tmp_path / "a.json", [lonlat]))
    np.testing.assert_allclose(told.avoid.bounds, (10, 10, 20, 30), atol=1e-6)
    crs84 = {"type": "name", "properties": {"name": "urn:ogc:def:crs:OGC:1.3:CRS84"}}
    told = plan.read_zones(frame(MARS), avoid=write(tmp_path / "b.json", [lonlat], crs=crs84))
    np.testing.assert_allclose(told.avoid.bounds, (10, 10, 20, 30), atol=1e-6)
    own = write(tmp_path / "c.json", [box(10, 10, 20, 30)], crs_wkt=MARS)
    told = plan.read_zones(frame(MARS), keep_in=own)
    np.testing.assert_allclose(told.keep_in.bounds, (10, 10, 20, 30), atol=1e-6)


BOW = [[0, 0], [10, 10], [10, 0], [0, 10], [0, 0]]


@pytest.mark.parametrize(
    ("content", "error", "words"),
    [
        ("no json", FileError, "is no GeoJSON: Expecting value"),
        ("[1, 2]", FileError, "is no GeoJSON: it has no member type"),
        ('{"type": "FeatureCollection", "features": []}', FileError, "holds no polygon"),
        ('{"type": "Point", "coordinates": [1, 2]}', FileError, "holds a Point; zones are"),
        ('{"type": "Polygon", "coordinates": [[1, 2]]}', FileError, "coordinates are damaged"),
        ('{"type": "Polygon", "coordinates": [[[1, 2], [3, NaN], [4, 4], [1, 2]]]}', FileError,
         "a coordinate is not finite"),
        (json.dumps({"type": "Polygon", "coordinates": [BOW]}), InputError,
         r"zone 1 is no proper polygon: Self-intersection\[5 5\]"),
        (json.dumps({"type": "Polygon", "coordinates": [box(900, 900, 950, 950)]}), InputError,
         "no zone touches the map, which reaches from"),
    ],
)  # fmt: skip
def test_zones_that_are_refused(tmp_path: Path, content: str, error: Any, words: str) -> None:
    path = tmp_path / "z.geojson"
    path.write_text(content)
    with pytest.raises(error, match=words):
        plan.read_zones(frame(), avoid=path)


def test_coordinate_systems_that_are_refused(tmp_path: Path) -> None:
    metres = write(tmp_path / "m.json", [box(1000, 1000, 2000, 2000)])
    with pytest.raises(InputError, match="are no longitude and latitude; name their"):
        plan.read_zones(frame(MARS), avoid=metres)
    unknown = {"type": "name", "properties": {"name": "nobody's"}}
    with pytest.raises(InputError, match='a coordinate system that nobody knows: "nobody\'s"'):
        plan.read_zones(frame(MARS), avoid=write(tmp_path / "n.json", [BOW[:3]], crs=unknown))
    utm = {"type": "name", "properties": {"name": "EPSG:32631"}}
    file = write(tmp_path / "e.json", [box(500000, 0, 500010, 10)], crs=utm)
    with pytest.raises(InputError, match=r"different bodies|no place|no zone touches"):
        plan.read_zones(frame(MARS), avoid=file)


def test_margins_and_files_that_are_refused(tmp_path: Path) -> None:
    with pytest.raises(SettingError, match=r"the margin must be 0 m or more, got -1\.0"):
        plan.Zones(margin=-1.0)
    with pytest.raises(FileError, match="there is no file"):
        plan.read_zones(frame(), avoid=tmp_path / "none.json")
    with pytest.raises(FileError, match="cannot be read"):
        plan.read_zones(frame(), avoid=tmp_path)
