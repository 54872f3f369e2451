"""Elevation files that the GDAL library inside rasterio reads: GeoTIFF, PDS, ISIS, ASCII grids.

Only files on this machine, and only through the drivers named here; a file that leads out of its
own folder is refused.
"""

from __future__ import annotations

import contextlib
import logging
import os
import re
import sys
import warnings
from collections.abc import Generator
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np

from ..core import FileError, Float, RovernavError, SettingError, value
from ._metres import radius_of
from ._posts import Placing, Read

KINDS = {
    "GTiff": "GeoTIFF",
    "PDS": "PDS3 image",
    "PDS4": "PDS4 image",
    "ISIS3": "ISIS cube",
    "AAIGrid": "ASCII grid",
    "PNG": "PNG image",
    "PNM": "PGM image",
}
"""Drivers that may open a file, and what each is called."""

LARGEST_BLOCK = 256_000_000
"""A file whose smallest readable piece is larger than this is refused [bytes]."""

HUGE = 1e30
"""Where a file marks missing heights by a larger number, as ISIS does by several, all are so."""

UNITS = {
    "": 1.0, "m": 1.0, "metre": 1.0, "metres": 1.0, "meter": 1.0, "meters": 1.0,
    "km": 1000.0, "kilometre": 1000.0, "kilometres": 1000.0, "kilometer": 1000.0,
    "kilometers": 1000.0, "dm": 0.1, "cm": 0.01, "centimetre": 0.01, "centimeter": 0.01,
    "mm": 0.001, "millimetre": 0.001, "millimeter": 0.001,
    "ft": 0.3048, "foot": 0.3048, "feet": 0.3048,
    "us-ft": 1200 / 3937, "ftus": 1200 / 3937, "us survey foot": 1200 / 3937,
    "foot_us": 1200 / 3937,
}  # fmt: skip
"""Metres per unit of height."""

REMOTE = re.compile(r"^[A-Za-z][A-Za-z0-9+.]+:/|^/vsi|://")
"""Names that GDAL would take for something else than a file on this machine."""

Range = tuple[float, float]
"""Heights of the darkest and the brightest grey [m]."""


class Options(NamedTuple):
    """What the reader of a file is told, where the file does not say it."""

    cell: float | None = None
    heights: Range | None = None
    south_first: bool = False


@value
class GdalPosts:
    """Heights in band 1 of a file.

    Attributes:
        path: The file.
        driver: The one driver that may open it.
        rows: Rows of posts.
        turned: Whether row 0 of the file is the north edge.
        scale: Metres per unit.
        offset: Height of 0 [m].
        exact: Whether float32 holds every height.
    """

    path: Path
    driver: str
    rows: int
    turned: bool
    scale: float
    offset: float
    exact: bool

    @contextlib.contextmanager
    def open(self) -> Generator[Read]:
        """Open the file; what is yielded reads windows of it.

        Raises:
            FileError: What was asked for is damaged or cut off.
        """
        with opened(self.path, self.driver) as data:
            yield lambda *window: self._read(data, *window)

    def _read(self, data: Any, row: int, column: int, rows: int, columns: int) -> Float:
        import rasterio.windows

        area: Any = rasterio.windows.Window
        top = self.rows - row - rows if self.turned else row
        window = area(column, top, columns, rows)
        plain = self.scale == 1.0 and self.offset == 0.0
        kind = np.float32 if self.exact and plain else np.float64
        flags = {flag.name for flag in data.mask_flag_enums[0]}
        if np.dtype(data.dtypes[0]).kind == "f" and flags <= {"nodata", "all_valid"}:
            heights = data.read(1, window=window)  # without the mask, which costs more than it
            _clear(heights, data.nodata)
            heights = heights.astype(kind, copy=False)
        else:
            band = data.read(1, window=window, masked=True)
            heights = cast(Float, band.astype(kind).filled(np.nan))
        if not plain:
            heights = heights * self.scale + self.offset
        return heights[::-1] if self.turned else heights


def _clear(heights: Float, nodata: float | None) -> None:
    """NaN where heights are the value for no data; all numbers near the largest are, with one."""
    if nodata is None or np.isnan(nodata):
        return
    if abs(nodata) > HUGE:
        heights[np.abs(heights) > HUGE] = np.nan
    else:
        heights[heights == heights.dtype.type(nodata)] = np.nan


@contextlib.contextmanager
def opened(path: Path, driver: str) -> Generator[Any]:
    """The open dataset; whatever goes wrong with it becomes one sentence.

    Raises:
        FileError: Damaged, cut off, or leading out of its folder.
    """
    import rasterio
    from rasterio.errors import NotGeoreferencedWarning

    log = logging.getLogger("rasterio")
    quiet = log.level
    gdal = cast(Any, rasterio)
    try:
        log.setLevel(logging.CRITICAL)  # the same fact reaches the user once, as our sentence
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", NotGeoreferencedWarning)
            with (
                _hushed(),
                gdal.Env(GDAL_CACHEMAX=256, CPL_VSIL_CURL_ALLOWED_EXTENSIONS="none"),
                gdal.open(os.path.abspath(path), driver=driver) as data,
            ):
                _stays(data, path)
                yield data
    except RovernavError:
        raise
    except MemoryError:
        raise
    except Exception as error:  # damaged files raise whatever GDAL meets, in several families
        raise FileError(
            f"{path} is a damaged or cut-off {KINDS[driver]} ({words_of(error)}); fetch or export "
            "it again"
        ) from None
    finally:
        log.setLevel(quiet)


def words_of(error: Exception) -> str:
    """The first words of another library's error, short enough for a sentence."""
    words = str(error).partition("\n")[0] or type(error).__name__
    return words if len(words) <= 160 else f"{words[:157]}..."


@contextlib.contextmanager
def _hushed() -> Generator[None]:
    """Keep from the terminal that rasterio could not decode what GDAL said about odd bytes."""
    before = sys.unraisablehook

    def hook(seen: Any) -> None:
        if not isinstance(seen.exc_value, UnicodeDecodeError):
            before(seen)

    sys.unraisablehook = hook
    try:
        yield
    finally:
        sys.unraisablehook = before


def _stays(data: Any, path: Path) -> None:
    """A label may name another file for its data: only one beside itself."""
    home = path.resolve().parent
    for name in data.files:
        if name.startswith("/vsi") or home not in Path(name).resolve().parents:
            raise FileError(
                f"{path} takes its data from {name}, outside of its own folder; put the files "
                "together in one folder"
            )


def read_gdal(path: Path, driver: str, given: Options) -> tuple[Placing, GdalPosts]:
    """Where the posts of a file lie, and what reads them.

    Raises:
        FileError: Damaged, an image, rotated, or in units that are not known.
        SettingError: `given` lacks what the file does not say, or contradicts it.
    """
    with opened(path, driver) as data:
        _check_bands(data, path)
        if driver == "PNG" and given.heights is None:
            raise SettingError(
                f"{path} is a picture; if it is a map of heights, say what its greys mean: "
                "--heights LOW,HIGH and --cell METRES"
            )
        placing, turned = _placing(data, path, given)
        scale, offset = _scaling(data, path, given, placing.crs)
        kind = np.dtype(data.dtypes[0])
        exact = kind.itemsize <= (4 if kind.kind == "f" else 2)
    posts = GdalPosts(
        path=path, driver=driver, rows=placing.shape[0], turned=turned, scale=scale,
        offset=offset, exact=exact,
    )  # fmt: skip
    return placing, posts


def _check_bands(data: Any, path: Path) -> None:
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
    rows, columns = data.block_shapes[0]
    size = rows * columns * np.dtype(data.dtypes[0]).itemsize
    if size > LARGEST_BLOCK:
        raise FileError(
            f"{path} keeps {rows:,} x {columns:,} heights in one piece of {size / 1e9:.1f} GB; "
            "store it in tiles first (gdal_translate -co TILED=YES IN OUT.tif)"
        )


def _placing(data: Any, path: Path, given: Options) -> tuple[Placing, bool]:
    """Where the posts lie, and whether row 0 of the file is the north edge."""
    shape, t = (int(data.height), int(data.width)), data.transform
    if t.is_identity and data.crs is None:
        side = needed_cell(path, given.cell)
        return Placing(shape=shape, corner=(0.0, 0.0), step=(side, side)), not given.south_first
    if max(abs(t.b), abs(t.d)) > 1e-6 * abs(t.a) or t.a <= 0 or t.e == 0:
        raise FileError(
            f"{path} is rotated or mirrored (geotransform {tuple(t)[:6]}); "
            "turn it north-up first (gdalwarp IN OUT.tif)"
        )
    if not np.isfinite(tuple(t)[:6]).all():
        raise FileError(f"{path} has no finite geotransform, got {tuple(t)[:6]}; export it again")
    refuse_cell(path, given.cell, t.a)
    south = t.f if t.e > 0 else t.f + t.e * data.height
    crs = None if data.crs is None else str(data.crs.to_wkt())
    step = (float(t.a), float(abs(t.e)))
    return Placing(shape=shape, corner=(float(t.c), float(south)), step=step, crs=crs), t.e < 0


def _scaling(data: Any, path: Path, given: Options, crs: str | None) -> Range:
    """Metres per unit, and the height of 0 [m]."""
    scale, offset = float(data.scales[0]), float(data.offsets[0])
    if given.heights is not None:
        return _grey_scale(data.dtypes[0], path, given.heights)
    unit = (data.units[0] or "").strip().lower()
    if unit not in UNITS:
        raise FileError(
            f"{path} has heights in {unit!r}, not in m, km, cm, mm, ft or us-ft; convert them to "
            "metres first"
        )
    if not (np.isfinite([scale, offset]).all() and scale != 0.0):
        raise FileError(
            f"{path} has a scale of {scale:g} and an offset of {offset:g}, which give no heights; "
            "set them right (gdal_edit.py -scale 1 -offset 0 FILE)"
        )
    metres = UNITS[unit]
    radius = radius_of(crs) or 0.0
    if radius and abs(offset * metres - radius) < 0.01 * radius:
        offset -= radius / metres  # heights counted from the middle of the body
    return scale * metres, offset * metres


def _grey_scale(kind: str, path: Path, heights: Range) -> Range:
    if kind not in ("uint8", "uint16"):
        raise SettingError(
            f"--heights is for pictures of 8 or 16 bits, and {path} holds {kind}; leave it out"
        )
    low, high = heights
    return (high - low) / (255.0 if kind == "uint8" else 65535.0), low


def needed_cell(path: Path, cell: float | None) -> float:
    """The cell that a file does not say itself.

    Raises:
        SettingError: It was not given.
    """
    if cell is None:
        raise SettingError(
            f"{path} does not say how large its cells are; give --cell METRES, or cell: METRES in "
            "a scenario"
        )
    return cell


def refuse_cell(path: Path, cell: float | None, own: float) -> None:
    """A cell that was given for a file with its own is a mistake.

    Raises:
        SettingError: It was given.
    """
    if cell is not None:
        raise SettingError(f"{path} has its own cells of {own:g} m; leave --cell out")
