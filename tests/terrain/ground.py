"""Small grounds that several tests stand on."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from rovernav.core import Frame
from rovernav.terrain import Terrain


def ground(heights: Any, cell: float = 1.0) -> Terrain:
    """Terrain from heights, row 0 south."""
    heights = np.asarray(heights, dtype=np.float64)
    frame = Frame(cell=cell, shape=heights.shape)
    return Terrain.from_heights(heights, frame, name="test", source="test")


def plane(p: float, q: float, *, shape: tuple[int, int] = (7, 9), cell: float = 0.5) -> Terrain:
    """A plane that rises by p per metre to the east and by q to the north."""
    i, j = np.indices(shape)
    return ground((p * j + q * i) * cell, cell)


def rough(rng: np.random.Generator, shape: tuple[int, int], missing: float = 0.0) -> np.ndarray:
    """Random heights [m], a share of them missing."""
    heights = rng.normal(0.0, 1.0, shape).astype(np.float32)
    heights[rng.random(shape) < missing] = np.nan
    return heights


def write_tiff(path: Path, rows: Any, **profile: Any) -> Path:
    """A GeoTIFF whose first row is `rows[0]`; by default north-up, 2 m cells, corner (100, 5000).

    A profile entry of None is left out.
    """
    import rasterio
    from rasterio.transform import Affine

    rows = np.asarray(rows)
    bands = rows if rows.ndim == 3 else rows[None]
    settings: dict[str, Any] = {
        "driver": "GTiff",
        "count": bands.shape[0],
        "height": bands.shape[1],
        "width": bands.shape[2],
        "dtype": bands.dtype,
        "crs": MARS,
        "transform": Affine(2.0, 0.0, 100.0, 0.0, -2.0, 5000.0),
        **profile,
    }
    given = {key: item for key, item in settings.items() if item is not None}
    with rasterio.open(path, "w", **given) as file:
        file.write(bands)
    return path


MARS = (
    'PROJCS["Mars",GEOGCS["Mars",DATUM["Mars",SPHEROID["Mars",3396190,0]],PRIMEM["Reference",0],'
    'UNIT["degree",0.0174532925199433]],PROJECTION["Equirectangular"],'
    'PARAMETER["standard_parallel_1",0],PARAMETER["central_meridian",0],UNIT["metre",1]]'
)
