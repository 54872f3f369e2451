from __future__ import annotations

import errno
import math
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rovernav._version import __version__
from rovernav.core import FileError, Frame, ShapeError
from rovernav.terrain import Terrain, open_raster, read_terrain, write_geotiff, write_terrain
from tests.terrain.ground import MARS, ground, rough, write_tiff
from tests.terrain.test_metres import wkt


def test_a_terrain_comes_back_as_it_was(tmp_path: Path, rng: np.random.Generator) -> None:
    heights = -2600.0 + rough(rng, (70, 90), 0.05)
    frame = Frame(cell=2.5, shape=(70, 90), origin=(350_000.25, -80.5), crs=MARS)
    terrain = Terrain.from_heights(heights, frame, name="a", source="somewhere")
    path = write_terrain(
        terrain, tmp_path / "sub" / "a.tif", tags={"seed": 3, "settings": {"b": 1}}
    )
    again = read_terrain(path)
    assert again.frame.origin == frame.origin
    assert again.frame.cell == 2.5
    assert_allclose(again.height + again.offset, heights, rtol=0, atol=3e-4)
    import rasterio

    with rasterio.open(path) as data:
        tags = data.tags()
        assert (data.units, data.descriptions) == (("m",), ("elevation",))
        assert math.isnan(data.nodata)
        assert data.dtypes == ("float32",)
        assert_allclose(data.read(1), heights[::-1], rtol=0, atol=3e-4)
    assert tags["TIFFTAG_SOFTWARE"] == f"rovernav {__version__}"
    assert (tags["ROVERNAV_SEED"], tags["ROVERNAV_SETTINGS"]) == ("3", '{"b": 1}')
    assert tags["ROVERNAV_SOURCE"] == "somewhere"


def test_fine_cells_far_from_the_datum_keep_their_slopes(tmp_path: Path) -> None:
    heights = 9000.0 + np.linspace(0, 0.01, 100).reshape(10, 10)
    frame = Frame(cell=0.1, shape=(10, 10))
    terrain = Terrain.from_heights(heights, frame, name="a", source="x")
    again = read_terrain(write_terrain(terrain, tmp_path / "a.tif"))
    got = again.height.astype(np.float64) + again.offset
    assert_allclose(got, heights, rtol=0, atol=1e-8)


@pytest.mark.parametrize(
    ("text", "step", "corner"),
    [
        ("+proj=eqc +R=3396190 +lat_ts=0", 20.0, (1e5, 2.6e6)),
        ("+proj=sinu +R=3396190", 12.5, (3e5, 2.6e6)),
        ("EPSG:4326", 1e-4, (-4.0, 36.7)),
        ("EPSG:2263", 3.0, (980_000.0, 200_000.0)),
    ],
)
def test_resampled_ground_goes_back_to_its_own_map(
    tmp_path: Path, text: str, step: float, corner: tuple[float, float]
) -> None:
    import rasterio

    smooth = np.add.outer(0.01 * np.arange(60.0) ** 2, np.arange(70.0))
    path = write_tiff(tmp_path / "a.tif", smooth, crs=wkt(text), transform=rasterio.Affine(
        step, 0, corner[0], 0, -step, corner[1] + 60 * step))  # fmt: skip
    terrain = read_terrain(path)
    out = write_terrain(terrain, tmp_path / "b.tif")
    i, j = 20, 30
    place = terrain.frame.to_map(*terrain.frame.centre_of(i, j))
    with rasterio.open(out) as data:
        row, column = data.index(*place)
        assert (terrain.frame.shape[0] - 1 - row, column) == (i, j)
        assert_allclose(data.xy(row, column), place, rtol=0, atol=1e-6 * max(1.0, step))
        got = data.read(1)[row, column]
    assert got == pytest.approx(terrain.offset + float(terrain.height[i, j]), abs=1e-3)
    if "sinu" not in text:
        again = open_raster(out)
        assert not again.resampled
        assert again.frame.cell == pytest.approx(terrain.frame.cell, rel=1e-4)


@pytest.mark.parametrize("kind", ["f4", "f8", "u1", "i2", "i4", "?"])
def test_layers_of_any_kind(tmp_path: Path, kind: str) -> None:
    import rasterio

    values = (np.arange(12).reshape(3, 4) % 2).astype(kind)
    frame = Frame(cell=2.0, shape=(3, 4), origin=(1.0, 2.0))
    path = write_geotiff(values, frame, tmp_path / "a.tif", unit="deg", description="slope")
    with rasterio.open(path) as data:
        assert_array_equal(data.read(1), values[::-1].astype(data.dtypes[0]))
        assert (data.units, data.descriptions) == (("deg",), ("slope",))


def test_what_cannot_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    frame = Frame(cell=1.0, shape=(3, 3))
    with pytest.raises(
        ShapeError, match=r"numbers of the frame's shape \(3, 3\), got float64 of s"
    ):
        write_geotiff(np.zeros((2, 3)), frame, tmp_path / "a.tif")
    with pytest.raises(ShapeError, match="got <U1"):
        write_geotiff(np.array([["a"] * 3] * 3), frame, tmp_path / "a.tif")
    (tmp_path / "file").write_text("x")
    with pytest.raises(FileError, match="cannot write"):
        write_geotiff(np.zeros((3, 3)), frame, tmp_path / "file" / "a.tif")
    for name in ("/vsimem/a.tif", "s3://b/a.tif", "."):
        with pytest.raises(FileError, match="that is no file name"):
            write_geotiff(np.zeros((3, 3)), frame, name)

    def full(*_: Any) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    write_geotiff(np.ones((3, 3)), frame, tmp_path / "a.tif")
    before = (tmp_path / "a.tif").read_bytes()
    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(FileError, match=r"cannot write .*: No space left on device"):
        write_geotiff(np.zeros((3, 3)), frame, tmp_path / "a.tif")
    assert (tmp_path / "a.tif").read_bytes() == before
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.tif", "file"]


def test_the_same_ground_gives_the_same_bytes(tmp_path: Path) -> None:
    terrain = ground(rough(np.random.default_rng(2), (80, 80)))
    one, two = (write_terrain(terrain, tmp_path / name).read_bytes() for name in ("a.tif", "b.tif"))
    assert one == two
