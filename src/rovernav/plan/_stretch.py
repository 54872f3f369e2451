"""A long way looked at stretch by stretch, at full resolution."""

from __future__ import annotations

import dataclasses
import math
from typing import Any, NamedTuple, cast

import numpy as np

from ..core import F64
from ..rover import Rover, hazards
from ..terrain import Raster, Window
from ._directed import USUAL, directed
from ._ends import Point
from ._going import Going, going
from ._profile import Profile, account_of, profile
from ._route import Route
from ._survey import beyond, ground_of
from ._zones import Zones, within_zones

MARGIN = 192
"""Cells around a stretch that are looked at too ..."""
WIDER, MOST = 2.5, 16_000_000
"""... so many times more where its way touches their edge or there is none, up to so many cells."""
NEAR = 2.5
"""A stretch may end so many blocks beside the line over blocks ..."""
LOOSE = 0.5
"""... or, where none of that can be reached in the widest window, this share of its length."""


class Errand(NamedTuple):
    """What is planned over a raster that may be larger than memory.

    Attributes:
        raster: The ground.
        rover: Who goes.
        objective: "distance", "time", "energy" or "risk".
        soil: A soil or its name; the rover's own where not given.
        zones: What to keep out of and to stay within, in the raster's local metres.
        neighbours: Moves of the directed search: 8, 16 or 32.
    """

    raster: Raster
    rover: Rover
    objective: str = "distance"
    soil: Any = None
    zones: Zones | None = None
    neighbours: int = USUAL


class Piece(NamedTuple):
    """A part of the way.

    Attributes:
        points: (k, 2) [m].
        account: Length, cost, its terms, time, energy, steepest ground.
        stations: Its profile.
        heights: Elevation of the points (k,) [m].
    """

    points: F64
    account: dict[str, Any]
    stations: Profile
    heights: F64


class Look:
    """A window of the raster, judged; local points are those of the raster."""

    def __init__(self, errand: Errand, window: Window, *, effort: bool = False) -> None:
        """Read and judge it; `effort` adds the layers that only `why_here` tells of."""
        raster, self.window, self._errand = errand.raster, window, errand
        cell = raster.frame.cell
        self.corner = np.array([window.column * cell, window.row * cell])
        self.terrain = ground_of(raster, window, raster.heights(window))
        self.ground: Going | None = None
        if self.terrain is not None:
            judged = hazards(self.terrain, errand.rover, soil=errand.soil, effort=effort)
            self.ground = going(judged, errand.rover, objective=errand.objective)
            if errand.zones is not None:
                seen = errand.zones.seen_from(float(self.corner[0]), float(self.corner[1]))
                self.ground = within_zones(self.ground, seen)

    def holds(self, point: F64) -> bool:
        """Whether a point [m] lies in the window, its edge included."""
        cell, (x, y) = self._errand.raster.frame.cell, point - self.corner
        return bool(0.0 <= x <= self.window.columns * cell and 0.0 <= y <= self.window.rows * cell)

    def near(self, start: F64, target: F64, off: float) -> F64 | None:
        """The place nearest to a target that can be reached, at most so far off it [m], or None."""
        from scipy import ndimage

        if self.ground is None or not self.holds(start):
            return None
        frame = self.ground.frame
        regions, _count = cast(Any, ndimage).label(self.ground.blocked == 0)
        here = regions[frame.cell_of(*(start - self.corner))]
        if here == 0:
            return None
        cells = np.argwhere(regions == here)
        middles = (cells[:, ::-1] + 0.5) * frame.cell + self.corner
        square = ((middles - target) ** 2).sum(axis=1)
        nearest = int(square.argmin())
        return middles[nearest] if square[nearest] <= off * off else None

    def way(self, start: F64, goal: F64) -> Route | None:
        """The cheapest way within the window; None where there is none."""
        if self.ground is None:
            return None
        a, b = start - self.corner, goal - self.corner
        found = directed(self.ground, a, b, neighbours=self._errand.neighbours)
        return found if found.found else None

    def touched(self, points: F64) -> bool:
        """Whether a way (k, 2) in the window comes near an edge of it that is not the raster's."""
        (h, w), at = self._errand.raster.frame.shape, self.window
        near = beyond(self._errand.rover, self._errand.raster.frame.cell) + 2.0
        x, y = (points / self._errand.raster.frame.cell).T
        return bool(
            (at.column > 0 and x.min() < near)
            or (at.row > 0 and y.min() < near)
            or (at.column + at.columns < w and x.max() > at.columns - near)
            or (at.row + at.rows < h and y.max() > at.rows - near)
        )

    def piece(self, here: F64) -> Piece:
        """What a way (k, 2) [m] in the window's own points costs."""
        assert self.ground is not None
        assert self.terrain is not None
        told = profile(self.ground, here, self.terrain)
        told = dataclasses.replace(told, x=told.x + self.corner[0], y=told.y + self.corner[1])
        heights = np.asarray(self.terrain.elevation_at(*here.T))
        return Piece(here + self.corner, account_of(self.ground, here), told, heights)


def window_over(errand: Errand, points: F64, margin: float) -> Window | None:
    """The cells within a margin [cells] of a way's box; None where they are too many."""
    (h, w), cell = errand.raster.frame.shape, errand.raster.frame.cell
    low = np.floor(points.min(axis=0) / cell - margin).astype(int)
    high = np.ceil(points.max(axis=0) / cell + margin).astype(int)
    left, row = max(0, int(low[0])), max(0, int(low[1]))
    columns, rows = min(w, int(high[0])) - left, min(h, int(high[1])) - row
    rows, row = _at_least(rows, row, h)
    columns, left = _at_least(columns, left, w)
    if rows * columns > MOST:
        return None
    return Window(row=row, column=left, rows=rows, columns=columns)


def _at_least(count: int, first: int, whole: int) -> tuple[int, int]:
    """A side of three cells or more, where the raster has them."""
    count = min(max(count, 3), whole)
    return count, min(first, whole - count)


class Failed(Exception):
    """There is no way over a stretch within the window that was looked at last."""

    def __init__(self, window: Window) -> None:
        super().__init__("no way")
        self.window = window


def stretch(
    errand: Errand,
    along: F64,
    *,
    off: float = 0.0,
    driven: bool = False,
    ready: Look | None = None,
) -> tuple[F64, Look]:
    """The cheapest way between the ends of a line, in a window around it that widens as needed.

    Args:
        errand: What is planned.
        along: The line (k, 2) [m].
        off: How far from its end to end at most, where that cannot be reached [m].
        driven: Whether the line itself can be driven; then the cheaper one counts.
        ready: What to look at first, instead of a window around the line, if the line begins in it.

    Returns:
        Its points (k, 2) [m], which count from the window's corner, and the window.

    Raises:
        Failed: There is none.
    """
    margin, last = float(MARGIN), None
    ready = ready if ready is not None and ready.holds(along[0]) else None
    while True:
        window = window_over(errand, along, margin)
        if window is None or (last is not None and _as_large(last[1].window, window)):
            break
        look = Look(errand, window) if ready is None else ready
        ready = None
        goal = look.near(along[0], along[-1], off) if off > 0.0 else along[-1]
        found = None if goal is None else look.way(along[0], goal)
        path = np.empty((0, 2)) if found is None else found.points
        if driven and look.ground is not None:
            own = look.ground.cost_of(along - look.corner)
            if own <= (math.inf if found is None else found.cost):
                path = along - look.corner
        last = path, look
        if len(path) and not look.touched(path):
            break
        margin *= WIDER
    if last is not None and not len(last[0]) and off > 0.0:
        last = _loosely(last[1], along)
    if last is None or not len(last[0]):
        raise Failed(last[1].window if last is not None else _middle_of(errand, along))
    return last


def _loosely(look: Look, along: F64) -> tuple[F64, Look]:
    """The way to the nearest place to a line's end that can be reached, so that it leads on."""
    goal = look.near(along[0], along[-1], LOOSE * float(lengths(along)[-1]))
    found = None if goal is None else look.way(along[0], goal)
    return (np.empty((0, 2)) if found is None else found.points), look


def _as_large(one: Window, other: Window) -> bool:
    return (one.rows, one.columns) == (other.rows, other.columns)


def _middle_of(errand: Errand, along: F64) -> Window:
    window = window_over(errand, along[len(along) // 2][None], MARGIN)
    assert window is not None
    return window


def lengths(points: F64) -> F64:
    """Distance of each point along a way [m]."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])


def at(point: Any) -> Point:
    """A point as two numbers."""
    return float(point[0]), float(point[1])
