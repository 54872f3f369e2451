"""Elevation files of every kind that rovernav reads, told apart by their first bytes."""

from __future__ import annotations

import math
import re
from pathlib import Path

from ..core import FileError, InputError, SettingError
from ._elevation import Terrain

META = "meta.json"
KINDS = "GeoTIFF (.tif), NumPy array (.npy), or a folder with meta.json and heights.bin"

_TIFF = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
_REMOTE = re.compile(r"^[A-Za-z][A-Za-z0-9+.]+:/|^/vsi|://")


def read_terrain(
    path: str | Path, *, cell: float | None = None, most_cells: int | None = None
) -> Terrain:
    """Ground heights from an elevation file on this machine.

    ==================================  ============================================================
    GeoTIFF                             one band, square cells in metres; see `read_geotiff`
    NumPy array (.npy)                  two-dimensional, row 0 = north, NaN = no data; needs `cell`
    folder, its meta.json, heights.bin  raw 16-bit heights with a description; see `read_raw`
    ==================================  ============================================================

    Args:
        path: File or folder.
        cell: Side of a cell [m], for files that do not say it themselves.
        most_cells: Refuse GeoTIFFs with more cells before their heights are read.

    Raises:
        FileError: Missing, damaged, of another kind, or not usable as ground; the sentence says
            what to do.
        SettingError: `cell` is missing, not positive, or given for a file that has its own.
    """
    if cell is not None and not (math.isfinite(cell) and cell > 0):
        raise SettingError(f"--cell must be a positive number of metres, got {cell}")
    if _REMOTE.search(str(path)):
        raise FileError(f"{path} is not a file on this machine; download it and give its path")
    try:
        return _read(Path(path), cell, most_cells)
    except (FileError, SettingError):
        raise
    except InputError as error:
        raise FileError(str(error)) from None


def _read(path: Path, cell: float | None, most_cells: int | None) -> Terrain:
    if path.is_dir():
        path = path / META
    head = _head(path)
    if head.startswith(_TIFF):
        from ._geotiff import read_geotiff

        return read_geotiff(path, cell=cell, most_cells=most_cells)
    from ._grids import read_npy, read_raw

    if head.startswith(b"\x93NUMPY"):
        return read_npy(path, cell=cell)
    if head.lstrip().startswith(b"{"):
        return read_raw(path, cell=cell)
    if path.suffix == ".bin" and path.with_name(META).is_file():
        return read_raw(path.with_name(META), cell=cell)
    raise FileError(f"{path} {_what_it_is(head)}; give a {KINDS}")


def _head(path: Path) -> bytes:
    """The first bytes of a file, so that its kind is what it holds and not what it is called."""
    try:
        with path.open("rb") as file:
            return file.read(64)
    except FileNotFoundError:
        raise FileError(f"there is no elevation file at {path}; check the path") from None
    except (OSError, ValueError) as error:
        raise FileError(f"cannot read the elevation file {path}: {error}") from None


def _what_it_is(head: bytes) -> str:
    if not head:
        return "is empty"
    if b"<VRTDataset" in head:
        return "is a VRT that only points to other files (gdal_translate IN OUT.tif makes one file)"
    if head.startswith(b"PK"):
        return "is a zip archive (numpy.save writes one array as .npy)"
    return f"is not an elevation file: it begins with {head[:12]!r}"
