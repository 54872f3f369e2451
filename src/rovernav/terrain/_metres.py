"""True metres: how long a map unit is on the ground.

Symbols: M, N radii of curvature along and across the meridian [m], a semi-major axis [m], e
eccentricity, phi latitude, lambda longitude [rad]. At a place,

    M = a (1 - e^2) / (1 - e^2 sin^2 phi)^1.5,    N = a / (1 - e^2 sin^2 phi)^0.5,

so that a step of (d lambda, d phi) is (N cos phi d lambda, M d phi) metres long to the east and to
the north (J. P. Snyder, Map Projections, USGS Professional Paper 1395, 1987, p. 24).
"""

from __future__ import annotations

import functools
import math
from typing import Any, NamedTuple

import numpy as np

from ..core import F64, FileError

TRUE_WITHIN = 1e-3
"""Map metres this close to true ones count as true: those of UTM within its zones do."""

SQUARE_WITHIN = 1e-3
"""Largest relative difference between the two sides of a cell that still counts as square."""

ZONE = 4.0
"""Transverse Mercator farther than this from its middle meridian is not meant [deg]."""


class Unit(NamedTuple):
    """What a map unit is on the ground at one place.

    Attributes:
        metric: ((g11, g12), (g12, g22)): a map step d is sqrt(d . g d) true metres long.
        north: Direction of true north, clockwise from the map's +y [rad].
        note: What a reader should know about it; empty where all is plain.
    """

    metric: F64
    north: float
    note: str


def map_unit(crs: str | None, x: float, y: float, *, source: str = "the file") -> Unit:
    """What a step on the map at (x, y) is on the ground.

    Args:
        crs: The coordinate system as WKT; without one, map units are metres.
        x: Map coordinate, in the units of `crs`; degrees to the east where it is geographic.
        y: Map coordinate.
        source: Named in errors.

    Raises:
        FileError: The coordinate system cannot be understood, or has no such place.
    """
    if not crs:
        return Unit(np.eye(2), 0.0, "")
    system = _system(crs, source)
    if not (system.is_geographic or system.is_projected):
        step = float(system.axis_info[0].unit_conversion_factor) if system.axis_info else 1.0
        return Unit(np.eye(2) * step**2, 0.0, "")
    ground = _ground_steps(system, x, y, source)
    metric = ground.T @ ground
    north = math.atan2(*np.linalg.solve(ground, [0.0, 1.0]))
    if _off_its_zone(system, _place(system, x, y, source)[0]):
        note = f"lies outside of the zone of {system.name}; its units are taken as plain metres"
        return Unit(np.eye(2), 0.0, note)
    if np.abs(metric - np.eye(2)).max() <= 2.0 * TRUE_WITHIN:
        return Unit(np.eye(2), north, "")
    return Unit(metric, north, "")


def true_north(crs: str | None, x: float, y: float) -> float:
    """Direction of true north at a map point, clockwise from the map's +y [rad]."""
    return map_unit(crs, x, y).north


def radius_of(crs: str | None) -> float | None:
    """The body's radius (semi-major axis) [m], where the coordinate system says it."""
    if not crs:
        return None
    ellipsoid = _system(crs, "the coordinate system").ellipsoid
    return None if ellipsoid is None else float(ellipsoid.semi_major_metre)


def geographic(crs: str | None, source: str = "the file") -> bool:
    """Whether map coordinates are degrees of longitude and latitude."""
    return bool(crs) and bool(_system(str(crs), source).is_geographic)


@functools.lru_cache(maxsize=32)
def _system(crs: str, source: str) -> Any:
    from pyproj import CRS
    from pyproj.exceptions import CRSError

    try:
        system: Any = CRS.from_wkt(crs)
    except CRSError as error:
        reason = str(error).partition("\n")[0]
        raise FileError(
            f"{source} has a coordinate system that cannot be understood ({reason}); assign "
            "another (gdal_edit.py -a_srs EPSG:NUMBER FILE)"
        ) from None
    return system.sub_crs_list[0] if system.is_compound else system


def _ground_steps(system: Any, x: float, y: float, source: str) -> F64:
    """(2, 2): metres to the east and to the north per map unit along x and along y."""
    step = 1e-5 if system.is_geographic else 10.0 / _unit(system)
    _, phi = _place(system, x, y, source)
    to = [_place(system, x + step * s, y + step * t, source) for s, t in _STAR]
    ellipsoid: Any = system.ellipsoid
    a = ellipsoid.semi_major_metre
    squash = 1.0 - (ellipsoid.semi_minor_metre / a) ** 2
    sine = 1.0 - squash * math.sin(math.radians(phi)) ** 2
    east = a / math.sqrt(sine) * math.cos(math.radians(phi))
    north = a * (1.0 - squash) / sine**1.5
    columns: list[list[float]] = []
    for (lon1, lat1), (lon0, lat0) in (to[:2], to[2:]):
        turn = math.remainder(lon1 - lon0, 360.0)
        columns.append([math.radians(turn) * east, math.radians(lat1 - lat0) * north])
    ground = np.array(columns).T / (2.0 * step)
    if not (np.isfinite(ground).all() and abs(np.linalg.det(ground)) > 0.0):
        raise FileError(_nowhere(system, x, y, source))
    return ground


_STAR = ((1, 0), (-1, 0), (0, 1), (0, -1))


def _unit(system: Any) -> float:
    """Metres per unit of a projected system."""
    return float(system.axis_info[0].unit_conversion_factor) if system.axis_info else 1.0


def _place(system: Any, x: float, y: float, source: str) -> tuple[float, float]:
    """Longitude and latitude [deg] of a map point."""
    if system.is_geographic:
        lon, lat = x, y
    else:
        lon, lat = _to_degrees(system)(x, y)
    if not (math.isfinite(lon) and abs(lat) < 90.0 - 1e-9 and abs(lon) <= 720.0):
        raise FileError(_nowhere(system, x, y, source))
    return lon, lat


@functools.lru_cache(maxsize=32)
def _to_degrees(system: Any) -> Any:
    from pyproj import Transformer

    return Transformer.from_crs(system, system.geodetic_crs, always_xy=True).transform


def _off_its_zone(system: Any, lon: float) -> bool:
    """Whether a transverse Mercator map is used where nobody would: then its CRS is a dummy."""
    how = system.coordinate_operation if system.is_projected else None
    if how is None or how.method_name != "Transverse Mercator":
        return False
    middle = {p.name: p.value for p in how.params}.get("Longitude of natural origin", lon)
    return abs(math.remainder(lon - middle, 360.0)) > ZONE


def _nowhere(system: Any, x: float, y: float, source: str) -> str:
    return (
        f"{source} has its middle at ({x:.10g}, {y:.10g}), which is no place in its coordinate "
        f"system {system.name}; assign the right one (gdal_edit.py -a_srs EPSG:NUMBER FILE)"
    )
