"""Elevation files of every kind that rovernav reads, told apart by their first bytes."""

from __future__ import annotations

import dataclasses
import math
import re
from pathlib import Path
from typing import Any

from ..core import FileError, InputError, SettingError
from ._elevation import Terrain
from ._gdal import KINDS as DRIVERS
from ._gdal import REMOTE, Options, Range, read_gdal
from ._raster import Bounds, Progress, Raster

META = "meta.json"
MAP = "map"
KINDS = (
    "GeoTIFF (.tif), PDS or ISIS image, ASCII grid (.asc), NumPy array (.npy, .npz), table of "
    "numbers (.csv, .txt), PNG with --heights, a folder with meta.json and heights.bin, or a map "
    "(ROS .yaml, BARN .world)"
)

_TIFF = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
_PDS3 = (b"PDS_VERSION_ID", b"CCSD3ZF", b"NJPL1I00", b"ODL_VERSION_ID")
_NUMBER = rb"[-+]?(?:\d+\.?\d*(?:[eE][-+]?\d+)?|\.\d+(?:[eE][-+]?\d+)?|nan|NaN)"
_TABLE = re.compile(
    rb"\A(?:\xef\xbb\xbf)?(?:\s*#[^\n]*\n)*\s*" + _NUMBER + rb"(?:\s*([,;])\s*|[ \t]+)" + _NUMBER
)


def read_terrain(
    path: str | Path,
    *,
    cell: float | None = None,
    heights: Range | None = None,
    south_first: bool = False,
    bounds: Bounds | None = None,
    factor: int = 1,
) -> Terrain:
    """Ground heights from an elevation file on this machine, as square cells in true metres.

    ==================================  ============================================================
    GeoTIFF, PDS3, PDS4, ISIS cube      one band; any coordinate system, degrees included
    ASCII grid (.asc)                   ESRI's; its coordinate system in a .prj beside it
    NumPy array (.npy)                  two-dimensional, row 0 = north, NaN = no data; needs `cell`
    NumPy archive (.npz)                an array called elevation, with its edges or its cell
    table of numbers (.csv, .txt)       one row of the grid per line; needs `cell`
    PNG of 8 or 16 bits                 needs `heights` and `cell`
    folder, its meta.json, heights.bin  raw 16-bit heights with a description
    ROS map (.yaml), BARN world         free and blocked cells: level ground, see `Terrain.plain`
    ==================================  ============================================================

    Args:
        path: File or folder.
        cell: Side of a cell [m], for files that do not say it themselves.
        heights: Heights [m] of the darkest and the brightest grey of a picture.
        south_first: Row 0 is the south edge, for files that do not say it themselves.
        bounds: West, south, east, north of a part in map coordinates; metres are true in its
            middle. All of the file where not given.
        factor: So many cells along a side are averaged to one.

    Raises:
        FileError: Missing, damaged, of another kind, or not usable as ground; the sentence says
            what to do.
        SettingError: A setting is missing, out of range, or given for a file that has its own.
    """
    raster = open_raster(path, cell=cell, heights=heights, south_first=south_first)
    if bounds is not None:
        raster.window(*bounds)  # inside out, or off the map
        raster = raster.within(bounds)
    return read_part(raster, bounds, factor)


def read_part(
    raster: Raster, bounds: Bounds | None, factor: int, *, on_progress: Progress | None = None
) -> Terrain:
    """`Raster.read` by map coordinates, with every mistake as a `FileError` or `SettingError`."""
    window = None if bounds is None else raster.window(*bounds)
    try:
        return raster.read(window, factor, on_progress=on_progress)
    except (FileError, SettingError):
        raise
    except InputError as error:
        text = str(error)
        named = text if raster.path.name in text else f"{raster.source}: {text}"
        raise FileError(named) from None


def open_raster(
    path: str | Path,
    *,
    cell: float | None = None,
    heights: Range | None = None,
    south_first: bool = False,
) -> Raster:
    """A lazy handle on an elevation file of any size; arguments as for `read_terrain`.

    Raises:
        FileError: Missing, damaged, of another kind, or not usable as ground.
        SettingError: A setting is missing, out of range, or given for a file that has its own.
    """
    if cell is not None and not (math.isfinite(cell) and cell > 0):
        raise SettingError(f"--cell must be a positive number of metres, got {cell}")
    if heights is not None and not (all(map(math.isfinite, heights)) and heights[0] < heights[1]):
        raise SettingError(f"--heights must be LOW,HIGH with LOW below HIGH, got {heights}")
    if REMOTE.search(str(path)):
        raise FileError(f"{path} is not a file on this machine; download it and give its path")
    given = Options(cell=cell, heights=heights, south_first=south_first)
    try:
        return _open(Path(path), given)
    except (FileError, SettingError):
        raise
    except InputError as error:
        raise FileError(str(error)) from None


def _open(path: Path, given: Options) -> Raster:
    try:
        path = path / META if path.is_dir() else path
    except OSError as error:  # a name that the system cannot have
        raise FileError(f"cannot read {str(path)!r}: {error.strerror or error}") from error
    head = _head(path)
    kind, read = _kind(path, head)
    if given.heights is not None and kind not in DRIVERS:
        raise SettingError(f"--heights is for pictures, and {path} is a {kind}; leave it out")
    if kind in DRIVERS:
        placing, posts = read_gdal(path, kind, given)
        return Raster.over(placing, posts, path=path, kind=DRIVERS[kind])
    path, (placing, posts) = read(path, given)
    name = path.parent.resolve().name if path.name == META else path.stem
    raster = Raster.over(placing, posts, path=path, kind=kind, name=name)
    return dataclasses.replace(raster, plain=kind == MAP)


def _kind(path: Path, head: bytes) -> tuple[str, Any]:
    """The driver that opens a file; or what it is, and what reads it."""
    from . import _grids
    from ._plain import is_plain, read_plain

    driver = _driver(head)
    if driver is not None:
        return driver, None
    if head.startswith(b"\x93NUMPY"):
        return "NumPy array", lambda path, given: (path, _grids.read_npy(path, given))
    if head.startswith(b"PK"):
        return "NumPy archive", lambda path, given: (path, _grids.read_npz(path, given))
    if head.lstrip().startswith(b"{"):
        return "raw heights", lambda path, given: (path, _grids.read_raw(path, given))
    meta = path.with_name(META)
    if path.suffix == ".bin" and meta.is_file():
        return "raw heights", lambda path, given: (meta, _grids.read_raw(meta, given))
    table = _TABLE.match(head)
    if table:
        by = (table[1] or b"").decode() or None
        return "table", lambda path, given: (path, _grids.read_table(path, given, separator=by))
    if is_plain(path, head):
        return MAP, lambda path, given: (path, read_plain(path, given))
    raise FileError(f"{path} {_what_it_is(path, head)}")


def _driver(head: bytes) -> str | None:
    text = head.lstrip(b"\xef\xbb\xbf \t\r\n")
    if head.startswith(_TIFF):
        return "GTiff"
    if head.startswith(b"\x89PNG\r\n\x1a\n"):
        return "PNG"
    if text.startswith(_PDS3):
        return "PDS"
    if text.startswith(b"<") and b"<Product_Observational" in head:
        return "PDS4"
    if re.match(rb"(?i)object\s*=\s*isiscube", text):
        return "ISIS3"
    if re.match(rb"(?i)(ncols|nrows|xll|yll)", text):
        return "AAIGrid"
    return None


def _head(path: Path) -> bytes:
    """The first bytes of a file, so that its kind is what it holds and not what it is called."""
    try:
        with path.open("rb") as file:
            return file.read(4096)
    except FileNotFoundError:
        raise FileError(f"there is no elevation file at {path}; check the path") from None
    except (OSError, ValueError) as error:
        raise FileError(f"cannot read the elevation file {path}: {error}") from None


def _what_it_is(path: Path, head: bytes) -> str:
    """What is wrong with a file that is no ground, and what to give instead."""
    from ._plain import beside

    if head[:2] in (b"P2", b"P5", b"P6"):
        own = beside(path)
        named = f"give {own}" if own else "give its .yaml file, which says how large a cell is"
        return f"is the picture of a map; {named}"
    if not head:
        said = "is empty"
    elif b"<VRTDataset" in head:
        said = "is a VRT that only points to other files (gdal_translate IN OUT.tif makes one file)"
    else:
        said = f"is not an elevation file: it begins with {head[:12]!r}"
    return f"{said}; give a {KINDS}"
