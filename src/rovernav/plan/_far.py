"""Routes over rasters of any size: surveyed in blocks, then planned stretch by stretch."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..core import F64, InputError, SettingError, suggest
from ._any_angle import any_angle
from ._directed import stencil
from ._ends import Point, check_point, enclosed, judge_ends, judge_inside, nearest_free
from ._far_barriers import barriers_far
from ._going import OBJECTIVES, Going, against, going
from ._lines import WORTH, Guess, Walk
from ._lookout import Lookout, Progress, in_turn, silent
from ._profile import Profile, cut, nearest_on, why_here
from ._route import Route, Way, no_route
from ._stretch import MARGIN, NEAR, Errand, Failed, Look, Piece, at, lengths, stretch, window_over
from ._survey import Survey
from ._trip import MOST_VIA, ORDERS, Far, Trip, held_karp

STRETCH = 1024.0
"""Length of a stretch [cells]."""
ROUNDS = 24
"""Lines over blocks that are tried at most."""
PATIENCE = 3
"""Lines that may in turn lead to nothing better once a way is found."""
GAIN = 2e-3
"""Stretches are shifted and planned anew while that gains this share."""
STATIONS = 4000
"""Stations of the whole profile at most."""


def travel_far(
    errand: Errand,
    stops: Sequence[Any],
    *,
    order: str = "given",
    block: int | None = None,
    stretch: float = STRETCH,
    on_progress: Progress = silent,
) -> Trip:
    """As `travel`, over a raster that may be larger than memory.

    First the cells are judged where ways run that are not much longer than the straight line, and
    kept as blocks: what share of each is free, and over which borders one can pass. A shortest way
    over the blocks is found, and then the cheapest way at full resolution around it, stretch by
    stretch. Where blocks prove not to be passed, or longer than they looked, another line over
    blocks is tried while it promises a shorter way; and more is judged while a way through what
    was not could be shorter by more than 1 %. Last the stretches are shifted by half and planned
    again, so that where they met is no longer fixed.

    So the way is the cheapest around a shortest line over blocks: objectives other than distance
    count within the windows of the stretches only.

    Args:
        errand: The ground, the rover, what counts.
        stops: Local points (x, y) [m]: the start, stops on the way, the goal.
        order: "given", or "best" by the ways over blocks.
        block: Cells to a side of a block; as few as make 4 million blocks where not given.
        stretch: Length of a stretch [cells].
        on_progress: Called with the share that is done, and what is done.

    Returns:
        The trip; its `ground` is that of the blocks, its `far` that of the cells on the way.

    Raises:
        InputError: Fewer than two stops, or one that is not two finite numbers.
        SettingError: An unknown order, objective, soil or number of neighbours.
        FileError: The file is damaged.
    """
    points = [check_point(stop, f"stop {n + 1}") for n, stop in enumerate(stops)]
    _check(points, errand.objective, order, errand.neighbours)
    on_progress = _forward(on_progress)
    around = Lookout(errand.raster, errand.rover, zones=errand.zones, block=block)
    turn = _order(around, points) if order == "best" else tuple(range(len(points)))
    points = [points[n] for n in turn]
    legs: list[Route] = []
    pieces: list[list[Piece]] = []
    for n, ends in enumerate(itertools.pairwise(points)):
        tell = _between(on_progress, n / (len(points) - 1), (n + 1) / (len(points) - 1))
        route, parts = _leg(errand, around, ends, stretch, tell)
        legs.append(route)
        pieces.append(parts)
        if not route.found:
            break
    whole = [piece for leg in pieces for piece in leg]
    done = legs[-1].found
    barriers = () if done else barriers_far(
        errand, around, (points[len(legs) - 1], points[len(legs)]), stretch, on_progress
    )  # fmt: skip
    found = _seen(around, points)
    judged = found.judged(errand.rover, errand.soil)
    ground = going(judged, errand.rover, objective=errand.objective, soil=errand.soil)
    ground = dataclasses.replace(ground, zones=errand.zones)
    return Trip(
        ground=ground, stops=np.array(points), order=turn, legs=tuple(legs), barriers=barriers,
        far=Far(
            terrain=found.terrain, block=found.block, forbidden=1.0 - found.free,
            looked=found.looked,
            accounts=tuple(_summed(ground, parts) for parts in pieces if parts),
            stations=_stations(whole) if done else None, heights=_heights(whole) if done else None,
        ),
    )  # fmt: skip


def why_far(errand: Errand, points: Any, place: Any) -> dict[str, Any]:
    """As `why_here`, for a route of `travel_far`, in a window around the place.

    The straight alternative spans no more than a stretch on either side.

    Raises:
        InputError: No route, or no place.
    """
    points = np.asarray(points, np.float64)
    target = check_point(place, "place")
    if len(points) < 2:
        raise InputError("there is no way of two points or more to explain")
    along = lengths(points)
    here, _off = nearest_on(points, along, target)
    reach = 0.5 * STRETCH * errand.raster.frame.cell
    low, high = max(0.0, here - reach), min(float(along[-1]), here + reach)
    piece = cut(points, along, low, high)
    window = window_over(errand, piece, MARGIN)
    assert window is not None
    look = Look(errand, window, effort=True)
    assert look.ground is not None
    told = why_here(look.ground, piece - look.corner, np.array(target) - look.corner)
    told["at"] = tuple(map(float, np.array(told["at"]) + look.corner))
    return {**told, "distance": told["distance"] + low}


def _forward(on_progress: Progress) -> Progress:
    """Progress that never goes back, where work turns out to be more than it seemed."""
    most = [0.0]

    def tell(done: float, words: str) -> None:
        most[0] = max(most[0], done)
        on_progress(most[0], words)

    return tell


def _between(tell: Progress, low: float, high: float) -> Progress:
    """Progress of a part as that of the whole."""
    return lambda done, words: tell(low + (high - low) * done, words)


def _check(points: list[Point], objective: str, order: str, neighbours: int) -> None:
    if len(points) < 2:
        raise InputError(f"a trip needs a start and a goal, got {len(points)} stops")
    for name, chosen, known in (("order", order, ORDERS), ("objective", objective, OBJECTIVES)):
        if chosen not in known:
            raise SettingError(f"unknown {name} {chosen!r}; {suggest(chosen, known)}")
    stencil(neighbours)
    if order == "best" and len(points) - 2 > MOST_VIA:
        raise SettingError(
            f"the best order is found for at most {MOST_VIA} stops between start and goal, got "
            f"{len(points) - 2}; leave out --order best, or split the trip"
        )


def _seen(around: Lookout, points: list[Point]) -> Survey:
    """What was looked at, and something in any case: the whole raster at last."""
    width, height = around.found.whole.extent
    ends = [(min(max(x, 0.0), width), min(max(y, 0.0), height)) for x, y in points[:2]]
    for reach in (1.0, math.inf):
        if not np.isfinite(around.found.heights).any():
            around.widen((ends[0], ends[1]), reach)
    return around.found


def _order(around: Lookout, points: list[Point]) -> tuple[int, ...]:
    """The order of stops whose ways over blocks are shortest."""
    n, frame = len(points), around.found.whole
    matrix = np.zeros((n, n))
    for a in range(n):
        for b in range(a):
            inside = frame.contains(*points[a]) and frame.contains(*points[b])
            cost = np.inf
            if points[a] == points[b]:
                cost = 0.0
            elif inside:
                line = Guess(around, (points[a], points[b])).line()
                cost = np.inf if line is None else line.cost
            matrix[a, b] = matrix[b, a] = cost
    return held_karp(matrix)


def _leg(
    errand: Errand, around: Lookout, ends: tuple[Point, Point], step: float, tell: Progress
) -> tuple[Route, list[Piece]]:
    """The way from one stop to the next, and its pieces."""
    refused = _refused(errand, ends)
    if refused is not None:
        return refused, []
    if ends[0] == ends[1]:
        window = window_over(errand, np.array([ends[0]]), MARGIN)
        assert window is not None
        look = Look(errand, window)
        one = look.piece(np.array([ends[0]]) - look.corner)
        return Route(points=one.points, cost=0.0, length=0.0), [one]
    guess, best, tries = Guess(around, ends, _between(tell, 0.0, 0.4)), None, 0
    for _ in range(ROUNDS):
        line = guess.line()
        if line is None or tries > PATIENCE:
            break
        if best is not None and line.cost >= (1.0 - WORTH) * best.length:
            if guess.widen(best.length):
                continue
            break
        tries += best is not None
        try:
            walk = _walk(errand, line.points, (step, NEAR * guess.found.side), tell)
        except Failed as failed:
            guess.failed(failed.window)
            continue
        guess.learn(line, walk)
        if best is None or walk.length < best.length:
            best = walk
            tries = 0
    if best is None:
        return _none(guess), []
    pieces = _settled(errand, best.ways, tell)
    return _route(pieces), pieces


def _settled(errand: Errand, ways: list[F64], tell: Progress) -> list[Piece]:
    """The same way, planned anew over shifted stretches for as long as that pays."""
    while True:
        pieces, before = _shifted(errand, ways, tell)
        cost = sum(piece.account["cost"] for piece in pieces)
        if len(ways) == 1 or cost >= (1.0 - GAIN) * before:
            return pieces
        ways = [piece.points for piece in pieces]


def _refused(errand: Errand, ends: tuple[Point, Point]) -> Route | None:
    """Why no way begins or ends there, told by the cells around; None where both are fine."""
    off = judge_inside(errand.raster.frame, *ends)
    if off is not None:
        return off
    for end, what, way in zip(
        ends, ("start", "goal"), (Way.START_FORBIDDEN, Way.GOAL_FORBIDDEN), strict=True
    ):
        window = window_over(errand, np.array([end]), MARGIN)
        assert window is not None
        look = Look(errand, window)
        if look.ground is None:
            return no_route(way, f"the {what} ({end[0]:.6g}, {end[1]:.6g}) m lies in a hole of the "
                            "map without data")  # fmt: skip
        here = at(np.array(end) - look.corner)
        answer = judge_ends(look.ground.open_ground(), here, here)
        if answer is not None:
            return _moved(answer, look, end, what, way)
    return None


def _moved(answer: Route, look: Look, end: Point, what: str, way: Way) -> Route:
    """An answer about one end in a window, in the raster's own metres."""
    assert look.ground is not None
    near = nearest_free(look.ground.open_ground(), *at(np.array(end) - look.corner))
    free = None if near is None else at(np.array(near) + look.corner)
    words = "" if free is None else (
        f"; the nearest free ground is at ({free[0]:.6g}, {free[1]:.6g}) m, "
        f"{math.dist(free, end):.3g} m away"
    )  # fmt: skip
    words += against(look.ground, at(np.array(end) - look.corner))
    return no_route(
        way, f"the {what} ({end[0]:.6g}, {end[1]:.6g}) m touches forbidden ground{words}",
        free if what == "goal" else None,
    )  # fmt: skip


def _walk(errand: Errand, line: F64, step: tuple[float, float], tell: Progress) -> Walk:
    """The cheapest ways around the stretches of a line (k, 2) [m], from its beginning to its end.

    `step` is the length of a stretch [cells], and how far from its end it may end [m].

    Raises:
        Failed: One of them cannot be passed.
    """
    along = lengths(line)
    total = float(along[-1])
    count = max(1, round(total / (step[0] * errand.raster.frame.cell)))
    cuts = np.linspace(0.0, total, count + 1)
    parts = [cut(line, along, *ends) for ends in itertools.pairwise(cuts)]
    ways: list[F64] = []
    first = line[0]
    for n, (part, look) in enumerate(in_turn(lambda part: (part, _look(errand, part)), parts)):
        aim = np.vstack([first, part[1:]])
        off = 0.0 if n == count - 1 else step[1]
        path, seen = stretch(errand, aim, off=off, ready=look)
        ways.append(path + seen.corner)
        first = ways[-1][-1]
        tell(0.4 + 0.3 * (n + 1) / count, "planning the stretches")
    return Walk(parts, ways)


def _look(errand: Errand, part: F64) -> Look | None:
    """The window around a stretch, judged before it is known where its way begins."""
    window = window_over(errand, part, MARGIN)
    return None if window is None else Look(errand, window)


def _shifted(errand: Errand, ways: list[F64], tell: Progress) -> tuple[list[Piece], float]:
    """The same way planned anew from the middle of each stretch to the middle of the next.

    And what it cost before.
    """
    parts: list[list[F64]] = [[]]
    for way in ways:
        along = lengths(way)
        middle = 0.5 * float(along[-1]) if len(ways) > 1 else float(along[-1])
        parts[-1].append(cut(way, along, 0.0, middle))
        if len(ways) > 1:
            parts.append([cut(way, along, middle, float(along[-1]))])

    def again(part: list[F64]) -> tuple[Piece, float]:
        line = np.vstack(part)
        path, look = stretch(errand, line, driven=True)
        assert look.ground is not None
        return look.piece(path), look.ground.cost_of(line - look.corner)

    pieces, before = list[Piece](), 0.0
    for n, (piece, cost) in enumerate(in_turn(again, parts)):
        pieces.append(piece)
        before += cost
        tell(0.7 + 0.3 * (n + 1) / len(parts), "planning across their ends")
    return pieces, before


def _route(pieces: list[Piece]) -> Route:
    points = np.vstack([pieces[0].points, *(piece.points[1:] for piece in pieces[1:])])
    cost = sum(piece.account["cost"] for piece in pieces)
    return Route(points=points, cost=cost, length=float(lengths(points)[-1]))


def _none(guess: Guess) -> Route:
    """Why there is no way, by blocks."""
    found, ends, middles = guess.found, guess.ends, guess.middles
    costs = found.costs(joined=False)
    limits = (
        f"; no way was found along {guess.narrowed} lines over blocks of {found.side:g} m, but "
        "narrower passages may be left"
    )
    if any_angle(costs, *middles).found:
        return no_route(Way.GOAL_ENCLOSED, limits[2:])
    answer = enclosed(costs, *middles)
    assert answer.nearest is not None
    near = answer.nearest[0] + found.corner, answer.nearest[1] + found.corner
    what = "start" if answer.way is Way.START_ENCLOSED else "goal"
    x, y = ends[0] if what == "start" else ends[1]
    return no_route(
        answer.way,
        f"forbidden ground encloses the {what} ({x:.6g}, {y:.6g}) m; the nearest point to the goal "
        f"that can be reached is about ({near[0]:.6g}, {near[1]:.6g}) m, "
        f"{math.dist(near, ends[1]):.3g} m from it, to a block of {found.side:g} m"
        f"{limits if guess.narrowed else ''}",
        near,
    )


def _stations(pieces: list[Piece]) -> Profile:
    """The profiles of pieces as one, thinned out."""
    names = [field.name for field in dataclasses.fields(Profile)]
    joined = {name: [np.asarray(getattr(p.stations, name)) for p in pieces] for name in names}
    before = np.cumsum([0.0, *(p.account["length"] for p in pieces[:-1])])
    joined["distance"] = [d + b for d, b in zip(joined["distance"], before, strict=True)]
    every = {name: np.concatenate(parts) for name, parts in joined.items()}
    count = len(every["distance"])
    kept = np.unique(np.linspace(0, count - 1, min(count, STATIONS)).astype(int))
    return Profile(**{name: values[kept] for name, values in every.items()})


def _heights(pieces: list[Piece]) -> F64:
    """Elevation of the points of a trip [m]."""
    return np.concatenate([pieces[0].heights, *(piece.heights[1:] for piece in pieces[1:])])


def _summed(ground: Going, pieces: list[Piece]) -> dict[str, Any]:
    told = [piece.account for piece in pieces]
    out: dict[str, Any] = {key: sum(one[key] for one in told) for key in ("length", "cost", "time")}
    out["terms"] = {name: sum(one["terms"][name] for one in told) for name in ground.terms}
    out["energy"] = None if ground.table is None else sum(one["energy"] for one in told)
    out["steepest"] = max(one["steepest"] for one in told)
    return out
