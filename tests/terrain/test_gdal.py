from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.core import FileError, SettingError
from rovernav.terrain import _raster, read_terrain
from tests.terrain.ground import MARS, write_tiff

ROWS = np.arange(12, dtype=np.float32).reshape(3, 4) ** 2 - 2600.0


EQUATOR = MARS.replace('UNIT["metre",1]', 'UNIT["foot",0.3048]')


def affine(*numbers: float) -> Any:
    from rasterio.transform import Affine

    return Affine(*numbers)


def test_north_up_is_flipped_once(tmp_path: Path) -> None:
    terrain = read_terrain(write_tiff(tmp_path / "crater.tif", ROWS))
    assert terrain.name == "crater"
    assert terrain.frame.shape == (3, 4)
    assert terrain.frame.cell == 2.0
    assert terrain.frame.origin == (100.0, 4994.0)
    assert terrain.frame.crs is not None
    assert "3396190" in terrain.frame.crs
    assert_array_equal(terrain.height + terrain.offset, ROWS[::-1])


def test_heights_lie_at_their_map_coordinates_as_rasterio_says(tmp_path: Path) -> None:
    import rasterio

    path = write_tiff(tmp_path / "a.tif", ROWS)
    terrain = read_terrain(path)
    places = [(101.0, 4999.0), (107.0, 4999.0), (105.0, 4995.0)]
    with rasterio.open(path) as file:
        expected = [sample[0] for sample in file.sample(places)]
    got = [terrain.elevation_at(*terrain.frame.to_local(x, y)) for x, y in places]
    assert_allclose(got, expected, rtol=0, atol=1e-4)


def test_south_up_is_not_flipped(tmp_path: Path) -> None:
    up = affine(2.0, 0.0, 100.0, 0.0, 2.0, 4994.0)
    terrain = read_terrain(write_tiff(tmp_path / "a.tif", ROWS[::-1], transform=up))
    assert terrain.frame.origin == (100.0, 4994.0)
    assert_array_equal(terrain.height + terrain.offset, ROWS[::-1])


def test_nodata_becomes_nan(tmp_path: Path) -> None:
    rows = ROWS.copy()
    rows[0, 1] = -32767.0
    terrain = read_terrain(write_tiff(tmp_path / "a.tif", rows, nodata=-32767.0))
    assert_array_equal(np.argwhere(np.isnan(terrain.height)), [[2, 1]])


def test_whole_numbers_with_scale_and_offset(tmp_path: Path) -> None:
    import rasterio

    path = write_tiff(tmp_path / "a.tif", np.arange(12, dtype=np.int16).reshape(3, 4))
    with rasterio.open(path, "r+") as file:
        file.scales, file.offsets = (0.5,), (-100.0,)
    assert_allclose(read_terrain(path).span, (-100.0, -94.5), rtol=0, atol=1e-9)


def test_a_file_without_coordinates_needs_a_cell(tmp_path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # rasterio's own: the file shall have no coordinates
        path = write_tiff(tmp_path / "a.tif", ROWS, crs=None, transform=None)
    terrain = read_terrain(path, cell=0.25)
    assert terrain.frame.cell == 0.25
    assert_array_equal(terrain.height + terrain.offset, ROWS[::-1])
    with pytest.raises(SettingError, match="does not say how large its cells are; give --cell"):
        read_terrain(path)


def test_a_missing_crs_is_allowed(tmp_path: Path) -> None:
    assert read_terrain(write_tiff(tmp_path / "a.tif", ROWS, crs=None)).frame.crs is None


@pytest.mark.parametrize(
    ("rows", "profile", "message"),
    [
        (ROWS, {"transform": (2, 0.1, 0, 0, -2, 0)}, "is rotated or mirrored .*gdalwarp"),
        (ROWS, {"transform": (-2, 0, 0, 0, -2, 0)}, "is rotated or mirrored"),
        (ROWS, {"crs": "EPSG:4326"}, "middle at .* which is no place in its coordinate system WGS"),
        (np.zeros((3, 3, 3), np.uint8), {}, "has 3 bands, so it is an image"),
        (np.zeros((3, 3), np.complex64), {}, "of type complex64, not heights"),
        (ROWS[:2], {}, r"a.tif: ground needs at least 3 x 3 heights, got shape \(2, 4\)"),
        (np.full((3, 3), -9.0), {"nodata": -9.0}, "every height is missing"),
        (np.full((3, 3), -3e38), {}, "beyond 100 km; .* set it as the file's nodata value"),
        (np.full((3, 3), np.inf), {}, "9 heights are infinite"),
    ],
)
def test_files_that_are_not_ground(
    tmp_path: Path, rows: np.ndarray, profile: dict[str, Any], message: str
) -> None:
    if "transform" in profile:
        profile = {**profile, "transform": affine(*profile["transform"])}
    path = write_tiff(tmp_path / "a.tif", rows, **profile)
    with pytest.raises(FileError, match=message) as caught:
        read_terrain(path)
    assert "\n" not in str(caught.value)


def test_cells_that_are_not_square_are_made_so(tmp_path: Path) -> None:
    rows = np.add.outer(np.arange(30.0), np.arange(20.0))
    long = affine(3.0, 0.0, 100.0, 0.0, -2.0, 5000.0)
    terrain = read_terrain(write_tiff(tmp_path / "a.tif", rows, transform=long))
    assert terrain.frame.shape == (30, 30)
    assert terrain.frame.cell == 2.0
    q, p = np.gradient(terrain.height.astype(np.float64)[2:-2, 2:-2], 2.0)
    assert_allclose(p.mean(), 1 / 3, rtol=1e-3)
    assert_allclose(q, -1 / 2, rtol=1e-5)


def test_map_coordinates_in_feet(tmp_path: Path) -> None:
    terrain = read_terrain(write_tiff(tmp_path / "a.tif", ROWS, crs=EQUATOR))
    assert terrain.frame.cell == pytest.approx(2 * 0.3048, rel=1e-6)
    x, y = terrain.frame.to_local(108.0, 5000.0)
    assert (x, y) == pytest.approx((8 * 0.3048, 6 * 0.3048), rel=1e-6)
    assert terrain.frame.to_map(x, y) == pytest.approx((108.0, 5000.0), abs=1e-9)


def test_nearly_square_cells_are_square(tmp_path: Path) -> None:
    nearly = affine(2.0, 0.0, 0.0, 0.0, -2.001, 0.0)
    terrain = read_terrain(write_tiff(tmp_path / "a.tif", ROWS, transform=nearly))
    assert terrain.frame.cell == pytest.approx(2.0005, abs=1e-6)


def test_a_palette_is_an_image(tmp_path: Path) -> None:
    import rasterio

    path = write_tiff(tmp_path / "a.tif", np.zeros((3, 3), np.uint8), photometric="palette")
    with rasterio.open(path, "r+") as file:
        file.write_colormap(1, {0: (1, 2, 3, 255)})
    with pytest.raises(FileError, match="holds palette values of type uint8, not heights"):
        read_terrain(path)


def test_heights_in_an_unknown_unit(tmp_path: Path) -> None:
    import rasterio

    path = write_tiff(tmp_path / "a.tif", ROWS)
    with rasterio.open(path, "r+") as file:
        file.units = ("fathom",)
    with pytest.raises(FileError, match="heights in 'fathom', not in m, km, cm, mm, ft or us-ft"):
        read_terrain(path)


def test_too_large_is_refused_before_it_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_raster, "MAX_CELLS", 11)
    with pytest.raises(
        FileError, match=r"has 4 x 3 cells, and 12 are more than 11 at a time; read"
    ):
        read_terrain(write_tiff(tmp_path / "a.tif", ROWS))


def test_a_file_with_cells_refuses_another_size(tmp_path: Path) -> None:
    with pytest.raises(SettingError, match="has its own cells of 2 m; leave --cell out"):
        read_terrain(write_tiff(tmp_path / "a.tif", ROWS), cell=1.0)


@pytest.mark.parametrize("keep", [8, 60, 200, 30_000])
def test_cut_off_says_so_once(tmp_path: Path, keep: int, capfd: pytest.CaptureFixture[str]) -> None:
    path = write_tiff(tmp_path / "a.tif", np.random.default_rng(1).random((100, 100)))
    path.write_bytes(path.read_bytes()[:keep])
    with pytest.raises(FileError, match=r"is a damaged or cut-off GeoTIFF .* again"):
        read_terrain(path)
    assert capfd.readouterr().err == ""


def test_a_bomb_is_refused_before_it_is_read(tmp_path: Path) -> None:
    """A small file that declares 4 x 10^10 heights; and one that keeps too many in one piece."""
    import rasterio

    huge: dict[str, Any] = {
        "driver": "GTiff", "count": 1, "dtype": "float32", "width": 200_000, "height": 200_000,
        "tiled": True, "compress": "deflate", "sparse_ok": True, "BIGTIFF": "YES",
        "transform": affine(2, 0, 0, 0, -2, 0),
    }  # fmt: skip
    with rasterio.open(tmp_path / "a.tif", "w", **huge):
        pass
    assert (tmp_path / "a.tif").stat().st_size < 20_000_000
    with pytest.raises(FileError, match="has 200,000 x 200,000 cells, and 40,000,000,000 are more"):
        read_terrain(tmp_path / "a.tif")
    huge |= {"tiled": False, "blockysize": 20_000, "height": 20_000}
    with rasterio.open(tmp_path / "b.tif", "w", **huge):
        pass
    with pytest.raises(FileError, match=r"keeps 20,000 x 200,000 heights in one piece of 16.0 GB"):
        read_terrain(tmp_path / "b.tif")


def test_a_strip_of_a_million_columns(tmp_path: Path) -> None:
    rows = np.zeros((3, 1_000_000), np.float32)
    rows[1, ::2] = 1.0
    terrain = read_terrain(write_tiff(tmp_path / "a.tif", rows, compress="deflate"))
    assert terrain.frame.shape == (3, 1_000_000)
    assert terrain.span == (0.0, 1.0)


def test_all_numbers_near_the_largest_are_missing_where_one_is(tmp_path: Path) -> None:
    rows = ROWS.copy()
    rows[0, 0], rows[1, 1] = -3.4028227e38, -3.4028226e38  # ISIS marks several kinds so
    terrain = read_terrain(write_tiff(tmp_path / "a.tif", rows, nodata=-3.4028227e38))
    assert_array_equal(np.argwhere(np.isnan(terrain.height)), [[1, 1], [2, 0]])
