"""A route meets a driver: a goal that runs ahead along it, and a new route where it is blocked."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple, final

import numpy as np

from ..core import F64, I64, Command, Controller, Memory, Mission, Observation, SettingError
from ..kernels import drive as kernels
from ..mapping import LocalMap, aimed
from ..plan import CostMap, any_angle
from ._replan import Sheet, blocked_cells, met
from ._why import Why, explain


class _Trip(NamedTuple):
    """Where one rover is on its way.

    Attributes:
        route: Points (k, 2) [m], the last one the goal.
        along: How far it has come [m].
        known: Cells of the map that it found blocked (m, 2): row, column.
        wait: Steps until it may plan again.
        plans: Routes made on the way.
    """

    route: F64
    along: float
    known: I64
    wait: int
    plans: int


class Followed(NamedTuple):
    """What a follower remembers.

    Attributes:
        driver: Memory of the driver.
        trips: Where each rover is on its way.
        goal: Goals (n, 2) [m].
    """

    driver: Memory
    trips: tuple[_Trip, ...]
    goal: F64

    @property
    def plans(self) -> I64:
        """Routes that each rover made on the way (n,)."""
        return np.array([trip.plans for trip in self.trips], np.int64)


@final
class RouteFollower:
    """Lets any driver follow a route: its goal is a point that runs ahead along it.

    The driver goes round what is in its way, as ever. Where the map of what was sensed says that
    the route itself is blocked, or the rover was driven far off it, a new one is planned from where
    the rover thinks it is, over what was known at first and everything sensed since.

    Args:
        driver: Who drives; it sees a nearer goal, and its map is asked towards that one.
        routes: Points (k, 2) [m] for all rovers, or one such list for each number of a rover.
        ground: What was known at first: costs, inf where a rover's middle must not be. Without it
            everything that was not sensed blocked counts as free.
        ahead: How far ahead along the route the goal lies [m].
    """

    def __init__(
        self,
        driver: Controller,
        routes: Any,
        *,
        ground: CostMap | None = None,
        ahead: float = 4.0,
    ) -> None:
        if not (math.isfinite(ahead) and ahead > 0):
            raise SettingError(f"a route's goal must lie more than 0 m ahead, got {ahead!r}")
        several = isinstance(routes, Sequence) and np.ndim(routes[0]) == 2
        self.routes = tuple(_points(route) for route in (routes if several else [routes]))
        self.driver, self.ground, self.ahead = driver, ground, float(ahead)

    def start(self, mission: Mission, rng: np.random.Generator) -> Followed:
        """Every rover at the start of its route, which is led on to its goal."""
        if len(self.routes) > 1 and int(mission.number.max(initial=0)) >= len(self.routes):
            raise SettingError(
                f"{len(self.routes)} routes are for rovers 0 to {len(self.routes) - 1}; give one "
                "route for all, or one for each rover"
            )
        trips: list[_Trip] = []
        for number, goal in zip(mission.number.tolist(), mission.goal, strict=True):
            route = self.routes[number if len(self.routes) > 1 else 0]
            if math.dist(route[-1], goal) > 0.0:
                route = np.vstack([route, goal])
            trips.append(_Trip(route, 0.0, np.empty((0, 2), np.int64), 0, 0))
        return Followed(self.driver.start(mission, rng), tuple(trips), mission.goal)

    def act(self, observation: Observation, memory: Followed) -> tuple[Command, Followed]:
        """The driver's command towards the point ahead."""
        seen, trips = self._ahead(observation, memory)
        command, after = self.driver.act(seen, memory.driver)
        return command, Followed(after, trips, memory.goal)

    def why(self, observation: Observation, memory: Followed) -> Why:
        """Why the driver does it, with the goal that it is given."""
        seen, trips = self._ahead(observation, memory)
        told = explain(self.driver, seen, memory.driver)
        left = length_of(trips[0].route) - trips[0].along
        word = f"It follows a route of which {left:.1f} m are left; its goal is a point ahead."
        return replace(told, words=(word, *told.words))

    def _ahead(
        self, observation: Observation, memory: Followed
    ) -> tuple[Observation, tuple[_Trip, ...]]:
        """What the driver is shown, and the trips after this step."""
        pose, local = observation.pose, observation.map
        if pose is None:
            raise SettingError("a route needs a rover that knows where it is: Observation.pose")
        local = local if isinstance(local, LocalMap) else None
        trips, targets = list(memory.trips), np.empty((len(pose), 2))
        for k, trip in enumerate(memory.trips):
            trips[k] = self._on(trip, pose[k], local, k)
            targets[k] = self._target(trips[k], pose[k], local, k)
        goal = np.empty_like(targets)
        kernels.goal_in_body(np.ascontiguousarray(pose), targets, goal)
        seen = replace(observation, goal=goal)
        if local is not None:
            near = aimed(local, targets)
            channels = dict(observation.channels)
            if "around" in channels:
                channels["around"] = near.asked(channels["around"].shape[1])["around"]
            seen = replace(seen, map=near, channels=channels)
        return seen, tuple(trips)

    def _target(self, trip: _Trip, pose: F64, local: LocalMap | None, k: int) -> F64:
        """The farthest point of the route, up to `ahead`, with nothing known in between."""
        point = _at(trip.route, trip.along + self.ahead)
        for share in SHARES:
            if local is None or not _in_between(local, k, pose, point):
                break
            point = _at(trip.route, trip.along + share * self.ahead)
        return point

    def _on(self, trip: _Trip, pose: F64, local: LocalMap | None, k: int) -> _Trip:
        """The trip of rover k after this step: further along, or on a new route."""
        along, off = _progress(trip.route, trip.along, pose, 2.0 * self.ahead)
        trip = trip._replace(along=along, wait=max(0, trip.wait - 1))
        if local is None:
            return trip
        known = blocked_cells(local, k, trip.known)
        trip = trip._replace(known=known)
        ahead = _stretch(trip.route, along, along + local.cell * (local.cells.shape[1] // 2))
        if trip.wait or not (met(local, k, ahead, pose) or off > STRAYED * self.ahead):
            return trip
        sheet = Sheet.of(self.ground, trip.route, pose, local)
        route = any_angle(sheet.costs(known, local.cell, (pose[:2], trip.route[-1])),
                          sheet.inside(pose[:2]), sheet.inside(trip.route[-1]))  # fmt: skip
        if not route.found or len(route.points) < 2:
            return trip._replace(wait=PAUSE)
        points = sheet.outside(route.points)
        return _Trip(points, 0.0, known, PAUSE, trip.plans + 1)


ROOM = 0.4
"""Free on either side of the way to the goal ahead [m]: drivers stop before what is beside them."""
SHARES = (0.8, 0.6, 0.45, 0.3, 0.2)
"""How much nearer the goal comes where something is in between."""
STRAYED = 1.5
"""A rover farther off its route than this many times the way to its goal ahead plans anew."""
PAUSE = 5
"""Steps between two plans at least."""


def _in_between(local: LocalMap, k: int, pose: F64, point: F64) -> bool:
    """Whether something lies on the way to a point, or too near beside it."""
    way = point - pose[:2]
    aside = np.array([-way[1], way[0]]) * (ROOM / max(float(np.hypot(*way)), 1e-9))
    lines = (np.stack([pose[:2], point]) + shift * aside for shift in (0.0, 1.0, -1.0))
    return any(met(local, k, line, pose) for line in lines)


def length_of(route: F64) -> float:
    """Length of a route (k, 2) [m]."""
    return float(np.hypot(*np.diff(route, axis=0).T).sum())


def _points(route: Any) -> F64:
    points = np.array(route, np.float64)
    if points.ndim != 2 or points.shape[1:] != (2,) or not len(points):
        raise SettingError(f"a route needs points (k, 2), got shape {points.shape}")
    if not np.isfinite(points).all():
        raise SettingError("a point of a route is not finite")
    points.flags.writeable = False
    return points


def _distances(route: F64) -> F64:
    """How far along each point of a route lies [m]."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(route, axis=0).T))])


def _at(route: F64, along: float) -> F64:
    """The point so far along a route; its end beyond that."""
    far = _distances(route)
    return np.array([np.interp(along, far, route[:, axis]) for axis in range(2)])


def _stretch(route: F64, start: float, end: float) -> F64:
    """The points of a route between two distances along it."""
    far = _distances(route)
    inner = route[(far > start) & (far < end)]
    return np.vstack([_at(route, start), inner, _at(route, end)])


def _progress(route: F64, along: float, pose: F64, most: float) -> tuple[float, float]:
    """How far along its route a rover is, and how far off it [m]; never back, at most `most` on."""
    if len(route) < 2:
        return 0.0, math.dist(route[0], pose[:2])
    far = _distances(route)
    first = max(0, int(np.searchsorted(far, along, side="right")) - 1)
    last = min(len(route) - 1, int(np.searchsorted(far, along + most)))
    first = min(first, last - 1)
    a, d = route[first:last], np.diff(route[first : last + 1], axis=0)
    squared = np.maximum((d**2).sum(axis=1), 1e-300)
    share = np.clip(((pose[:2] - a) * d).sum(axis=1) / squared, 0.0, 1.0)
    at = far[first:last] + share * np.diff(far[first : last + 1])
    at = np.clip(at, along, min(along + most, far[-1]))
    near = np.array([math.dist(_at(route, one), pose[:2]) for one in at.tolist()])
    best = int(np.argmin(near))
    return float(at[best]), float(near[best])
