"""Height grids that are plain arrays: NumPy files, and raw 16-bit heights with a description."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from ..core import FileError, Frame, SettingError, build, read_bytes, read_text
from ._elevation import Terrain

MAX_CELLS = 400_000_000
HEIGHTS = "heights.bin"


def read_npy(path: Path, *, cell: float | None) -> Terrain:
    """A two-dimensional NumPy array of heights [m]: row 0 is the NORTH edge, NaN means no data.

    Args:
        path: The .npy file; pickled objects are refused.
        cell: Side of a cell [m]; the file does not hold it.

    Raises:
        FileError: Damaged, or not a two-dimensional array of numbers.
        SettingError: `cell` is missing.
    """
    if cell is None:
        raise SettingError(f"{path} does not say how large its cells are; give --cell METRES")
    try:
        array = np.load(path, allow_pickle=False, mmap_mode="r")
    except Exception as error:  # a damaged header goes through Python's own parser
        reason = str(error).partition("\n")[0] or type(error).__name__
        raise FileError(
            f"{path} is not a whole NumPy array of numbers ({reason}); write it with numpy.save"
        ) from None
    if array.ndim != 2 or array.dtype.kind not in "iuf":
        raise FileError(
            f"{path} holds {array.dtype} of shape {array.shape}; "
            "ground is a two-dimensional array of whole or floating-point metres"
        )
    _check_size(array.size, path)
    frame = Frame(cell=cell, shape=(int(array.shape[0]), int(array.shape[1])))
    heights = np.ascontiguousarray(array[::-1])
    return Terrain.from_heights(heights, frame, name=path.stem, source=f"NumPy array {path.name}")


def read_raw(path: Path, *, cell: float | None) -> Terrain:
    """Raw heights: ``heights.bin`` beside the ``meta.json`` at `path`.

    The heights are grid x grid little-endian uint16, row 0 in the north; a code u stands for
    ``elev_min_m + u / 65535 * (elev_max_m - elev_min_m)``. A cell is ``size_m / grid`` wide.
    ``bounds_proj`` (left, bottom, right, top) and ``crs_wkt`` place the grid on a map and may be
    missing; other keys are not read.

    Raises:
        FileError: A file is missing, damaged or of the wrong size.
        SettingError: A key is missing or wrong, or `cell` is given though the file has its own.
    """
    meta = _read_meta(path)
    side = meta.size_m / meta.grid
    if cell is not None:
        raise SettingError(f"{path} has its own cells of {side:g} m; leave --cell out")
    n = meta.grid
    _check_size(n * n, path)
    codes_path = path.with_name(HEIGHTS)
    raw = read_bytes(codes_path, limit=2 * MAX_CELLS, what="height grid")
    if len(raw) != 2 * n * n:
        raise FileError(
            f"{codes_path} has {len(raw):,} bytes, but {n} x {n} heights of two bytes need "
            f"{2 * n * n:,}; fetch it again or correct 'grid' in {path.name}"
        )
    share = np.frombuffer(raw, "<u2").reshape(n, n)[::-1] / 65535.0
    heights = share * (meta.elev_max_m - meta.elev_min_m) + meta.elev_min_m
    origin = (meta.bounds_proj[0], meta.bounds_proj[1]) if meta.bounds_proj else (0.0, 0.0)
    frame = Frame(cell=side, shape=(n, n), origin=origin, crs=meta.crs_wkt)
    name = path.absolute().parent.name
    return Terrain.from_heights(heights, frame, name=name, source=f"raw heights {name}")


def _check_size(cells: int, path: Path) -> None:
    if cells > MAX_CELLS:
        raise FileError(f"{path} has {cells:,} cells, more than {MAX_CELLS:,}; crop it first")


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
    return build(Meta, data, source=str(path))
