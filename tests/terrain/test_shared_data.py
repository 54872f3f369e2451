"""The readers on real elevation models; numbers from the data's own description."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from rovernav.core import FileError
from rovernav.terrain import Terrain, read_terrain, slope

pytestmark = pytest.mark.data


def percentiles(terrain: Terrain) -> np.ndarray:
    """Slope p50, p95, p99 [deg]."""
    return np.nanpercentile(np.degrees(slope(terrain)), [50, 95, 99])


def test_jezero(data_dir: Path) -> None:
    terrain = read_terrain(data_dir / "dem" / "mars_jezero_hirise")
    assert terrain.name == "mars_jezero_hirise"
    assert terrain.frame.shape == (1024, 1024)
    assert terrain.frame.cell == pytest.approx(3.6916, abs=1e-4)
    assert_allclose(terrain.frame.origin, (-1836.578, 1090080.992), rtol=0, atol=1e-3)
    assert terrain.frame.crs is not None
    assert "3394839.8133163" in terrain.frame.crs
    assert_allclose(terrain.span, (-2616.6118, -2463.3877), rtol=0, atol=1e-3)
    assert_allclose(percentiles(terrain), (2.7, 9.7, 17.9), rtol=0.06)


def test_jezero_row_0_of_the_file_is_north(data_dir: Path) -> None:
    folder = data_dir / "dem" / "mars_jezero_hirise"
    codes = np.fromfile(folder / "heights.bin", "<u2").reshape(1024, 1024)
    terrain = read_terrain(folder)
    north_west = -2616.61181640625 + codes[0, 0] / 65535 * 153.22412109375
    x, y = terrain.frame.centre_of(1023, 0)
    assert terrain.elevation_at(x, y) == pytest.approx(north_west, abs=1e-3)


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


def test_an_archive_a_picture_and_a_table_are_refused(data_dir: Path) -> None:
    for kind in ("npz", "png", "csv"):
        for path in (data_dir / "dem").glob(f"*/*.{kind}"):
            with pytest.raises(FileError, match="give a GeoTIFF"):
                read_terrain(path)
