"""Height grids that are plain numbers: NumPy files, raw 16-bit heights, tables of text."""

from __future__ import annotations

import json
import math
import warnings
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..core import FileError, build, read_text
from ._gdal import Options, needed_cell, refuse_cell, words_of
from ._posts import ArrayPosts, Placing

HEIGHTS = "heights.bin"
LARGEST_TEXT = 1_000_000_000
"""A table of text larger than this is refused [bytes]."""
NAMED = ("elevation", "elevations", "height", "heights", "dem", "z")
"""What heights are called inside an .npz file."""

Grid = tuple[Placing, ArrayPosts]


def read_npy(path: Path, given: Options) -> Grid:
    """A two-dimensional NumPy array of heights [m]: row 0 is the NORTH edge, NaN means no data.

    Raises:
        FileError: Damaged, or not a two-dimensional array of numbers; pickled objects are refused.
        SettingError: The cell is missing.
    """
    cell = needed_cell(path, given.cell)
    try:
        array: Any = np.load(path, allow_pickle=False, mmap_mode="r")
    except Exception as error:  # a damaged header goes through Python's own parser
        raise FileError(
            f"{path} is not a whole NumPy array of numbers ({words_of(error)}); write it with "
            "numpy.save"
        ) from None
    return _square(path, array, cell, given)


def read_npz(path: Path, given: Options) -> Grid:
    """Heights inside a NumPy archive, with where they lie.

    The array is called elevation, height, heights, dem or z. ``xmin, xmax, ymin, ymax`` place its
    edges, in degrees where they can be and the cell is below a tenth of one; ``cell`` is a side in
    metres. Row 0 is the north edge, unless it lies at ymin and that is the lower one by name only.

    Raises:
        FileError: Damaged, or without such an array.
        SettingError: It does not say how large its cells are.
    """
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as data:
            found = [name for name in NAMED if name in data.files]
            if not found:
                raise FileError(
                    f"{path} holds no heights (it has {', '.join(data.files[:6])}); name the array "
                    f"{NAMED[0]}"
                )
            _check_member(path, found[0])
            array = data[found[0]]
            numbers = {n: float(data[n]) for n in data.files if data[n].shape == ()}
    except FileError:
        raise
    except Exception as error:
        raise FileError(
            f"{path} is not a whole NumPy archive ({words_of(error)}); write it again"
        ) from None
    edges = [numbers.get(key, math.nan) for key in ("xmin", "xmax", "ymin", "ymax")]
    if "cell" in numbers or not np.isfinite(edges).all():
        cell = numbers.get("cell", given.cell)
        return _square(path, array, needed_cell(path, cell), given)
    return _between_edges(path, array, edges, given)


def _between_edges(path: Path, array: Any, edges: Sequence[float], given: Options) -> Grid:
    _check_numbers(path, array)
    west, east, *ends = edges
    south, north = min(ends), max(ends)
    h, w = array.shape
    step = ((east - west) / w, (north - south) / h)
    if not min(step) > 0:
        raise FileError(f"{path} has edges that span no area: xmin, xmax, ymin, ymax = {edges}")
    refuse_cell(path, given.cell, step[0])
    degrees = max(map(abs, (west, east))) <= 360 and max(-south, north) <= 90 and max(step) < 0.1
    placing = Placing(shape=(h, w), corner=(west, south), step=step, crs=_wgs84() * degrees or None)
    return placing, _rows(array, given)


def _wgs84() -> str:
    from pyproj import CRS

    return CRS.from_epsg(4326).to_wkt()


def _check_member(path: Path, name: str) -> None:
    """A small archive must not unpack to more than a table may have."""
    with zipfile.ZipFile(path) as archive:
        size = archive.getinfo(f"{name}.npy").file_size
    if size > LARGEST_TEXT:
        raise FileError(f"{path}: {name} unpacks to {size:,} bytes, more than {LARGEST_TEXT:,}")


def read_raw(path: Path, given: Options) -> Grid:
    """Raw heights: ``heights.bin`` beside the ``meta.json`` at `path`.

    The heights are grid x grid little-endian uint16, row 0 in the north; a code u stands for
    ``elev_min_m + u / 65535 * (elev_max_m - elev_min_m)``. A cell is ``size_m / grid`` wide.
    ``bounds_proj`` (left, bottom, right, top) and ``crs_wkt`` place the grid on a map and may be
    missing; other keys are not read.

    Raises:
        FileError: A file is missing, damaged or of the wrong size.
        SettingError: A key is missing or wrong, or the cell is given though the file has its own.
    """
    meta = _read_meta(path)
    n, side = meta.grid, meta.size_m / meta.grid
    refuse_cell(path, given.cell, side)
    codes_path = path.with_name(HEIGHTS)
    try:
        size = codes_path.stat().st_size
    except OSError:
        raise FileError(f"there is no height grid at {codes_path}; check the path") from None
    if size != 2 * n * n:
        raise FileError(
            f"{codes_path} has {size:,} bytes, but {n} x {n} heights of two bytes need "
            f"{2 * n * n:,}; fetch it again or correct 'grid' in {path.name}"
        )
    try:
        codes = np.memmap(codes_path, "<u2", "r", shape=(n, n))
    except (OSError, ValueError) as error:
        raise FileError(f"cannot read the height grid {codes_path}: {error}") from None
    corner = (meta.bounds_proj[0], meta.bounds_proj[1]) if meta.bounds_proj else (0.0, 0.0)
    scale = (meta.elev_max_m - meta.elev_min_m) / 65535.0
    placing = Placing(shape=(n, n), corner=corner, step=(side, side), crs=meta.crs_wkt)
    return placing, ArrayPosts(array=codes[::-1], scale=scale, offset=meta.elev_min_m, exact=False)


def read_table(path: Path, given: Options, *, separator: str | None) -> Grid:
    """A table of heights [m] as text: one row of the grid per line, spaces, commas or semicolons.

    Row 0 is the north edge unless told otherwise; ``nan`` means no data; lines that begin with #
    are comments.

    Raises:
        FileError: Not numbers, of rows that differ in length, or too large.
        SettingError: The cell is missing.
    """
    cell = needed_cell(path, given.cell)
    if path.stat().st_size > LARGEST_TEXT:
        raise FileError(
            f"{path} has {path.stat().st_size:,} bytes, more than a table of heights may have "
            f"({LARGEST_TEXT:,}); store it as GeoTIFF"
        )
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # no data: said below
            array = np.loadtxt(path, delimiter=separator, ndmin=2, encoding="utf-8-sig")
    except (ValueError, OSError) as error:
        reason = words_of(error).partition("; ")[0]
        raise FileError(
            f"{path} is not a grid of numbers ({reason}); give every row as many"
        ) from None
    return _square(path, array, cell, given)


def _square(path: Path, array: Any, cell: float, given: Options) -> Grid:
    _check_numbers(path, array)
    shape = (int(array.shape[0]), int(array.shape[1]))
    placing = Placing(shape=shape, corner=(0.0, 0.0), step=(cell, cell))
    return placing, _rows(array, given)


def _rows(array: Any, given: Options) -> ArrayPosts:
    exact = array.dtype.itemsize <= (4 if array.dtype.kind == "f" else 2)
    return ArrayPosts(array=array if given.south_first else array[::-1], exact=exact)


def _check_numbers(path: Path, array: Any) -> None:
    if array.ndim != 2 or array.dtype.kind not in "iuf":
        raise FileError(
            f"{path} holds {array.dtype} of shape {array.shape}; "
            "ground is a two-dimensional array of whole or floating-point metres"
        )
    if min(array.shape) < 1:
        raise FileError(f"{path} holds no number at all; write the heights again")


def _read_meta(path: Path) -> Any:
    from pydantic import BaseModel, ConfigDict, Field, model_validator

    class Meta(BaseModel):
        """What meta.json says."""

        model_config = ConfigDict(extra="ignore", allow_inf_nan=False)
        grid: int = Field(ge=3, le=1_000_000)
        size_m: float = Field(gt=0)
        elev_min_m: float
        elev_max_m: float
        bounds_proj: tuple[float, float, float, float] | None = None
        crs_wkt: str | None = None

        @model_validator(mode="after")
        def agree(self) -> Meta:
            if self.elev_max_m < self.elev_min_m:
                raise ValueError("elev_max_m must not be below elev_min_m")
            if self.bounds_proj:
                left, bottom, right, top = self.bounds_proj
                for side in (right - left, top - bottom):
                    if abs(side - self.size_m) > 1e-3 * self.size_m:
                        raise ValueError(f"bounds_proj spans {side:g} m, size_m {self.size_m:g} m")
            return self

    text = read_text(path, limit=1_000_000, what="description of heights")
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise FileError(f"{path} is not JSON ({error}); fetch or write it again") from None
    if not isinstance(data, dict):
        raise FileError(f"{path} is not a description of heights; it needs keys and values")
    return build(Meta, data, source=str(path))
