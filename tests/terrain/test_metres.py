"""True metres: the scale of projections, degrees, and the way back to the map."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.core import FileError
from rovernav.terrain import true_north
from rovernav.terrain._metres import map_unit
from rovernav.terrain._posts import Placing, lay

MARS, MOON = 3396190.0, 1737400.0


def wkt(text: str) -> str:
    from pyproj import CRS

    return CRS.from_user_input(text).to_wkt()


def test_equirectangular_at_45_degrees_has_41_per_cent_too_many_metres() -> None:
    crs = wkt(f"+proj=eqc +R={MARS} +lat_ts=0")
    unit = map_unit(crs, 0.0, math.radians(45.0) * MARS)
    assert_allclose(np.sqrt(np.diag(unit.metric)), (math.sqrt(0.5), 1.0), rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("text", "x", "y"),
    [
        (f"+proj=eqc +R={MARS} +lat_ts=15 +lon_0=77.44", 50.0, 1.092e6),
        (f"+proj=stere +lat_0=90 +R={MOON}", 600_000.0, 350_000.0),
        (f"+proj=merc +R={MARS}", 1e5, 3e6),
        (f"+proj=tmerc +lon_0=10 +a={MARS} +b=3376200", 60_000.0, 1e6),
        ("+proj=laea +lat_0=52 +lon_0=10 +ellps=GRS80", 900_000.0, 800_000.0),
        ("EPSG:32630", 150_000.0, 4_066_000.0),
        ("EPSG:3413", -1_800_000.0, -2_000_000.0),
        ("EPSG:2263", 980_000.0, 200_000.0),
    ],
)
def test_scale_and_north_are_those_of_proj(text: str, x: float, y: float) -> None:
    from pyproj import CRS, Proj

    proj = Proj(CRS.from_user_input(text))
    foot = CRS.from_user_input(text).axis_info[0].unit_conversion_factor
    lon, lat = proj(x, y, inverse=True)
    factors = proj.get_factors(lon, lat)
    unit = map_unit(wkt(text), x, y)
    # the four corners of a square of true metres, by the derivatives of the projection
    areal = math.sqrt(float(np.linalg.det(unit.metric)))
    expected = foot**2 / factors.areal_scale
    if abs(factors.areal_scale - 1.0) > 4e-3:
        assert areal == pytest.approx(expected, rel=1e-6)
    else:
        assert areal == pytest.approx(foot**2, rel=4e-3)
    turn = math.degrees(unit.north) + factors.meridian_convergence
    assert math.remainder(turn, 360.0) == pytest.approx(0.0, abs=1e-3)


def test_metres_of_a_utm_zone_count_as_true() -> None:
    assert_allclose(map_unit(wkt("EPSG:32630"), 366_000.0, 4_066_000.0).metric, np.eye(2))


def test_a_zone_that_is_only_a_label_is_not_believed() -> None:
    unit = map_unit(wkt("EPSG:32634"), 0.0, 0.0)
    assert_allclose(unit.metric, np.eye(2))
    assert "lies outside of the zone of WGS 84 / UTM zone 34N" in unit.note


def test_degrees_have_the_metres_of_their_latitude() -> None:
    unit = map_unit(wkt("EPSG:4326"), -4.0, 60.0)
    east, north = np.sqrt(np.diag(unit.metric))
    assert_allclose((east, north), (55_800.0, 111_412.0), rtol=1e-4)  # tables of WGS 84


def test_a_polar_map_knows_its_north() -> None:
    crs = wkt(f"+proj=stere +lat_0=90 +R={MOON}")
    assert math.degrees(true_north(crs, 0.0, -5e4)) == pytest.approx(0.0, abs=1e-6)
    assert math.degrees(true_north(crs, -5e4, 0.0)) == pytest.approx(90.0, abs=1e-6)
    assert true_north(None, 1.0, 2.0) == 0.0


@pytest.mark.parametrize(
    ("text", "x", "y", "message"),
    [
        ("EPSG:4326", 350_000.0, 4e6, r"middle at \(350000, 4000000\), which is no place in its"),
        ("+proj=stere +lat_0=90 +R=1737400", math.nan, 0.0, "is no place in its coordinate"),
        ("+proj=merc +R=1737400", 0.0, 1e12, "is no place in its coordinate system"),
    ],
)
def test_a_place_that_does_not_exist(text: str, x: float, y: float, message: str) -> None:
    with pytest.raises(FileError, match=message) as caught:
        map_unit(wkt(text), x, y, source="a.tif")
    assert str(caught.value).startswith("a.tif has its middle at")


def test_a_coordinate_system_of_noise() -> None:
    with pytest.raises(FileError, match=r"cannot be understood .*; assign another"):
        map_unit('PROJCS["x",GEOGCS["y"]]', 0.0, 0.0)


def placed(text: str | None, middle: tuple[float, float], step: tuple[float, float]) -> Placing:
    h, w = 40, 50
    corner = (middle[0] - w / 2 * step[0], middle[1] - h / 2 * step[1])
    return Placing(shape=(h, w), corner=corner, step=step, crs=text and wkt(text))


@pytest.mark.parametrize(
    ("text", "middle", "step"),
    [
        (f"+proj=eqc +R={MARS} +lat_ts=0", (1e5, math.radians(45.0) * MARS), (20.0, 20.0)),
        (f"+proj=sinu +R={MARS}", (300_000.0, math.radians(45.0) * MARS), (12.5, 12.5)),
        (f"+proj=stere +lat_0=90 +R={MOON}", (6e5, 3e5), (5.0, 5.0)),
        ("EPSG:4326", (-4.0, 36.7), (1 / 3600, 1 / 3600)),
        ("EPSG:2263", (980_000.0, 200_000.0), (3.0, 3.0)),
        (None, (0.0, 0.0), (2.0, 3.0)),
    ],
)
def test_local_metres_are_true_and_go_back_to_the_map(
    text: str | None, middle: tuple[float, float], step: tuple[float, float]
) -> None:
    placing = placed(text, middle, step)
    frame = lay(placing, middle, "a.tif").frame
    x, y = frame.to_local(*middle)
    for dx, dy in ((30.0, 0.0), (0.0, 40.0), (-20.0, 25.0)):
        a, b = frame.to_map(x, y), frame.to_map(x + dx, y + dy)
        assert_allclose(frame.to_local(*b), (x + dx, y + dy), rtol=0, atol=1e-6)
        assert ground_distance(text, a, b) == pytest.approx(math.hypot(dx, dy), rel=1e-4)


def ground_distance(text: str | None, a: Any, b: Any) -> float:
    """Metres between two map points, along the geodesic."""
    if text is None:
        return math.dist(a, b)
    from pyproj import CRS, Geod, Transformer

    crs = CRS.from_user_input(text)
    to = Transformer.from_crs(crs, crs.geodetic_crs, always_xy=True).transform
    body: Any = crs.ellipsoid
    geod = Geod(a=body.semi_major_metre, b=body.semi_minor_metre)
    return float(geod.inv(*to(*a), *to(*b))[2])


def test_the_cells_cover_the_file_and_are_as_fine_as_its_posts() -> None:
    lattice = lay(placed("EPSG:4326", (10.0, 60.0), (1e-3, 1e-3)), (10.0, 60.0), "a")
    east = 0.05 * 55_800
    assert lattice.frame.cell == pytest.approx(55.8, rel=1e-3)
    assert lattice.frame.extent[0] == pytest.approx(east, rel=1e-3)
    assert lattice.frame.extent[1] == pytest.approx(0.04 * 111_412, rel=0.02)
    at_85 = lay(placed("EPSG:4326", (10.0, 85.0), (1e-3, 1e-3)), (10.0, 85.0), "a")
    assert at_85.frame.cell == pytest.approx(111.69 / 2, rel=1e-3)
    assert at_85.steps == (1, 6)
