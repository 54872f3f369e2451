"""GeoTIFF elevation models, through the GDAL library inside rasterio."""

from __future__ import annotations

import logging
import math
import warnings
from pathlib import Path
from typing import Any, cast

import numpy as np

from ..core import FileError, Frame, RovernavError, SettingError
from ._elevation import Terrain

MAX_CELLS = 400_000_000
"""Largest grid that is read: its heights alone take 1.6 GB."""

SQUARE_WITHIN = 1e-3
"""Largest relative difference between the two sides of a cell that still counts as square."""

_METRES = {"", "m", "metre", "metres", "meter", "meters"}


def read_geotiff(
    path: Path, *, cell: float | None = None, most_cells: int | None = None
) -> Terrain:
    """The heights in band 1 of a GeoTIFF, as terrain.

    North-up and south-up files both end with row 0 in the south; nodata and masked cells become
    NaN; a scale and an offset that the file states are applied. A file without georeference needs
    `cell`, and its row 0 is taken as north. The coordinate system may be missing.

    Args:
        path: The file; only GDAL's GTiff driver may open it.
        cell: Side of a cell [m], only for a file without georeference.
        most_cells: Cells that are read at most; 400 million by default.

    Raises:
        FileError: Damaged, an image, too large, rotated, or not on a square grid in metres.
        SettingError: `cell` is missing, or given for a file that has its own.
    """
    import rasterio
    from rasterio.errors import NotGeoreferencedWarning

    log = logging.getLogger("rasterio")
    quiet = log.level
    try:
        log.setLevel(logging.CRITICAL)  # the same fact reaches the user once, as our sentence
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", NotGeoreferencedWarning)
            gdal = cast(Any, rasterio)
            with gdal.Env(), gdal.open(path, driver="GTiff") as data:
                return _terrain(data, path, cell, most_cells or MAX_CELLS)
    except RovernavError:
        raise
    except Exception as error:  # damaged files raise whatever GDAL meets, in several families
        reason = str(error).partition("\n")[0] or type(error).__name__
        raise FileError(
            f"{path} is a damaged or cut-off GeoTIFF ({reason}); fetch or export it again"
        ) from None
    finally:
        log.setLevel(quiet)


def _terrain(data: Any, path: Path, cell: float | None, most: int) -> Terrain:
    _check_bands(data, path, most)
    frame, north_up = _frame(data, path, cell)
    heights = _heights(data)
    if north_up:
        heights = heights[::-1]
    return Terrain.from_heights(heights, frame, name=path.stem, source=f"GeoTIFF {path.name}")


def _check_bands(data: Any, path: Path, most: int) -> None:
    if data.count != 1:
        raise FileError(
            f"{path} has {data.count} bands, so it is an image rather than an elevation model; "
            "give a file with one band (gdal_translate -b 1 IN OUT.tif takes the first)"
        )
    if data.colorinterp[0].name == "palette" or np.dtype(data.dtypes[0]).kind not in "iuf":
        raise FileError(
            f"{path} holds {data.colorinterp[0].name} values of type {data.dtypes[0]}, not "
            "heights; give an elevation model in whole or floating-point metres"
        )
    if data.width * data.height > most:
        raise FileError(
            f"{path} has {data.width:,} x {data.height:,} cells, more than {most:,}; crop it "
            "first (gdal_translate -srcwin XOFF YOFF WIDTH HEIGHT IN OUT.tif)"
        )
    unit = (data.units[0] or "").lower()
    if unit not in _METRES:
        raise FileError(f"{path} has heights in {unit!r}; convert them to metres first")


def _frame(data: Any, path: Path, cell: float | None) -> tuple[Frame, bool]:
    """The frame, and whether row 0 of the file is the north edge."""
    shape = (data.height, data.width)
    if data.transform.is_identity and data.crs is None:
        if cell is None:
            raise SettingError(f"{path} does not say how large its cells are; give --cell METRES")
        return Frame(cell=cell, shape=shape), True
    side = _square_side(data.transform, path)
    crs = _crs(data, path)
    if cell is not None:
        raise SettingError(f"{path} has its own cells of {side:g} m; leave --cell out")
    t = data.transform
    south = t.f if t.e > 0 else t.f + t.e * data.height
    return Frame(cell=side, shape=shape, origin=(t.c, south), crs=crs), t.e < 0


def _square_side(t: Any, path: Path) -> float:
    if max(abs(t.b), abs(t.d)) > 1e-6 * abs(t.a) or t.a <= 0 or t.e == 0:
        raise FileError(
            f"{path} is rotated or mirrored (geotransform {tuple(t)[:6]}); "
            "turn it north-up first (gdalwarp IN OUT.tif)"
        )
    if abs(abs(t.e) - t.a) > SQUARE_WITHIN * t.a:
        raise FileError(
            f"{path} has cells of {t.a:g} x {abs(t.e):g}, not squares; "
            "resample it first (gdalwarp -tr SIZE SIZE IN OUT.tif)"
        )
    return math.sqrt(t.a * abs(t.e))


def _crs(data: Any, path: Path) -> str | None:
    """The coordinate system as WKT; it must be in metres."""
    if data.crs is None:
        return None
    if data.crs.is_geographic:
        raise FileError(
            f"{path} is in degrees; reproject it to metres first "
            "(gdalwarp -t_srs 'EPSG:326ZZ' IN OUT.tif on Earth, or an equirectangular system)"
        )
    unit, factor = data.crs.linear_units_factor
    if abs(factor - 1.0) > 1e-9:
        raise FileError(f"{path} has coordinates in {unit}; reproject it to metres first")
    return str(data.crs.to_wkt())


def _heights(data: Any) -> Any:
    """Band 1 with NaN for no data: float32 where that holds every value, else float64."""
    band = data.read(1, masked=True)
    scale, offset = float(data.scales[0]), float(data.offsets[0])
    exact = (band.dtype.kind == "f" and band.dtype.itemsize <= 4) or band.dtype.itemsize <= 2
    plain = scale == 1.0 and offset == 0.0
    heights = band.astype(np.float32 if exact and plain else np.float64).filled(np.nan)
    return heights if plain else heights * scale + offset
