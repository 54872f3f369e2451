from __future__ import annotations

import contextlib
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from rovernav.core import FileError, RovernavError, SettingError
from rovernav.terrain import open_raster, read_terrain

META = {"grid": 4, "size_m": 20.0, "elev_min_m": -10.0, "elev_max_m": 55.535}
CODES = np.arange(16, dtype="<u2").reshape(4, 4) * 1000


def raw(folder: Path, codes: Any = CODES, **changes: Any) -> Path:
    meta = {key: item for key, item in {**META, **changes}.items() if item is not None}
    (folder / "meta.json").write_text(json.dumps(meta))
    (folder / "heights.bin").write_bytes(np.asarray(codes, "<u2").tobytes())
    return folder


@pytest.mark.parametrize("give", ["", "meta.json", "heights.bin"])
def test_raw_heights_by_folder_description_or_data(tmp_path: Path, give: str) -> None:
    terrain = read_terrain(raw(tmp_path, bounds_proj=[7.0, -9.0, 27.0, 11.0], site="x") / give)
    assert terrain.frame.cell == 5.0
    assert terrain.frame.origin == (7.0, -9.0)
    assert_allclose(terrain.height + terrain.offset, CODES[::-1] / 1000 - 10.0, rtol=0, atol=1e-5)
    assert terrain.name == tmp_path.name


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"grid": None}, "the key 'grid' is missing; add it"),
        ({"elev_min_m": "low"}, "elev_min_m = 'low': input should be a valid number"),
        ({"grid": 2}, "grid = 2: input should be greater than or equal to 3"),
        ({"size_m": 0}, "size_m = 0: input should be greater than 0"),
        ({"elev_max_m": -11.0}, "elev_max_m must not be below elev_min_m"),
        ({"bounds_proj": [0, 0, 20, 21]}, "bounds_proj spans 21 m, size_m 20 m"),
        ({"grid": 5}, "32 bytes, but 5 x 5 heights of two bytes need 50; fetch it again or corr"),
        ({"grid": 30_000}, "32 bytes, but 30000 x 30000 heights of two bytes need 1,800,000,000"),
    ],
)
def test_raw_heights_with_a_wrong_description(
    tmp_path: Path, changes: dict[str, Any], message: str
) -> None:
    with pytest.raises((FileError, SettingError), match=message):
        read_terrain(raw(tmp_path, **changes))


def test_raw_heights_without_their_parts(tmp_path: Path) -> None:
    raw(tmp_path)
    (tmp_path / "heights.bin").unlink()
    with pytest.raises(
        FileError, match=r"there is no height grid at .*heights.bin; check the path"
    ):
        read_terrain(tmp_path)
    (tmp_path / "meta.json").write_text("{")
    with pytest.raises(FileError, match=r"meta.json is not JSON \(.*\); fetch or write it again"):
        read_terrain(tmp_path)
    (tmp_path / "meta.json").unlink()
    with pytest.raises(FileError, match=r"there is no elevation file at .*meta.json; check"):
        read_terrain(tmp_path)


def test_raw_heights_have_their_own_cells(tmp_path: Path) -> None:
    with pytest.raises(SettingError, match="has its own cells of 5 m; leave --cell out"):
        read_terrain(raw(tmp_path), cell=1.0)


@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("kind", ["f8", ">f4", "i2", "u1"])
def test_npy_has_row_0_in_the_north(tmp_path: Path, kind: str, order: Any) -> None:
    rows = np.asarray(np.arange(12).reshape(3, 4), dtype=kind, order=order)
    np.save(tmp_path / "a.npy", rows)
    terrain = read_terrain(tmp_path / "a.npy", cell=2.0)
    assert_array_equal(terrain.height + terrain.offset, rows[::-1])
    assert terrain.frame.extent == (8.0, 6.0)


def test_npy_needs_its_cell(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", np.zeros((3, 3)))
    with pytest.raises(SettingError, match="does not say how large its cells are; give --cell MET"):
        read_terrain(tmp_path / "a.npy")


@pytest.mark.parametrize("cell", [0.0, -1.0, np.nan, np.inf])
def test_cell_must_be_positive(tmp_path: Path, cell: float) -> None:
    with pytest.raises(SettingError, match="--cell must be a positive number of metres, got"):
        read_terrain(tmp_path / "a.npy", cell=cell)


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (np.zeros((3, 3, 3)), r"holds float64 of shape \(3, 3, 3\); ground is a two-dim"),
        (np.zeros((3, 3), complex), "holds complex128"),
        (np.array([["a"] * 3] * 3), "holds <U1"),
        (np.zeros((1, 1)), "a.npy: ground needs at least 3 x 3"),
        (np.array([[None] * 3] * 3), "is not a whole NumPy array of numbers"),
    ],
)
def test_npy_that_is_not_ground(tmp_path: Path, array: np.ndarray, message: str) -> None:
    np.save(tmp_path / "a.npy", array, allow_pickle=True)
    with pytest.raises(FileError, match=message):
        read_terrain(tmp_path / "a.npy", cell=1.0)


@pytest.mark.parametrize("keep", [6, 8, 40, 200])
def test_npy_cut_off(tmp_path: Path, keep: int) -> None:
    np.save(tmp_path / "a.npy", np.zeros((30, 30)))
    (tmp_path / "a.npy").write_bytes((tmp_path / "a.npy").read_bytes()[:keep])
    with pytest.raises(FileError, match=r"is not a whole NumPy array .* numpy.save"):
        read_terrain(tmp_path / "a.npy", cell=1.0)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "a.tif is empty; give a GeoTIFF"),
        (b"x y z\n1 2 3\n", r"is not an elevation file: it begins with b'x y z"),
        (b"\x89PNG\r\n", "is not an elevation file"),
        (b'<VRTDataset rasterXSize="3">', "is a VRT that only points to other files .gdal_trans"),
        (b"PK\x03\x04", "is not a whole NumPy archive"),
    ],
)
def test_what_a_file_holds_counts_not_its_name(
    tmp_path: Path, content: bytes, message: str
) -> None:
    (tmp_path / "a.tif").write_bytes(content)
    with pytest.raises(FileError, match=message):
        read_terrain(tmp_path / "a.tif")


@pytest.mark.parametrize(
    "path", ["/vsicurl/http://x/a.tif", "http://x/a.tif", "/vsizip/a.zip", "s3://b/a.tif"]
)
def test_only_files_on_this_machine(path: str) -> None:
    with pytest.raises(FileError, match="is not a file on this machine; download it"):
        read_terrain(path)
    with pytest.raises(FileError, match="is not a file on this machine; download it"):
        read_terrain(Path(path))


def test_a_missing_file(tmp_path: Path) -> None:
    with pytest.raises(
        FileError, match=r"there is no elevation file at .*none.tif; check the path"
    ):
        read_terrain(tmp_path / "none.tif")


def test_a_name_that_no_file_can_have() -> None:
    with pytest.raises(FileError, match=r"cannot read 'xxx.*: File name too long"):
        open_raster("x" * 5000)


def test_damage_of_any_kind_ends_in_a_sentence(tmp_path: Path) -> None:
    from tests.terrain.ground import write_tiff

    rng = np.random.default_rng(7)
    np.save(tmp_path / "a.npy", np.ones((5, 5)))
    whole = [
        write_tiff(tmp_path / "a.tif", np.ones((5, 5), np.float32)).read_bytes(),
        (tmp_path / "a.npy").read_bytes(),
        json.dumps(META).encode(),
    ]
    for turn in range(150):
        damaged = bytearray(whole[turn % 3])
        for spot in rng.integers(0, len(damaged), 3):
            damaged[spot] = rng.integers(256)
        (tmp_path / "meta.json").write_bytes(damaged)
        with contextlib.suppress(RovernavError):  # any other error ends the test
            read_terrain(tmp_path / "meta.json", cell=1.0 if turn % 3 == 1 else None)
