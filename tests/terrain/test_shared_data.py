"""The readers on real elevation models; numbers from the data's own description."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.terrain import Raster, Terrain, open_raster, quality, read_terrain, slope

pytestmark = pytest.mark.data


def percentiles(terrain: Terrain) -> np.ndarray:
    """Slope p50, p95, p99 [deg]."""
    return np.nanpercentile(np.degrees(slope(terrain)), [50, 95, 99])


def test_jezero(data_dir: Path) -> None:
    terrain = read_terrain(data_dir / "dem" / "mars_jezero_hirise")
    assert terrain.name == "mars_jezero_hirise"
    assert terrain.frame.shape == (1042, 1024)  # a map metre is 0.982 true ones east-west
    assert terrain.frame.cell == pytest.approx(3.6916 / 1.018146, abs=1e-4)
    assert_allclose(terrain.frame.origin, (-1836.578, 1090080.992), rtol=0, atol=1e-3)
    assert terrain.frame.crs is not None
    assert "3394839.8133163" in terrain.frame.crs
    assert_allclose(terrain.span, (-2616.6118, -2463.3877), rtol=0, atol=0.3)
    assert_allclose(percentiles(terrain), (2.7, 9.7, 17.9), rtol=0.06)


def test_jezero_row_0_of_the_file_is_north(data_dir: Path) -> None:
    folder = data_dir / "dem" / "mars_jezero_hirise"
    codes = np.fromfile(folder / "heights.bin", "<u2").reshape(1024, 1024)
    terrain = read_terrain(folder)
    heights = -2616.61181640625 + codes / 65535 * 153.22412109375
    cell = 3780.1794958053983 / 1024
    for row, column in ((2, 0), (2, 1020), (500, 700), (1020, 3)):  # posts on the map
        x, y = -1836.5775915786319 + (column + 0.5) * cell, 1093861.1710255349 - (row + 0.5) * cell
        around = heights[max(row - 1, 0) : row + 2, column]
        got = terrain.elevation_at(*terrain.frame.to_local(x, y))
        assert around.min() - 1e-3 <= got <= around.max() + 1e-3


def test_mars_yard(data_dir: Path) -> None:
    terrain = read_terrain(data_dir / "dem" / "earth_marsyard2021_9cm" / "marsyard_terrain_hm.tif")
    assert terrain.frame.shape == (500, 500)
    assert terrain.frame.cell == pytest.approx(0.094, abs=1e-6)
    assert_allclose(terrain.frame.origin, (-23.5, -25.5), rtol=0, atol=1e-6)
    assert_allclose(terrain.span, (-1.0, 5.6), rtol=0, atol=0.05)
    assert_allclose(percentiles(terrain), (13, 40, 58), rtol=0.02)


def test_steep_mars_as_a_numpy_array(data_dir: Path) -> None:
    path = data_dir / "dem" / "mars_stratigraphy_hirise_1m" / "mars_dtm.npy"
    terrain = read_terrain(path, cell=1.01)
    assert terrain.frame.shape == (120, 70)
    assert_allclose(terrain.span, (753, 792), rtol=0, atol=0.5)
    assert_allclose(percentiles(terrain), (21.3, 45.3, 53.1), rtol=0.03)


@pytest.mark.parametrize(
    ("folder", "share", "span"),
    [
        ("mars_ctx_tharsis", 0.79, (8786, 9664)),
        ("mars_ctx_amazonis", 0.24, (-1892, -1191)),
        ("mars_ctx_elysium_noisy", 0.65, (-2604, -2449)),
        ("moon_dem_33", 1.0, (-212, -205)),
    ],
)
def test_other_geotiffs(
    data_dir: Path, folder: str, share: float, span: tuple[float, float]
) -> None:
    (path,) = (data_dir / "dem" / folder).glob("*.tif")
    terrain = read_terrain(path)
    assert terrain.finite == pytest.approx(share, abs=0.01)
    assert_allclose(terrain.span, span, rtol=0, atol=0.6)


def test_a_table_of_text(data_dir: Path) -> None:
    path = data_dir / "dem/earth_uma_rescue_1m/UMARescueArea_1mDEM.csv"
    terrain = read_terrain(path, cell=1.0, south_first=True)
    assert terrain.frame.shape == (200, 200)
    assert_allclose(terrain.span, (34, 66), rtol=0, atol=0.5)
    assert_allclose(percentiles(terrain)[:2], (7.2, 39), rtol=0.15)
    first = np.genfromtxt(path, max_rows=1)
    assert_allclose(terrain.height[0] + terrain.offset, first, rtol=0, atol=1e-4)


def test_an_archive_in_degrees(data_dir: Path) -> None:
    terrain = read_terrain(data_dir / "dem/earth_jacksboro_srtm_90m/jacksboro_fault_dem.npz")
    assert terrain.frame.cell == pytest.approx(74.5, abs=0.2)
    assert_allclose(terrain.frame.extent, (30_050, 31_800), rtol=2e-3)
    assert_allclose(terrain.span, (236, 1076), rtol=0, atol=8.0)


def test_a_picture_of_heights(data_dir: Path) -> None:
    (path,) = (data_dir / "dem/moon_tranquillitatis_pit_nac_2m").glob("*.png")
    terrain = read_terrain(path, cell=2.0, heights=(-110.0, 9.0))
    assert terrain.frame.extent == (514.0, 514.0)
    assert_allclose(terrain.span, (-110.0, 8.5), rtol=0, atol=0.1)


def test_heights_stay_at_their_map_coordinates(data_dir: Path) -> None:
    """Posts of each GeoTIFF, found again through the frame; exact to what lies between posts."""
    import rasterio

    for path in sorted((data_dir / "dem").glob("*/*.tif")):
        terrain = read_terrain(path)
        with rasterio.open(path) as data:
            band = data.read(1, masked=True)
            rows, columns = np.nonzero(~np.ma.getmaskarray(band))
            take = slice(0, None, max(1, len(rows) // 400))
            x, y = data.xy(rows[take], columns[take])
        east, north = (np.asarray(axis) for axis in (x, y))
        local: Any = terrain.frame.to_local(east, north)  # type: ignore[arg-type]
        assert_allclose(terrain.frame.to_map(*local), (x, y), rtol=0, atol=1e-6)
        got = terrain.elevation_at(*local)
        true = np.asarray(band[rows[take], columns[take]], np.float64)
        off = np.abs(got - true)[np.isfinite(got)]
        steepest = np.nanpercentile(np.tan(slope(terrain)), 99)
        assert len(off) > 0.9 * len(true)
        assert np.percentile(off, 95) <= 0.5 * steepest * terrain.frame.cell


NOISY, STEPPED, SOUND = "mars_ctx_elysium_noisy", "moon_tranquillitatis_pit_nac_2m", (
    "mars_jezero_hirise", "mars_ctx_tharsis", "mars_ctx_amazonis", "earth_marsyard2021_9cm",
    "mars_stratigraphy_hirise_1m", "moon_dem_33", "earth_uma_rescue_1m", "earth_jacksboro_srtm_90m",
)  # fmt: skip


def opened(folder: Path) -> Raster:
    given: dict[str, Any] = {
        "mars_stratigraphy_hirise_1m": {"cell": 1.01},
        "earth_uma_rescue_1m": {"cell": 1.0, "south_first": True},
        STEPPED: {"cell": 2.0, "heights": (-110.0, 9.0)},
    }.get(folder.name, {})
    files = [p for p in folder.iterdir() if "Offset" not in p.name and p.suffix != ".json"]
    path = folder if (folder / "meta.json").exists() else files[0]
    return open_raster(path, **given)


def test_only_the_noisy_model_is_called_noisy(data_dir: Path) -> None:
    found = {f.name: quality(opened(f)) for f in sorted((data_dir / "dem").iterdir())}
    assert {name for name, q in found.items() if q.noisy} == {NOISY}
    assert {name for name, q in found.items() if q.stepped} == {STEPPED}
    assert set(found) == {NOISY, STEPPED, *SOUND}
    assert found["mars_jezero_hirise"].flags == ()
    assert found[NOISY].noise == pytest.approx(4.0, abs=0.5)  # the data's own estimate
    assert found[STEPPED].step == pytest.approx(119 / 255, rel=1e-3)
    assert found["mars_ctx_amazonis"].holes == pytest.approx(0.76, abs=0.01)
