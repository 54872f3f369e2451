"""Planned routes as CSV and GeoJSON, in local metres and in the terrain's own coordinates."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np

from ..core import write_text
from ..plan import Route
from ..terrain import Terrain
from ._path import LOCAL, feature, write_features


def write_route_csv(route: Route, path: Path, *, terrain: Terrain | None = None) -> None:
    """Write one line per point of a route; only the header where there is no way.

    Columns: distance_m along the route, x_m, y_m in the local frame; with a terrain also map_x,
    map_y in its own coordinates and elevation_m.

    Args:
        route: The route.
        path: Where to write.
        terrain: The ground, if any.

    Raises:
        FileError: The file cannot be written there.
    """
    x, y = route.points.T
    along = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])[: len(x)]
    header, columns = ["distance_m", "x_m", "y_m"], [along, x, y]
    if terrain is not None:
        header += ["map_x", "map_y", "elevation_m"]
        columns += [*terrain.frame.to_map(x, y), terrain.elevation_at(x, y)]
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([repr(float(cell)) for cell in row] for row in zip(*columns, strict=True))
    write_text(path, out.getvalue())


def write_route_geojson(route: Route, path: Path, *, terrain: Terrain | None = None) -> None:
    """Write a route as a GeoJSON line; where there is no way, the nearest point, if there is one.

    Coordinates are the terrain's own, or local metres without one; see `write_path_geojson`.

    Args:
        route: The route.
        path: Where to write.
        terrain: The ground, if any.

    Raises:
        FileError: The file cannot be written there.
    """
    frame = terrain.frame if terrain is not None else LOCAL
    told = {"status": route.status, "way": str(route.way), "reason": route.reason or None}
    if not route.found:
        near = route.nearest
        features = [] if near is None else [feature("Point", [*frame.to_map(*near)], told)]
        return write_features(path, frame, features)
    line = [list(map(float, frame.to_map(x, y))) for x, y in route.points]
    told |= {"length_m": route.length, "cost": route.cost}
    lone = len(line) == 1
    features = [
        feature("Point" if lone else "LineString", line[0] if lone else line, told),
        feature("Point", line[0], {"name": "start"}),
        feature("Point", line[-1], {"name": "goal"}),
    ]
    return write_features(path, frame, features)
