"""A trip over several stops: its legs, their order, what each costs and why."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..core import F64, InputError, SettingError, suggest, value
from ..terrain import Terrain
from ._barriers import Barrier, barriers
from ._directed import USUAL, Search, directed
from ._ends import Point, check_point, is_free
from ._going import Going
from ._profile import Profile, account_of, profile
from ._route import Route

ORDERS = ("given", "best")
MOST_VIA = 12
"""Stops between start and goal for which the best order is found exactly: at 12 the table of Held
and Karp has 49,152 entries; each more doubles it."""


@value
class Far:
    """What a trip over a raster is like at full resolution.

    Attributes:
        terrain: Mean heights of the blocks, for pictures.
        block: Cells to a side of a block.
        forbidden: Share of what was looked at that is forbidden, 0 to 1.
        looked: Share of the raster that was looked at, 0 to 1.
        accounts: For each leg that was found, as `Trip.account`.
        stations: The profile of the whole trip; None without a way.
        heights: Elevation of the trip's points (k,) [m]; None without a way.
    """

    terrain: Terrain
    block: int
    forbidden: float
    looked: float
    accounts: tuple[dict[str, Any], ...]
    stations: Profile | None = None
    heights: F64 | None = None


@value
class Trip:
    """Ways from stop to stop.

    Attributes:
        ground: What going costs.
        stops: Local points (n, 2) [m], in the order of the trip.
        order: For each stop its place in the order that was given.
        legs: A route for each pair of stops, up to the first for which there is none.
        barriers: What keeps the first leg without a way from having one.
        far: What was seen at full resolution, where `ground` is that of blocks; or None.
    """

    ground: Going
    stops: F64
    order: tuple[int, ...]
    legs: tuple[Route, ...]
    barriers: tuple[Barrier, ...] = ()
    far: Far | None = None

    @property
    def found(self) -> bool:
        """Whether all stops can be reached."""
        return all(leg.found for leg in self.legs)

    @property
    def status(self) -> str:
        """``found`` or ``unreachable``."""
        return "found" if self.found else "unreachable"

    @property
    def failed(self) -> int | None:
        """Number of the leg for which there is no way, from 0; None where all have one."""
        return None if self.found else len(self.legs) - 1

    @property
    def reason(self) -> str:
        """Why there is no way, and what would open one; empty where there is one."""
        if self.found:
            return ""
        leg = "" if len(self.stops) == 2 else f"leg {len(self.legs)}: "
        return "; ".join([leg + self.legs[-1].reason, *(b.words for b in self.barriers)])

    @property
    def nearest(self) -> Point | None:
        """What can be reached nearest to the stop that cannot be [m]."""
        return None if self.found else self.legs[-1].nearest

    @property
    def points(self) -> F64:
        """The whole way (k, 2) [m]; empty where some stop cannot be reached."""
        if not self.found:
            return np.empty((0, 2))
        rest = [leg.points[1:] for leg in self.legs[1:]]
        return np.vstack([self.legs[0].points, *rest])

    @property
    def length(self) -> float:
        """[m] on the map; inf without a way."""
        return sum(leg.length for leg in self.legs)

    @property
    def cost(self) -> float:
        """In the objective's unit; inf without a way."""
        return sum(leg.cost for leg in self.legs)

    @property
    def route(self) -> Route:
        """The whole trip as one route, or the leg for which there is no way."""
        if not self.found:
            return self.legs[-1]
        return Route(points=self.points, cost=self.cost, length=self.length)

    def account(self) -> list[dict[str, Any]]:
        """For each leg that was found: length, cost, its terms, time, energy, steepest ground."""
        if self.far is not None:
            return list(self.far.accounts)
        return [account_of(self.ground, leg.points) for leg in self.legs if leg.found]

    def profile(self, terrain: Terrain) -> Profile:
        """The whole trip from close by; `terrain` is the ground that was planned on.

        Raises:
            InputError: There is no way.
        """
        if self.far is not None and self.far.stations is not None:
            return self.far.stations
        return profile(self.ground, self.points, terrain)

    @property
    def heights(self) -> F64 | None:
        """Elevation of the points (k,) [m], where it is not that of the ground planned on."""
        return None if self.far is None else self.far.heights

    @property
    def forbidden(self) -> float:
        """Share of the map that is forbidden, of what was looked at of it, 0 to 1."""
        return float(self.ground.blocked.mean()) if self.far is None else self.far.forbidden

    @property
    def looked(self) -> float:
        """Share of the map that was looked at, 0 to 1: where shorter ways may run."""
        return 1.0 if self.far is None else self.far.looked


def travel(
    ground: Going,
    stops: Sequence[Any],
    *,
    order: str = "given",
    neighbours: int = USUAL,
) -> Trip:
    """The cheapest ways from stop to stop.

    Args:
        ground: What going costs, and what is counted.
        stops: Local points (x, y) [m]: the start, stops on the way, the goal.
        order: "given", or "best": stops between the first and the last in the order that costs
            least (Held and Karp 1962): exact for the lengths of shortest ways where distance
            counts, otherwise for the costs on the graph.
        neighbours: Cells that a move of the graph may lead to: 8, 16 or 32.

    Returns:
        The trip, or how far it comes and why not farther.

    Raises:
        InputError: Fewer than two stops, or one that is not two finite numbers.
        SettingError: An unknown order, or more than 12 stops between the ends to put in order.
    """
    points = [check_point(stop, f"stop {n + 1}") for n, stop in enumerate(stops)]
    if len(points) < 2:
        raise InputError(f"a trip needs a start and a goal, got {len(points)} stops")
    if order not in ORDERS:
        raise SettingError(f"unknown order {order!r}; {suggest(order, ORDERS)}")
    turn = tuple(range(len(points)))
    if order == "best" and len(points) > 3:
        turn = best_order(ground, points, neighbours=neighbours)
    points = [points[n] for n in turn]
    legs: list[Route] = []
    for a, b in itertools.pairwise(points):
        legs.append(directed(ground, a, b, neighbours=neighbours))
        if not legs[-1].found:
            against = barriers(ground, a, b)
            return Trip(
                ground=ground, stops=np.array(points), order=turn, legs=tuple(legs),
                barriers=against,
            )  # fmt: skip
    return Trip(ground=ground, stops=np.array(points), order=turn, legs=tuple(legs))


def cost_matrix(ground: Going, points: Sequence[Point], *, neighbours: int = USUAL) -> F64:
    """What it costs on the graph from each point to each other (n, n) [unit]; one search each.

    Not symmetric: uphill is dearer than downhill. inf where there is no way.
    """
    costs, n = ground.open_ground(), len(points)
    good = [ground.frame.contains(*p) and is_free(costs, *p) for p in points]
    matrix = np.full((n, n), np.inf)
    np.fill_diagonal(matrix, 0.0)
    for a in range(n):
        if good[a]:
            search = Search(ground, points[a], neighbours=neighbours)
            search.run()
            for b in range(n):
                if b != a and good[b]:
                    matrix[a, b] = search.to(points[b])
    return matrix


def best_order(
    ground: Going, points: Sequence[Point], *, neighbours: int = USUAL
) -> tuple[int, ...]:
    """The order of stops, the first and the last kept, whose costs on the graph are least.

    Where no order reaches all stops, the order given.

    Raises:
        SettingError: More than 12 stops between the ends.
    """
    via = len(points) - 2
    if via > MOST_VIA:
        raise SettingError(
            f"the best order is found for at most {MOST_VIA} stops between start and goal, got "
            f"{via}; leave out --order best, or split the trip"
        )
    if ground.objective == "distance":
        return held_karp(_lengths(ground, points, neighbours))
    return held_karp(cost_matrix(ground, points, neighbours=neighbours))


def _lengths(ground: Going, points: Sequence[Point], neighbours: int) -> F64:
    """As `cost_matrix`, of shortest ways themselves: pairs are quicker than the whole map."""
    matrix = np.zeros((len(points), len(points)))
    for a, b in itertools.combinations(range(len(points)), 2):
        there = directed(ground, points[a], points[b], neighbours=neighbours).cost
        back = there
        if ground.table is not None:  # limits by direction
            back = directed(ground, points[b], points[a], neighbours=neighbours).cost
        matrix[a, b], matrix[b, a] = there, back
    return matrix


def held_karp(matrix: F64) -> tuple[int, ...]:
    """The cheapest way through all points of a cost matrix, from the first to the last one.

    Exact, by dynamic programming over subsets: M. Held and R. M. Karp, A dynamic programming
    approach to sequencing problems, J. SIAM 10 (1962). Of equal ones the first in order.

    Args:
        matrix: What it costs from row to column (n, n); inf where there is no way.
    """
    n = len(matrix)
    via = n - 2
    if via < 1:
        return tuple(range(n))
    best = np.full((1 << via, via), np.inf)
    came = np.full((1 << via, via), -1, np.int64)
    best[1 << np.arange(via), np.arange(via)] = matrix[0, 1:-1]
    for subset in range(1, 1 << via):
        for last in range(via):
            here = best[subset, last]
            if not (subset >> last & 1 and here < np.inf):
                continue
            for following in range(via):
                if not subset >> following & 1:
                    grown = subset | 1 << following
                    cost = here + matrix[last + 1, following + 1]
                    if cost < best[grown, following]:
                        best[grown, following], came[grown, following] = cost, last
    whole = best[-1] + matrix[1:-1, -1]
    if not whole.min() < np.inf:
        return tuple(range(n))
    subset, last, back = (1 << via) - 1, int(whole.argmin()), [n - 1]
    while last >= 0:
        back.append(last + 1)
        subset, last = subset ^ (1 << last), int(came[subset, last])
    return (0, *reversed(back))
