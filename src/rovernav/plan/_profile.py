"""A route looked at from close by: the ground along it, and why it runs where it runs."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from ..core import F64, Bool, InputError, value
from ..rover import drive_cost, drive_table
from ..terrain import Terrain
from ._ends import check_point
from ._going import Going

MOST = 4000
"""Stations of a profile at most."""
AROUND_CELLS, AROUND_SHARE = 20.0, 0.05
"""The straight alternative at a place spans so many cells, or this share of the route, on either
side, whichever is longer."""


@value
class Profile:
    """Ground and effort at stations along a route, all (n,), float64.

    Attributes:
        distance: Along the route [m].
        x: East [m].
        y: North [m].
        elevation: [m].
        slope: Of the ground over the rover's footing [rad].
        pitch: Nose up, in the direction of travel [rad].
        roll: Left side up [rad].
        slip: Expected, 0 to 1; NaN without motors, as are all below.
        slip_low: Lower edge of the band of likely slip.
        slip_high: Upper edge.
        energy: [J per metre of map].
        measured: Whether slopes like that were measured, bool.
    """

    distance: F64
    x: F64
    y: F64
    elevation: F64
    slope: F64
    pitch: F64
    roll: F64
    slip: F64
    slip_low: F64
    slip_high: F64
    energy: F64
    measured: Bool


def profile(ground: Going, points: Any, terrain: Terrain) -> Profile:
    """Stations about half a cell apart, at most 4,000, along a path (k, 2) of local points [m].

    Raises:
        InputError: The path has no points.
    """
    points = np.asarray(points, np.float64)
    if len(points) == 0:
        raise InputError("there is no way, so there is no profile of it")
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    count = int(np.clip(2.0 * along[-1] / ground.frame.cell, 2, MOST)) if along[-1] > 0.0 else 1
    at = np.linspace(0.0, along[-1], count)
    x, y = (np.interp(at, along, points[:, axis]) for axis in range(2))
    heading = _headings(points, along, at)
    row, column = _cells(ground, x, y)
    layers = ground.hazards.layers
    p, q = (layers[name].values[row, column].astype(np.float64) for name in ("east", "north"))
    rise = p * np.cos(heading) + q * np.sin(heading)
    across = q * np.cos(heading) - p * np.sin(heading)
    empty = np.full(count, np.nan)
    bands = {"expected": empty, "low": empty, "high": empty}
    energy, measured = empty, np.ones(count, bool)
    if ground.table is not None:
        cost = drive_cost(p, q, heading, ground.table)
        energy, measured = cost.energy, np.asarray(cost.measured, bool)
        for band in bands:
            table = drive_table(ground.rover, ground.hazards.soil, slip=band)
            bands[band] = drive_cost(p, q, heading, table).slip
    return Profile(
        distance=at, x=x, y=y, elevation=np.asarray(terrain.elevation_at(x, y)),
        slope=layers["slope"].values[row, column].astype(np.float64), pitch=np.arctan(rise),
        roll=np.arctan(across / np.sqrt(1.0 + rise * rise)), slip=bands["expected"],
        slip_low=bands["low"], slip_high=bands["high"], energy=energy, measured=measured,
    )  # fmt: skip


def _headings(points: F64, along: F64, at: F64) -> F64:
    if len(points) == 1:
        return np.zeros(len(at))
    piece = np.clip(np.searchsorted(along, at, side="right") - 1, 0, len(points) - 2)
    dx, dy = np.diff(points, axis=0).T
    return np.arctan2(dy, dx)[piece]


def _cells(ground: Going, x: F64, y: F64) -> tuple[Any, Any]:
    h, w = ground.frame.shape
    cell = ground.frame.cell
    return np.minimum((y / cell).astype(int), h - 1), np.minimum((x / cell).astype(int), w - 1)


def account_of(ground: Going, points: F64) -> dict[str, Any]:
    """Length, cost, its terms, time, energy and steepest ground of a way (k, 2) [m]."""
    energy = None if ground.table is None else ground.by("energy").cost_of(points)
    terms = ground.split(points).sum(axis=0)
    return {
        "length": float(np.hypot(*np.diff(points, axis=0).T).sum()),
        "cost": ground.cost_of(points),
        "terms": dict(zip(ground.terms, map(float, terms), strict=True)),
        "time": ground.by("time").cost_of(points),
        "energy": energy,
        "steepest": ground.hazards.standing.steepest(points),
    }


def why_here(ground: Going, points: Any, place: Any) -> dict[str, Any]:
    """Why a route runs where it does, at the point of it that is nearest to a place.

    Args:
        ground: What the route was planned on.
        points: The route (k, 2) [m].
        place: Local point (x, y) [m].

    Returns:
        `at`: that point [m]; `distance`: along the route [m]; `off`: from the place [m]; `layers`:
        the ground there; `per_metre`: the terms of the cost of a metre there; `stretch`: the route
        around it and `straight`: the straight line in its place, each with `length` [m], `cost`
        (infinite where a limit forbids it) and `terms`; `dearer`: cost of the straight line less
        that of the stretch; `forbidden`: metres of the straight line in forbidden cells.

    Raises:
        InputError: No route, or no place.
    """
    points = np.asarray(points, np.float64)
    x, y = check_point(place, "place")
    if len(points) < 2:
        raise InputError("there is no way of two points or more to explain")
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    here, off = nearest_on(points, along, (x, y))
    width = max(AROUND_CELLS * ground.frame.cell, AROUND_SHARE * along[-1])
    low, high = max(0.0, here - width), min(along[-1], here + width)
    stretch = cut(points, along, low, high)
    straight = stretch[[0, -1]]
    small = min(0.25 * ground.frame.cell, 0.5 * along[-1])
    bit = cut(points, along, max(0.0, here - small), min(along[-1], here + small))
    terms = ground.split(bit).sum(axis=0) / np.hypot(*np.diff(bit, axis=0).T).sum()
    at = tuple(float(np.interp(here, along, points[:, axis])) for axis in range(2))
    cell = ground.frame.cell_of(*at)
    told = [_costs(ground, path) for path in (stretch, straight)]
    return {
        "at": at,
        "distance": here,
        "off": off,
        "layers": {
            name: {"value": float(layer.values[cell]), "unit": layer.unit}
            for name, layer in ground.hazards.layers.items()
        },
        "per_metre": dict(zip(ground.terms, map(float, terms), strict=True)),
        "stretch": told[0],
        "straight": told[1],
        "dearer": told[1]["cost"] - told[0]["cost"],
        "forbidden": _forbidden(ground, straight),
    }


def _costs(ground: Going, path: F64) -> dict[str, Any]:
    terms = ground.split(path).sum(axis=0)
    return {
        "length": float(np.hypot(*np.diff(path, axis=0).T).sum()),
        "cost": ground.cost_of(path),
        "terms": dict(zip(ground.terms, map(float, terms), strict=True)),
    }


def _forbidden(ground: Going, line: F64) -> float:
    """Metres of a straight line in cells that are forbidden whatever the direction, about."""
    length = float(np.hypot(*(line[1] - line[0])))
    count = max(2, int(8.0 * length / ground.frame.cell))
    share = (np.arange(count) + 0.5) / count
    x, y = (line[0, axis] + share * (line[1, axis] - line[0, axis]) for axis in range(2))
    return float(ground.blocked[_cells(ground, x, y)].mean()) * length


def nearest_on(points: F64, along: F64, place: tuple[float, float]) -> tuple[float, float]:
    """Distance along the path of its point nearest to a place, and how far off it is [m]."""
    a, step = points[:-1], np.diff(points, axis=0)
    square = np.maximum((step**2).sum(axis=1), 1e-300)
    share = np.clip(((np.array(place) - a) * step).sum(axis=1) / square, 0.0, 1.0)
    off = np.hypot(*(a + share[:, None] * step - place).T)
    k = int(off.argmin())
    return float(along[k] + share[k] * (along[k + 1] - along[k])), float(off[k])


def cut(points: F64, along: F64, low: float, high: float) -> F64:
    """The part of a path between two distances along it."""
    inner = points[(along > low) & (along < high)]
    ends = [[np.interp(d, along, points[:, axis]) for axis in range(2)] for d in (low, high)]
    return np.vstack([ends[0], inner, ends[1]])


def waypoints(points: Any, *, apart: float) -> F64:
    """Points for a driver: the corners of a path (k, 2) [m], and more, at most `apart` [m] apart.

    Raises:
        InputError: No way, or a distance that is not above 0.
    """
    points = np.asarray(points, np.float64)
    if len(points) == 0:
        raise InputError("there is no way, so it has no waypoints")
    if not apart > 0.0:
        raise InputError(f"waypoints must be more than 0 m apart, got {apart!r}")
    out = [points[:1]]
    for a, b in itertools.pairwise(points):
        parts = max(1, int(np.ceil(np.hypot(*(b - a)) / apart)))
        out.append(a + np.arange(1, parts + 1)[:, None] / parts * (b - a))
    return np.vstack(out)
