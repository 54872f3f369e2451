"""Driven paths as CSV and GeoJSON, in local metres and in the terrain's own coordinates."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .._version import __version__
from ..core import Frame, InputError, write_text
from ..terrain import Terrain

if TYPE_CHECKING:
    from ..sim import Trace  # a route is written without the simulator

LOCAL = Frame(cell=1.0, shape=(1, 1))


def write_path_csv(trace: Trace, path: Path, *, terrain: Terrain | None = None, k: int = 0) -> None:
    """Write one line per step of rover k.

    Columns: time_s, x_m, y_m, heading_rad in the local frame; with a terrain also map_x, map_y in
    its own coordinates and elevation_m.

    Args:
        trace: The drive.
        path: Where to write.
        terrain: The ground that was driven, if any.
        k: Which rover.

    Raises:
        InputError: The trace keeps no path.
        FileError: The file cannot be written there.
    """
    check_path(trace, k)
    last = int(trace.steps[k]) + 1
    header = ["time_s", "x_m", "y_m", "heading_rad"]
    columns = [trace.time[:last, k], *trace.pose[:last, k].T]
    if terrain is not None:
        header += ["map_x", "map_y", "elevation_m"]
        x, y = trace.path(k).T
        columns += [*terrain.frame.to_map(x, y), terrain.elevation_at(x, y)]
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([repr(float(cell)) for cell in row] for row in zip(*columns, strict=True))
    write_text(path, out.getvalue())


def write_path_geojson(
    trace: Trace, path: Path, *, terrain: Terrain | None = None, k: int | None = 0
) -> None:
    """Write the path of rover k as a GeoJSON line, with start, goal and outcome.

    Coordinates are the terrain's own, or local metres without one. RFC 7946 knows only WGS 84 on
    Earth; for other ground the member ``crs_wkt`` names the coordinate system, and GIS programs
    let the user set it.

    Args:
        trace: The drive.
        path: Where to write.
        terrain: The ground that was driven, if any.
        k: Which rover; None writes all, each feature with the number of its ``rover``.

    Raises:
        InputError: The trace keeps no path.
        FileError: The file cannot be written there.
    """
    frame = terrain.frame if terrain is not None else LOCAL
    if k is not None:
        return write_features(path, frame, _features(trace, k, frame, {}))
    every = range(len(trace.outcome))
    found = [each for one in every for each in _features(trace, one, frame, {"rover": one})]
    return write_features(path, frame, found)


def _features(trace: Trace, k: int, frame: Frame, more: dict[str, Any]) -> list[dict[str, Any]]:
    check_path(trace, k)
    line = [list(map(float, frame.to_map(x, y))) for x, y in trace.path(k)]
    ends = trace.mission.start[k, :2], trace.mission.goal[k]
    start, goal = (list(map(float, frame.to_map(*map(float, end)))) for end in ends)
    track = {
        "outcome": trace.ended(k).label,
        "length_m": float(trace.length[k]),
        "time_s": float(trace.time[-1, k]),
        "steps": int(trace.steps[k]),
        "seed": trace.seed,
    }
    way = ("LineString", line) if len(line) > 1 else ("Point", line[0])
    return [
        feature(*way, {**track, **more}),
        feature("Point", start, {"name": "start", **more}),
        feature("Point", goal, {"name": "goal", **more}),
    ]


def check_path(trace: Trace, k: int) -> None:
    """Raise `InputError` unless the trace keeps the way of rover k."""
    if len(trace.pose) <= trace.steps[k]:
        raise InputError("this trace keeps only where the drive ended; record 'path' or 'all'")


def write_features(path: Path, frame: Frame, features: list[dict[str, Any]]) -> None:
    """Write a GeoJSON file of features whose coordinates are those of `frame`."""
    collection = {
        "type": "FeatureCollection",
        "generator": f"rovernav {__version__}",
        "crs_wkt": frame.crs,
        "features": features,
    }
    write_text(path, json.dumps(collection, indent=1, allow_nan=False) + "\n")


def feature(kind: str, coordinates: list[Any], properties: dict[str, Any]) -> dict[str, Any]:
    """One feature of a GeoJSON file."""
    return {
        "type": "Feature",
        "properties": properties,
        "geometry": {"type": kind, "coordinates": coordinates},
    }
