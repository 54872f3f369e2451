"""Grids written as GeoTIFF, in the coordinates of the model that they come from."""

from __future__ import annotations

import json
import os
import secrets
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

import numpy as np

from .._version import __version__
from ..core import FileError, Frame, ShapeError
from ._elevation import Terrain
from ._gdal import REMOTE

ROWS = 512
"""Rows that are written at a time."""
SLIGHT = 1e-3
"""Rounding of heights to short floats may tilt the ground between two cells by so much [1]."""


def write_terrain(
    terrain: Terrain, path: str | Path, *, tags: Mapping[str, Any] | None = None
) -> Path:
    """Write a terrain as GeoTIFF: heights in metres, NaN where there is no data.

    Heights are short floats unless that would roughen the ground, as it does where cells are small
    and heights count from far away.

    Args:
        terrain: The ground.
        path: The file; its folder is made if needed.
        tags: More to say in the file's tags: a seed, settings. Values that are no text become JSON.

    Raises:
        FileError: It cannot be written there.
    """
    low, high = terrain.span
    coarse = float(np.spacing(np.float32(max(abs(low), abs(high))))) > SLIGHT * terrain.frame.cell
    kind = np.float64 if coarse else np.float32
    heights = terrain.height.astype(kind) + kind(terrain.offset)
    said = {"source": terrain.source, **(tags or {})}
    return write_geotiff(heights, terrain.frame, path, unit="m", description="elevation", tags=said)


def write_geotiff(
    values: Any,
    frame: Frame,
    path: str | Path,
    *,
    unit: str = "",
    description: str = "",
    tags: Mapping[str, Any] | None = None,
) -> Path:
    """Write any grid of a frame as GeoTIFF: north up, tiled, compressed without loss.

    A crash leaves the old file or the new one, never a part.

    Args:
        values: (h, w) numbers, row 0 south; floats with NaN for no data, or whole numbers.
        frame: Where the cells lie; its coordinate system and place are kept exactly.
        path: The file; its folder is made if needed.
        unit: Of the values.
        description: What they are.
        tags: More to say in the file's tags, beside the version of rovernav.

    Raises:
        ShapeError: The values are not of the frame's shape, or no numbers.
        FileError: It cannot be written there.
    """
    values, path = np.asarray(values), Path(path)
    if values.dtype == np.bool_:
        values = values.astype(np.uint8)
    if values.shape != frame.shape or values.dtype.kind not in "iuf":
        raise ShapeError(
            f"a GeoTIFF needs numbers of the frame's shape {frame.shape}, got {values.dtype} of "
            f"shape {values.shape}"
        )
    if not path.name or "\0" in path.name or REMOTE.search(str(path)):
        raise FileError(f"cannot write {str(path)!r}: that is no file name")
    scratch = path.with_name(f".{path.name}.{secrets.token_hex(4)}.tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            _write(values, frame, scratch, (unit, description), dict(tags or {}))
            with scratch.open("rb") as file:
                os.fsync(file.fileno())
            scratch.replace(path)
        finally:
            scratch.unlink(missing_ok=True)
    except OSError as error:
        raise FileError(f"cannot write {path}: {error.strerror or error}") from error
    return path


def _write(
    values: Any, frame: Frame, path: Path, words: tuple[str, str], tags: dict[str, Any]
) -> None:
    import rasterio
    from rasterio.errors import RasterioError

    floats = values.dtype.kind == "f"
    gdal, (h, w) = cast(Any, rasterio), values.shape
    profile: dict[str, Any] = {
        "driver": "GTiff", "count": 1, "height": h, "width": w, "dtype": values.dtype,
        "transform": _transform(frame), "compress": "deflate", "BIGTIFF": "IF_SAFER",
        "predictor": 3 if floats else 2,
    }  # fmt: skip
    if min(h, w) >= 64:
        profile |= {"tiled": True, "blockxsize": 256, "blockysize": 256}
    if frame.crs is not None:
        profile["crs"] = gdal.crs.CRS.from_wkt(frame.crs)
    if floats:
        profile["nodata"] = float("nan")
    try:
        with gdal.Env(GDAL_CACHEMAX=128), gdal.open(os.path.abspath(path), "w", **profile) as data:
            data.update_tags(TIFFTAG_SOFTWARE=f"rovernav {__version__}", **_said(tags))
            data.set_band_description(1, words[1])
            data.units = (words[0],)
            for top in range(0, h, ROWS):
                rows = min(ROWS, h - top)
                band = np.ascontiguousarray(values[h - top - rows : h - top][::-1])
                data.write(band, 1, window=gdal.windows.Window(0, top, w, rows))
    except RasterioError as error:
        raise FileError(f"cannot write {path}: {str(error).partition(chr(10))[0]}") from None


def _transform(frame: Frame) -> Any:
    """From the file's columns and rows, row 0 north, to map coordinates."""
    from rasterio.transform import Affine

    (xx, xy), (yx, yy) = frame.axes
    c, top = frame.cell, frame.shape[0] * frame.cell
    (x, y) = frame.origin
    return Affine(xx * c, -xy * c, x + xy * top, yx * c, -yy * c, y + yy * top)


def _said(tags: dict[str, Any]) -> dict[str, str]:
    """Tags as text, named as the file's own."""
    return {
        f"ROVERNAV_{key.upper()}": item if isinstance(item, str) else json.dumps(item)
        for key, item in tags.items()
    }
