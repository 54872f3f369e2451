"""Planned routes as CSV and GeoJSON, in local metres and in the terrain's own coordinates."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np

from ..core import F64, write_text
from ..plan import Profile, Route, Trip
from ..terrain import Terrain
from ._path import LOCAL, feature, write_features


def write_route_csv(
    route: Route, path: Path, *, terrain: Terrain | None = None, heights: F64 | None = None
) -> None:
    """Write one line per point of a route; only the header where there is no way.

    Columns: distance_m along the route, x_m, y_m in the local frame; with a terrain also map_x,
    map_y in its own coordinates and elevation_m.

    Args:
        route: The route.
        path: Where to write.
        terrain: The ground, if any.
        heights: Elevation of the points (k,) [m], where it is not the terrain's.

    Raises:
        FileError: The file cannot be written there.
    """
    x, y = route.points.T
    along = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])[: len(x)]
    header, columns = ["distance_m", "x_m", "y_m"], [along, x, y]
    if terrain is not None:
        header += ["map_x", "map_y", "elevation_m"]
        above = terrain.elevation_at(x, y) if heights is None else heights
        columns += [*terrain.frame.to_map(x, y), above]
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


def write_trip_geojson(trip: Trip, path: Path, *, terrain: Terrain) -> None:
    """Write a trip as GeoJSON: a line for each leg with what it costs, and its stops.

    Coordinates are the terrain's own, as in `write_path_geojson`; the member ``local_m`` of each
    line holds the local metres. Where a stop cannot be reached, the legs before it, the nearest
    reachable point and the reason.

    Args:
        trip: The trip.
        path: Where to write.
        terrain: The ground.

    Raises:
        FileError: The file cannot be written there.
    """
    frame, features = terrain.frame, []
    accounts = trip.account()
    for number, (leg, told) in enumerate(zip(trip.legs, accounts, strict=False)):
        line = [list(map(float, frame.to_map(x, y))) for x, y in leg.points]
        lone = len(line) == 1
        told = {
            "name": "route", "leg": number + 1, "status": leg.status,
            "objective": trip.ground.objective, "rover": trip.ground.rover.name,
            "length_m": told["length"], "cost": told["cost"], "unit": trip.ground.unit,
            "time_s": told["time"], "energy_j": told["energy"],
            "local_m": leg.points.tolist(),
        }  # fmt: skip
        features.append(feature("Point" if lone else "LineString", line[0] if lone else line, told))
    for number, (x, y) in enumerate(trip.stops.tolist()):
        name = {0: "start", len(trip.stops) - 1: "goal"}.get(number, f"stop {number}")
        features.append(feature("Point", [*map(float, frame.to_map(x, y))], {"name": name}))
    if not trip.found:
        told = {"name": "nearest", "status": trip.status, "reason": trip.reason}
        if trip.nearest is not None:
            place = [*map(float, frame.to_map(*trip.nearest))]
            features.append(feature("Point", place, told))
    write_features(path, frame, features)


def write_profile_csv(told: Profile, path: Path, *, terrain: Terrain) -> None:
    """Write one line per station of a profile.

    Columns: distance_m, x_m, y_m (local), map_x, map_y (the terrain's own), elevation_m, slope_deg,
    pitch_deg, roll_deg, slip, slip_low, slip_high, energy_j_per_m, measured (1 or 0).

    Args:
        told: From `plan.profile`.
        path: Where to write.
        terrain: The ground.

    Raises:
        FileError: The file cannot be written there.
    """
    east, north = terrain.frame.to_map(told.x, told.y)  # type: ignore[arg-type]
    angles = [np.degrees(angle) for angle in (told.slope, told.pitch, told.roll)]
    columns = {
        "distance_m": told.distance, "x_m": told.x, "y_m": told.y, "map_x": east, "map_y": north,
        "elevation_m": told.elevation,
        **dict(zip(("slope_deg", "pitch_deg", "roll_deg"), angles, strict=True)),
        "slip": told.slip, "slip_low": told.slip_low, "slip_high": told.slip_high,
        "energy_j_per_m": told.energy, "measured": told.measured.astype(int),
    }  # fmt: skip
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([repr(float(c)) for c in row] for row in zip(*columns.values(), strict=True))
    write_text(path, out.getvalue())
