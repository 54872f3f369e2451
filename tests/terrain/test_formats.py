"""Elevation files beside GeoTIFF and .npy: planetary images, text, archives, pictures."""

from __future__ import annotations

import gzip
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.core import FileError, SettingError
from rovernav.terrain import open_raster, read_terrain
from tests.terrain.ground import MARS

ROWS = (np.arange(20.0).reshape(4, 5) ** 2 - 50.0).astype(np.float32)


def pds3(folder: Path, *, image: str = "", offset: float = 0.0) -> Path:
    """A PDS3 image with its label in front, or beside it."""
    label = [
        "PDS_VERSION_ID = PDS3", "RECORD_TYPE = FIXED_LENGTH", "RECORD_BYTES = 20",
        f"^IMAGE = {image or 200}", "OBJECT = IMAGE", " LINES = 4", " LINE_SAMPLES = 5",
        " SAMPLE_TYPE = PC_REAL", " SAMPLE_BITS = 32", " BANDS = 1", f" OFFSET = {offset}",
        " SCALING_FACTOR = 1.0", " MISSING_CONSTANT = -32768.0", "END_OBJECT = IMAGE",
        "OBJECT = IMAGE_MAP_PROJECTION", ' MAP_PROJECTION_TYPE = "SIMPLE CYLINDRICAL"',
        " A_AXIS_RADIUS = 1737.4 <KM>", " B_AXIS_RADIUS = 1737.4 <KM>",
        " C_AXIS_RADIUS = 1737.4 <KM>", ' TARGET_NAME = "MOON"', " CENTER_LATITUDE = 0.0 <DEG>",
        " CENTER_LONGITUDE = 0.0 <DEG>", " MAP_SCALE = 2.0 <METERS/PIXEL>",
        " LINE_PROJECTION_OFFSET = 100.5", " SAMPLE_PROJECTION_OFFSET = 10.5",
        "END_OBJECT = IMAGE_MAP_PROJECTION", "END",
    ]  # fmt: skip
    text = "\r\n".join(label).encode() + b"\r\n"
    body = ROWS.astype("<f4").tobytes()
    path = folder / ("a.lbl" if image else "a.img")
    path.write_bytes(text if image else text.ljust(199 * 20, b" ") + body)
    if image:
        (folder / "b.img").write_bytes(body)
    return path


def gdal_file(folder: Path, driver: str, name: str) -> Path:
    import rasterio
    from rasterio.transform import Affine

    profile: dict[str, Any] = {
        "driver": driver, "count": 1, "height": 4, "width": 5, "dtype": "float32", "crs": MARS,
        "transform": Affine(2.0, 0.0, 100.0, 0.0, -2.0, 5000.0),
    }  # fmt: skip
    with rasterio.open(folder / name, "w", **profile) as data:
        data.write(ROWS, 1)
    return folder / name


@pytest.mark.parametrize(
    ("driver", "name", "kind"),
    [("PDS4", "a.xml", "PDS4 image"), ("ISIS3", "a.cub", "ISIS cube")],
)
def test_images_of_space_agencies(tmp_path: Path, driver: str, name: str, kind: str) -> None:
    raster = open_raster(gdal_file(tmp_path, driver, name))
    assert raster.source == f"{kind} {name}"
    terrain = raster.read()
    assert_allclose(terrain.height + terrain.offset, ROWS[::-1], rtol=0, atol=1e-4)
    assert terrain.frame.crs is not None
    assert raster.bounds == pytest.approx((100.0, 4992.0, 110.0, 5000.0), abs=1e-6)


def test_pds3_with_its_label_in_front(tmp_path: Path) -> None:
    raster = open_raster(pds3(tmp_path))
    assert raster.source == "PDS3 image a.img"
    terrain = raster.read()
    assert_allclose(terrain.height + terrain.offset, ROWS[::-1], rtol=0, atol=1e-4)
    assert terrain.frame.cell == pytest.approx(2.0, rel=1e-6)
    assert raster.frame.crs is not None


def test_pds3_with_its_data_beside_the_label(tmp_path: Path) -> None:
    terrain = read_terrain(pds3(tmp_path, image='"b.img"'))
    assert_allclose(terrain.height + terrain.offset, ROWS[::-1], rtol=0, atol=1e-4)


def test_radii_are_counted_from_the_body(tmp_path: Path) -> None:
    terrain = read_terrain(pds3(tmp_path, offset=1737400.0))
    assert_allclose(terrain.height + terrain.offset, ROWS[::-1], rtol=0, atol=1e-4)


def test_a_label_must_not_lead_out_of_its_folder(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "b.img").write_bytes(ROWS.astype("<f4").tobytes())
    path = pds3(tmp_path / "in", image='"../b.img"')
    with pytest.raises(FileError, match=r"a\.lbl"):
        read_terrain(path)
    (tmp_path / "in/b.img").unlink()
    for image in ('"/vsicurl/http://x/b.img"', '"/etc/passwd"'):
        with pytest.raises(FileError, match=r"a\.lbl"):
            read_terrain(pds3(tmp_path / "in", image=image))
        (tmp_path / "in/b.img").unlink()


ASC = "ncols 5\nnrows 4\nxllcorner 100\nyllcorner 4992\ncellsize 2\nNODATA_value -9999\n"


def test_an_ascii_grid(tmp_path: Path) -> None:
    body = "\n".join(" ".join(str(float(z)) for z in row) for row in ROWS)
    (tmp_path / "a.asc").write_text(ASC + body.replace("-50.0", "-9999", 1))
    (tmp_path / "a.prj").write_text(MARS)
    terrain = read_terrain(tmp_path / "a.asc")
    assert terrain.frame.origin == (100.0, 4992.0)
    assert "3396190" in str(terrain.frame.crs)
    expected = ROWS.copy()
    expected[0, 0] = np.nan
    assert_allclose(terrain.height + terrain.offset, expected[::-1], rtol=0, atol=1e-4)


@pytest.mark.parametrize("between", [" ", "\t", ",", ";", " , "])
@pytest.mark.parametrize("south_first", [False, True])
def test_a_table_of_numbers(tmp_path: Path, between: str, south_first: bool) -> None:
    lines = ["# heights", *(between.join(f"{z:g}" for z in row) for row in ROWS)]
    (tmp_path / "a.csv").write_text("\n".join(lines) + "\n")
    terrain = read_terrain(tmp_path / "a.csv", cell=0.5, south_first=south_first)
    assert terrain.frame.extent == (2.5, 2.0)
    expected = ROWS if south_first else ROWS[::-1]
    assert_array_equal(terrain.height + terrain.offset, expected)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 2 3\n4 5\n6 7 8\n", "is not a grid of numbers .*; give every row as many"),
        ("1 2 3\n4 x 6\n7 8 9\n", "is not a grid of numbers"),
        ("1,2\n3,4\n", r"ground needs at least 3 x 3 heights, got shape \(2, 2\)"),
        ("1 2 3\n4 5 inf\n6 7 8\n", "1 heights are infinite"),
        ("nan nan nan\n" * 3, "every height is missing"),
    ],
)
def test_tables_that_are_no_ground(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "a.txt").write_text(text)
    with pytest.raises(FileError, match=message) as caught:
        read_terrain(tmp_path / "a.txt", cell=1.0)
    assert "a.txt" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_table_needs_its_cell(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("1,2,3\n" * 3)
    with pytest.raises(SettingError, match="does not say how large its cells are; give --cell"):
        read_terrain(tmp_path / "a.csv")


def test_an_archive_in_degrees(tmp_path: Path) -> None:
    edges: dict[str, Any] = {"xmin": 8.0, "xmax": 8.05, "ymin": 47.04, "ymax": 47.0}
    np.savez(tmp_path / "a.npz", elevation=ROWS, **edges)
    raster = open_raster(tmp_path / "a.npz")
    assert raster.notes == ("in degrees: resampled to square cells in true metres",)
    assert raster.bounds == pytest.approx((8.0, 47.0, 8.05, 47.04))
    assert raster.frame.cell == pytest.approx(0.01 * 76_056, rel=1e-3)  # cos 47.02 of a degree
    assert raster.heights(raster.whole)[0, 0] == pytest.approx(ROWS[-1, 0], abs=1.0)


def test_an_archive_with_its_cell(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", z=ROWS, cell=4.0)
    terrain = read_terrain(tmp_path / "a.npz")
    assert terrain.frame.cell == 4.0
    assert_array_equal(terrain.height + terrain.offset, ROWS[::-1])
    np.savez(tmp_path / "b.npz", dem=ROWS)
    with pytest.raises(SettingError, match="does not say how large its cells"):
        read_terrain(tmp_path / "b.npz")
    assert read_terrain(tmp_path / "b.npz", cell=2.0).frame.cell == 2.0
    np.savez(tmp_path / "c.npz", weights=ROWS)
    with pytest.raises(FileError, match=r"holds no heights \(it has weights\); name the array ele"):
        read_terrain(tmp_path / "c.npz")


def picture(path: Path, values: np.ndarray) -> Path:
    import rasterio

    bands = values if values.ndim == 3 else values[None]
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a picture has no coordinates
        with rasterio.open(
            path, "w", driver="PNG", count=len(bands), height=bands.shape[1],
            width=bands.shape[2], dtype=bands.dtype,
        ) as data:  # fmt: skip
            data.write(bands)
    return path


@pytest.mark.parametrize(("kind", "top"), [("uint8", 255), ("uint16", 65535)])
def test_a_picture_of_heights(tmp_path: Path, kind: str, top: int) -> None:
    values = np.linspace(0, top, 20).astype(kind).reshape(4, 5)
    path = picture(tmp_path / "a.png", values)
    terrain = read_terrain(path, cell=2.0, heights=(-110.0, 9.0))
    expected = -110.0 + values[::-1] / top * 119.0
    assert_allclose(terrain.height + terrain.offset, expected, rtol=0, atol=1e-4)
    with pytest.raises(SettingError, match="is a picture; if it is a map of heights, say what"):
        read_terrain(path)
    with pytest.raises(SettingError, match="does not say how large its cells"):
        read_terrain(path, heights=(0, 1))
    with pytest.raises(SettingError, match=r"--heights must be LOW,HIGH with LOW below HIGH"):
        read_terrain(path, cell=1.0, heights=(2, 1))


def test_colours_are_no_heights(tmp_path: Path) -> None:
    path = picture(tmp_path / "a.png", np.zeros((3, 4, 5), np.uint8))
    with pytest.raises(FileError, match="has 3 bands, so it is an image rather than an elevation"):
        read_terrain(path, cell=1.0, heights=(0, 1))


def test_heights_are_for_pictures(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", ROWS)
    with pytest.raises(SettingError, match=r"--heights is for pictures, and .* is a NumPy array"):
        read_terrain(tmp_path / "a.npy", cell=1.0, heights=(0, 1))
    cube = gdal_file(tmp_path, "ISIS3", "a.cub")
    with pytest.raises(SettingError, match=r"for pictures of 8 or 16 bits, and .* holds float32"):
        read_terrain(cube, heights=(0, 1))


@pytest.mark.parametrize(("unit", "metres"), [("ft", 0.3048), ("cm", 0.01), ("us-ft", 0.3048006)])
def test_vertical_units(tmp_path: Path, unit: str, metres: float) -> None:
    import rasterio

    path = gdal_file(tmp_path, "GTiff", "a.tif")
    with rasterio.open(path, "r+") as data:
        data.units = (unit,)
    low, high = read_terrain(path).span
    assert (low, high) == pytest.approx((-50 * metres, 311 * metres), rel=1e-6)


def test_a_scale_that_gives_no_heights(tmp_path: Path) -> None:
    import rasterio

    path = gdal_file(tmp_path, "GTiff", "a.tif")
    for scale, offset in ((np.nan, 0.0), (0.0, 1.0), (1.0, np.inf)):
        with rasterio.open(path, "r+") as data:
            data.scales, data.offsets = (scale,), (offset,)
        with pytest.raises(FileError, match=r"which give no heights; set them right \(gdal_edit"):
            read_terrain(path)


def test_other_formats_that_are_packed_are_named(tmp_path: Path) -> None:
    (tmp_path / "a.tif").write_bytes(gzip.compress(b"x" * 100))
    with pytest.raises(FileError, match="is not an elevation file: it begins with"):
        read_terrain(tmp_path / "a.tif")
