"""Routes from GeoJSON, in the local metres of a map."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..core import F64, FileError, Frame, InputError
from ._zones import load_geojson, local_metres


def read_route(path: str | Path, frame: Frame) -> F64:
    """The points of a route (k, 2) in local metres, from a GeoJSON file.

    All lines of the file count, one after the other: legs of a trip. Coordinates are read as
    `read_zones` reads them: those of the file's ``crs_wkt`` or ``crs``, otherwise longitude and
    latitude, or on a map without a coordinate system the map's own. Files that ``rovernav route``
    writes are such files.

    Raises:
        FileError: Missing, no GeoJSON, or without a line.
        InputError: Coordinates that cannot be.
    """
    path = Path(path)
    data = load_geojson(path)
    lines = list(_lines(path, data))
    if not lines:
        raise FileError(
            f"{path} holds no line; a route is a LineString, as rovernav route writes it"
        )
    points = np.concatenate(lines)
    bounds = (*points.min(axis=0), *points.max(axis=0))
    local = np.asarray(local_metres(path, data, frame, bounds)(points), np.float64)
    if not np.isfinite(local).all():
        raise InputError(
            f"{path}: its coordinates have no place in the map's coordinate system; check its crs"
        )
    moved = np.any(np.diff(local, axis=0) != 0.0, axis=1)
    return np.ascontiguousarray(local[np.concatenate([[True], moved])])


def _lines(path: Path, data: Any, depth: int = 0) -> Iterator[F64]:
    """Coordinates (k, 2) of every line of a GeoJSON object; points and areas do not count."""
    kind = data.get("type") if isinstance(data, dict) else None
    parts = {"FeatureCollection": "features", "GeometryCollection": "geometries"}.get(str(kind))
    if parts and depth < 8 and isinstance(data.get(parts), list):
        for item in data[parts]:
            yield from _lines(path, item, depth + 1)
    elif kind == "Feature" and depth < 8:
        yield from _lines(path, data.get("geometry"), depth + 1)
    elif kind in ("LineString", "MultiLineString"):
        several = data.get("coordinates") or ()
        try:
            for line in [several] if kind == "LineString" else several:
                points = np.array([point[:2] for point in line], np.float64).reshape(-1, 2)
                if not (len(points) and np.isfinite(points).all()):
                    raise ValueError("it needs points of two finite numbers")
                yield points
        except (TypeError, ValueError, IndexError) as error:
            said = str(error).splitlines()[0]
            raise FileError(f"{path}: a line's coordinates are damaged: {said}") from None
