"""The lazy raster: windows, averages, resampling, and files of every size."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.core import FileError, SettingError
from rovernav.kernels import resample as k
from rovernav.terrain import Raster, Window, _raster, open_raster, read_terrain
from tests.naive import ground as naive
from tests.terrain.ground import rough, write_tiff
from tests.terrain.test_metres import MARS, wkt

HALF_EQUATOR = wkt(f"+proj=eqc +R={MARS} +lat_ts=0")


def affine(*numbers: float) -> Any:
    from rasterio.transform import Affine

    return Affine(*numbers)


def file(tmp_path: Path, rows: Any, *, crs: str = HALF_EQUATOR, lat: float = 0.0) -> Raster:
    """A raster of 20 m posts whose middle lies at a latitude [deg]."""
    y = math.radians(lat) * MARS + 10.0 * len(rows)
    write_tiff(tmp_path / "a.tif", rows, crs=crs, transform=affine(20, 0, 5e4, 0, -20, y),
               nodata=np.nan)  # fmt: skip
    return open_raster(tmp_path / "a.tif")


@pytest.fixture
def posts(rng: np.random.Generator) -> np.ndarray:
    return 100.0 + rough(rng, (60, 80), 0.03)


def test_nothing_is_read_before_it_is_asked_for(tmp_path: Path, posts: np.ndarray) -> None:
    raster = file(tmp_path, posts)
    (tmp_path / "a.tif").unlink()
    assert raster.frame.shape == (60, 80)
    assert raster.describe()["bounds"] == [5e4, -600.0, 51600.0, 600.0]
    with pytest.raises(FileError, match=r"a.tif"):
        raster.read()


@pytest.mark.parametrize("lat", [0.0, 45.0])
def test_a_cell_has_one_height_whatever_window_it_is_read_in(
    tmp_path: Path, posts: np.ndarray, lat: float
) -> None:
    raster = file(tmp_path, posts, lat=lat)
    whole = raster.heights(raster.whole)
    for row, column, rows, columns in ((0, 0, 7, 9), (11, 20, 30, 5), (40, 3, 20, 41)):
        window = Window(row=row, column=column, rows=rows, columns=columns)
        expected = whole[row : row + rows, column : column + columns]
        assert_array_equal(raster.heights(window), expected)
    monkey = Window(row=5, column=5, rows=40, columns=30)
    part = raster.read(monkey)
    x, y = part.frame.centre_of(3, 4)
    assert_allclose(
        part.frame.to_map(x, y), raster.frame.to_map(*raster.frame.centre_of(8, 9)), atol=1e-9
    )


def test_strips_do_not_show(
    tmp_path: Path, posts: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    raster = file(tmp_path, posts, lat=30.0)
    at_once = [raster.heights(raster.whole, factor) for factor in (1, 3)]
    monkeypatch.setattr(_raster, "STRIP", 500)
    shares: list[float] = []
    for factor, expected in zip((1, 3), at_once, strict=True):
        got = raster.heights(raster.whole, factor, on_progress=shares.append)
        assert_array_equal(got, expected)
    assert shares[-1] == 1.0
    assert len(shares) > 10


@pytest.mark.parametrize("factor", [2, 3, 7, 100])
def test_averages_leave_out_what_is_missing(tmp_path: Path, posts: np.ndarray, factor: int) -> None:
    raster = file(tmp_path, posts)
    got = raster.heights(raster.whole, factor)
    expected = naive.block_means(posts[::-1].astype(np.float64), factor)
    assert_allclose(got, expected, rtol=0, atol=1e-9)
    if factor < 100:
        terrain = raster.read(factor=factor)
        assert terrain.frame.cell == 20.0 * factor
        assert f"{factor} x {factor} cells averaged" in terrain.source


@pytest.mark.kernels
@pytest.mark.parametrize("steps", [(1, 1), (1, 3), (2, 1)])
@pytest.mark.parametrize("missing", [0.0, 0.1])
def test_resampling_equals_its_twin(steps: tuple[int, int], missing: float) -> None:
    rng = np.random.default_rng(steps[1])
    z = rough(rng, (9, 11), missing).astype(np.float64)
    at = np.array([-0.6, 0.93, 0.04, 0.3, -0.03, 1.11])
    out = np.empty((11, 10))
    k.resample(z, at, np.zeros(4, np.int64), np.array([9, 11]), np.array(steps), out)
    assert_allclose(out, naive.resampled(z, at, (11, 10), steps), rtol=0, atol=1e-12)


@pytest.mark.kernels
@pytest.mark.parametrize("n", [1, 2, 5])
def test_block_means_equal_their_twin(n: int) -> None:
    z = rough(np.random.default_rng(n), (7, 9), 0.4).astype(np.float64)
    out = np.empty((-(-7 // n), -(-9 // n)))
    k.block_means(z, n, out)
    assert_allclose(out, naive.block_means(z, n), rtol=0, atol=1e-12)


def test_a_plane_stays_a_plane_with_its_true_slope(tmp_path: Path) -> None:
    i, j = np.indices((40, 60))
    raster = file(tmp_path, (0.3 * 20.0 * j - 0.1 * 20.0 * i).astype(np.float64), lat=45.0)
    terrain = raster.read()
    assert raster.resampled
    assert terrain.frame.cell == pytest.approx(20.0 * math.sqrt(0.5), rel=1e-4)
    inner = terrain.height.astype(np.float64)[2:-2, 2:-2]
    q, p = np.gradient(inner, terrain.frame.cell)
    assert_allclose(p, 0.3 * math.sqrt(2.0), rtol=2e-3)  # a map metre is 0.707 true ones
    assert_allclose(q, 0.1, atol=2e-4)
    assert "resampled to true metres" in terrain.source
    assert re.search(r"a map unit is 0.707. m east-west and 1.0000 m", raster.notes[0])


def test_degrees_as_gdal_warps_them(tmp_path: Path) -> None:
    """The same bilinear heights as GDAL's warper gives on the same grid."""
    import rasterio
    from rasterio.warp import Resampling, reproject
    from scipy.ndimage import gaussian_filter

    smooth = gaussian_filter(np.random.default_rng(3).normal(0, 50, (70, 90)), 3.0)
    step = 1 / 1200
    path = write_tiff(tmp_path / "a.tif", smooth, crs="EPSG:4326",
                      transform=affine(step, 0, -4.5, 0, -step, 36.75))  # fmt: skip
    terrain = read_terrain(path)
    (h, w), (xx, _), (_, yy) = terrain.frame.shape, *terrain.frame.axes
    x, y = terrain.frame.origin
    c = terrain.frame.cell
    warped = np.full((h, w), np.nan)
    with rasterio.open(path) as data:
        reproject(
            rasterio.band(data, 1), warped, dst_crs="EPSG:4326", dst_nodata=np.nan,
            dst_transform=affine(xx * c, 0, x, 0, -yy * c, y + yy * h * c),
            resampling=Resampling.bilinear,
        )  # fmt: skip
    ours = (terrain.height + terrain.offset)[::-1]
    inner = (slice(2, -2), slice(2, -2))
    assert np.isfinite(warped[inner]).all()
    assert_allclose(ours[inner], warped[inner], rtol=0, atol=2e-3)


@pytest.mark.parametrize("lat", [-60.0, 12.0, 50.0])
def test_heights_lie_at_their_map_coordinates(tmp_path: Path, lat: float) -> None:
    import rasterio

    i, j = np.indices((50, 50))
    raster = file(tmp_path, 0.01 * (i - 20.0) ** 2 + 0.02 * j, lat=lat)
    terrain = raster.read()
    middle = [(5e4 + 20 * (c + 0.5), raster.bounds[3] - 20 * (r + 0.5))
              for r, c in ((10, 10), (25, 30), (40, 20))]  # fmt: skip
    with rasterio.open(tmp_path / "a.tif") as data:
        expected = [float(s[0]) for s in data.sample(middle)]
    got = [float(terrain.elevation_at(*terrain.frame.to_local(x, y))) for x, y in middle]
    assert_allclose(got, expected, rtol=0, atol=0.01)


def test_metres_are_true_where_they_are_wanted(tmp_path: Path) -> None:
    tall = np.zeros((3000, 8), np.float32)
    raster = file(tmp_path, tall, lat=60.0)
    low, high = (raster.at(5e4, raster.bounds[edge]) for edge in (1, 3))
    middle = raster.frame.axes[0][0]
    assert low.frame.axes[0][0] < middle < high.frame.axes[0][0]
    north = raster.within((5e4, raster.bounds[3] - 2000.0, 6e4, raster.bounds[3] + 1e6))
    lat = math.degrees((raster.bounds[3] - 1000.0) / MARS)
    assert north.frame.axes[0][0] == pytest.approx(1 / math.cos(math.radians(lat)), rel=1e-6)


def test_a_part_by_its_bounds(tmp_path: Path, posts: np.ndarray) -> None:
    raster = file(tmp_path, posts)
    west, south, _, _ = raster.bounds
    part = read_terrain(tmp_path / "a.tif", bounds=(west + 100, south + 40, west + 301, south + 99))
    assert part.frame.shape == (3, 11)
    assert part.frame.origin == pytest.approx((west + 100, south + 40))
    assert_allclose(part.height + part.offset, posts[::-1][2:5, 5:16], rtol=0, atol=1e-4)


@pytest.mark.parametrize(
    ("bounds", "message"),
    [
        ((5, 0, 1, 9), "a window is written west, south, east, north and spans an area, got 5,0,1"),
        ((0, 0, 1, 1), r"the window lies off the map, which reaches from \(50000, -600\) to"),
        ((math.nan, 0, 1, 1), "spans an area"),
    ],
)
def test_a_part_that_is_none(tmp_path: Path, posts: np.ndarray, bounds: Any, message: str) -> None:
    with pytest.raises(SettingError, match=message):
        file(tmp_path, posts).window(*bounds)


def test_windows_and_factors_that_cannot_be(tmp_path: Path, posts: np.ndarray) -> None:
    raster = file(tmp_path, posts)
    with pytest.raises(SettingError, match="--factor must be a whole number of 1 or more, got 0"):
        raster.read(factor=0)
    with pytest.raises(SettingError, match=r"leaves the raster of 60 x 80 cells"):
        raster.read(Window(row=50, column=0, rows=11, columns=4))
    with pytest.raises(SettingError, match="a window needs a first row and column of 0 or more"):
        Window(row=-1, column=0, rows=3, columns=3)


def test_too_many_cells_at_a_time(
    tmp_path: Path, posts: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    raster = file(tmp_path, posts)
    monkeypatch.setattr(_raster, "MAX_CELLS", 1000)
    words = (r"has 80 x 60 cells, and 4,800 are more than 1,000 at a time; read a part with "
             r"--window WEST,SOUTH,EAST,NORTH, or average them with --factor 3")  # fmt: skip
    with pytest.raises(FileError, match=words):
        raster.read()
    assert raster.read(factor=3).frame.shape == (20, 27)


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    lat=st.floats(-80, 80), h=st.integers(3, 12), w=st.integers(3, 12), seed=st.integers(0, 99),
)  # fmt: skip
def test_resampled_heights_stay_within_those_of_the_file(
    tmp_path: Path, lat: float, h: int, w: int, seed: int
) -> None:
    rows = rough(np.random.default_rng(seed), (h, w), 0.1)
    if np.isnan(rows).all():
        return
    raster = file(tmp_path, rows, lat=lat)
    got = raster.heights(raster.whole)
    known = got[np.isfinite(got)]
    if known.size:  # but for the last bit of a weighted mean
        assert known.min() >= np.nanmin(rows) - 1e-9
        assert known.max() <= np.nanmax(rows) + 1e-9
    assert np.isfinite(got).any() or np.isnan(rows).any()


@pytest.mark.long
def test_a_file_larger_than_memory(tmp_path: Path) -> None:
    """40,000 x 40,000 posts in 2 GB: described, averaged, and read in parts."""
    import subprocess
    import sys

    import rasterio.windows

    place: Any = rasterio.windows.Window

    path = tmp_path / "large.tif"
    profile: dict[str, Any] = {
        "driver": "GTiff", "width": 40_000, "height": 40_000, "count": 1, "dtype": "float32",
        "tiled": True, "compress": "deflate", "sparse_ok": True, "nodata": -9999.0,
        "BIGTIFF": "YES", "crs": HALF_EQUATOR, "transform": affine(1, 0, 0, 0, -1, 4e5),
    }  # fmt: skip
    tile = np.linspace(0, 50, 512 * 512, dtype=np.float32).reshape(512, 512)
    with rasterio.open(path, "w", **profile) as data:
        for n in range(0, 78, 3):
            for m in range(0, 78, 2):
                data.write(tile, 1, window=place(m * 512, n * 512, 512, 512))
    code = f"""
import resource
from rovernav.terrain import Window, open_raster, quality
raster = open_raster({str(path)!r})
assert raster.frame.shape[1] == 40_000, raster.frame
print(quality(raster).holes)
whole = raster.read(factor=40)
assert whole.frame.shape == (raster.frame.shape[0] // 40 + 1, 1000), whole.frame
part = raster.read(Window(row=20_000, column=20_000, rows=4000, columns=4000))
assert part.frame.shape == (4000, 4000)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert float(done.stdout.split()[-1]) < 2.0  # GB
