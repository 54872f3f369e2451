"""Zones to keep out of and to stay within: polygons from GeoJSON, burnt into the grid."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..core import Bool, FileError, Frame, InputError, SettingError, value
from ._going import Going

LARGEST = 50_000_000
"""Bytes of a zone file at most."""
LONLAT = ("CRS84", "CRS:84", "4326")
"""What names of longitude and latitude contain."""


@value
class Zones:
    """Areas in local metres.

    Attributes:
        avoid: What to keep out of, a shapely geometry; None where there is nothing.
        keep_in: What to stay within; None for everywhere.
        margin: What is kept from their edges [m].
    """

    avoid: Any = None
    keep_in: Any = None
    margin: float = 0.0

    def _check(self) -> None:
        if not (math.isfinite(self.margin) and self.margin >= 0.0):
            raise SettingError(f"the margin must be 0 m or more, got {self.margin!r}")

    def seen_from(self, x: float, y: float) -> Zones:
        """The same zones in local metres that count from the local point (x, y) [m]."""
        import shapely

        def moved(area: Any) -> Any:
            return None if area is None else shapely.transform(area, lambda at: at - (x, y))

        return Zones(avoid=moved(self.avoid), keep_in=moved(self.keep_in), margin=self.margin)

    def forbidden(self, frame: Frame, *, margin: float | None = None) -> Bool:
        """Cells (h, w) that a zone and its margin so much as touch, or do not wholly hold."""
        margin = self.margin if margin is None else margin
        out = np.zeros(frame.shape, bool)
        if self.avoid is not None:
            grown = self.avoid.buffer(margin) if margin > 0.0 else self.avoid
            out |= _burnt(grown, frame, touching=True)
        if self.keep_in is not None:
            shrunk = self.keep_in.buffer(-margin) if margin > 0.0 else self.keep_in
            out |= ~_burnt(shrunk, frame, touching=False)
        return out


def within_zones(ground: Going, zones: Zones) -> Going:
    """The same ground with its zones forbidden."""
    blocked = (ground.hazards.blocked != 0) | zones.forbidden(ground.frame)
    return dataclasses.replace(ground, blocked=blocked.view(np.uint8), zones=zones)


def read_zones(
    frame: Frame,
    *,
    avoid: str | Path | None = None,
    keep_in: str | Path | None = None,
    margin: float = 0.0,
) -> Zones:
    """Zones from GeoJSON files, in the local metres of a map.

    Polygons and multipolygons count, with their holes; several are joined. Coordinates are those
    that the file's member ``crs`` or ``crs_wkt`` names; otherwise longitude and latitude, as RFC
    7946 has it, on the body of the map; on a map without a coordinate system, the map's own.

    Args:
        frame: Of the map.
        avoid: File of what to keep out of.
        keep_in: File of what to stay within.
        margin: What to keep from their edges [m].

    Raises:
        FileError: Missing, no GeoJSON, or without a polygon.
        InputError: A polygon that crosses itself, coordinates that cannot be, or that lie off the
            map.
        SettingError: A margin below 0.
    """
    return Zones(
        avoid=None if avoid is None else _area(Path(avoid), frame),
        keep_in=None if keep_in is None else _area(Path(keep_in), frame),
        margin=margin,
    )


def _area(path: Path, frame: Frame) -> Any:
    """All polygons of a file joined, in local metres."""
    import shapely

    data = load_geojson(path)
    polygons = [shapely.force_2d(polygon) for polygon in _polygons(path, data)]
    if not polygons:
        raise FileError(f"{path} holds no polygon; zones are Polygon or MultiPolygon features")
    for number, polygon in enumerate(polygons):
        if not polygon.is_valid:
            raise InputError(
                f"{path}: zone {number + 1} is no proper polygon: "
                f"{shapely.is_valid_reason(polygon)}; draw it without crossing itself"
            )
        if polygon.is_empty:
            raise InputError(f"{path}: zone {number + 1} is empty; leave it out")
    joined = shapely.unary_union(polygons)
    local = shapely.transform(joined, local_metres(path, data, frame, joined.bounds))
    if not (local.is_valid and np.isfinite(local.bounds).all()):
        raise InputError(
            f"{path}: its coordinates have no place in the map's coordinate system; check its crs"
        )
    width, height = frame.extent
    if not local.intersects(shapely.box(0.0, 0.0, width, height)):
        low, high = frame.to_map(0.0, 0.0), frame.to_map(width, height)
        raise InputError(
            f"{path}: no zone touches the map, which reaches from ({low[0]:.9g}, {low[1]:.9g}) to "
            f"({high[0]:.9g}, {high[1]:.9g}); check the zones' coordinate system"
        )
    return local


def load_geojson(path: Path) -> dict[str, Any]:
    """The outermost object of a GeoJSON file.

    Raises:
        FileError: Missing, too large, or no GeoJSON.
    """
    try:
        if path.stat().st_size > LARGEST:
            raise FileError(f"{path} is larger than {LARGEST // 1_000_000} MB; simplify it")
        data = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise FileError(f"there is no file {path}") from None
    except OSError as error:
        raise FileError(f"{path} cannot be read ({error.strerror})") from None
    except (ValueError, RecursionError) as error:
        raise FileError(f"{path} is no GeoJSON: {str(error).splitlines()[0]}") from None
    if not isinstance(data, dict) or "type" not in data:
        raise FileError(f"{path} is no GeoJSON: it has no member type")
    return data


def _polygons(path: Path, data: Any, depth: int = 0) -> Iterator[Any]:
    """Every polygon of a GeoJSON object."""
    import shapely

    kind = data.get("type") if isinstance(data, dict) else None
    parts = {"FeatureCollection": "features", "GeometryCollection": "geometries"}.get(str(kind))
    if parts and depth < 8 and isinstance(data.get(parts), list):
        for item in data[parts]:
            yield from _polygons(path, item, depth + 1)
    elif kind == "Feature" and depth < 8:
        if data.get("geometry") is not None:
            yield from _polygons(path, data["geometry"], depth + 1)
    elif kind in ("Polygon", "MultiPolygon"):
        rings: Any = data.get("coordinates") or ()
        try:
            several = [rings] if kind == "Polygon" else rings
            for polygon in several:
                shell, *holes = [np.array(ring, np.float64)[:, :2] for ring in polygon]
                if not all(np.isfinite(ring).all() for ring in (shell, *holes)):
                    raise ValueError("a coordinate is not finite")
                yield shapely.Polygon(shell, holes)
        except (TypeError, ValueError, IndexError, shapely.errors.ShapelyError) as error:
            said = str(error).splitlines()[0]
            raise FileError(f"{path}: a polygon's coordinates are damaged: {said}") from None
    else:
        raise FileError(f"{path} holds a {kind}; zones are Polygon or MultiPolygon features")


def local_metres(path: Path, data: dict[str, Any], frame: Frame, bounds: Any) -> Any:
    """A function from the file's coordinates (n, 2) to local metres.

    Raises:
        InputError: Coordinates that are no longitude and latitude, or an unknown coordinate system.
    """
    named = _named_crs(data)
    if frame.crs is None or (named is not None and named == frame.crs):
        return lambda xy: np.column_stack(frame.to_local(*xy.T))
    from pyproj import CRS, Transformer
    from pyproj.exceptions import ProjError

    own = CRS.from_wkt(frame.crs)
    if named is None or (any(word in named for word in LONLAT) and not _on_earth(own)):
        west, south, east, north = bounds
        if not (west >= -360.0 and east <= 360.0 and south >= -90.0 and north <= 90.0):
            raise InputError(
                f"{path}: coordinates like ({west:.9g}, {south:.9g}) are no longitude and "
                "latitude; name their coordinate system in a member crs or crs_wkt"
            )
        source = own.geodetic_crs
    else:
        try:
            source = CRS.from_user_input(named)
        except ProjError:
            raise InputError(
                f"{path} names a coordinate system that nobody knows: {named[:80]!r}"
            ) from None
    try:
        change = Transformer.from_crs(source, own, always_xy=True)
    except ProjError:
        raise InputError(
            f"{path}: its coordinate system cannot be brought to the map's; they may lie on "
            "different bodies"
        ) from None

    def convert(xy: Any) -> Any:
        x, y = change.transform(*xy.T)
        return np.column_stack(frame.to_local(x, y))

    return convert


def _named_crs(data: dict[str, Any]) -> str | None:
    if isinstance(data.get("crs_wkt"), str):
        return data["crs_wkt"]
    crs = data.get("crs")
    properties = crs.get("properties") if isinstance(crs, dict) else None
    name = properties.get("name") if isinstance(properties, dict) else None
    return name if isinstance(name, str) else None


def _on_earth(crs: Any) -> bool:
    return abs(crs.ellipsoid.semi_major_metre - 6_378_137.0) < 10_000.0


def _burnt(geometry: Any, frame: Frame, *, touching: bool) -> Bool:
    """Cells (h, w) that a geometry touches, or those that it wholly covers.

    Squares of cells are judged whole and cut into four only where an edge crosses them.
    """
    import shapely

    (h, w), cell = frame.shape, frame.cell
    out = np.zeros((h, w), bool)
    if geometry.is_empty:
        return out
    shapely.prepare(geometry)
    side = 1 << max(h - 1, w - 1, 1).bit_length()
    squares = np.array([[0, 0]])
    while squares.size:
        row, column = squares.T
        boxes = shapely.box(
            column * cell, row * cell,
            np.minimum(column + side, w) * cell, np.minimum(row + side, h) * cell,
        )  # fmt: skip
        crossed = shapely.intersects(geometry, boxes)
        covered = np.zeros(len(boxes), bool)
        covered[crossed] = shapely.covers(geometry, boxes[crossed])
        for i, j in squares[covered]:
            out[i : i + side, j : j + side] = True
        squares = squares[crossed & ~covered]
        if side == 1:
            if touching:
                out[squares[:, 0], squares[:, 1]] = True
            break
        side //= 2
        squares = (squares[:, None] + side * np.array([[0, 0], [0, 1], [1, 0], [1, 1]])).reshape(
            -1, 2
        )
        squares = squares[(squares[:, 0] < h) & (squares[:, 1] < w)]
    return out
