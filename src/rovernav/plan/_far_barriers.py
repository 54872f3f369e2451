"""What stands in a far way: which limit, by how much, and where along one line."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Sequence
from typing import Any, cast

import numpy as np

from ..core import F64
from ._any_angle import any_angle
from ._barriers import Barrier, barriers, place_words, unit_words
from ._ends import Point
from ._lines import FIRST
from ._lookout import Lookout, Progress, in_turn, silent
from ._profile import cut
from ._stretch import MARGIN, NEAR, Errand, Look, at, lengths, window_over
from ._survey import Survey

MOST = 12
"""Closed places along a line at most; where there are more, no limit is named."""
WIDE = 400
"""A piece of free ground that a line may end in has so many cells, where there is one."""
LINE = "along the line with the least forbidden ground that blocks of cells show"


def barriers_far(
    errand: Errand,
    around: Lookout,
    ends: tuple[Point, Point],
    step: float,
    on_progress: Progress = silent,
) -> tuple[Barrier, ...]:
    """Each limit that, raised so far, opens a way along one line; the least raised first.

    The line is that with the least forbidden ground over the blocks that were looked at. Along it,
    stretch by stretch, `barriers` tells at full resolution what would have to give. So a limit
    raised as far as is told does open a way, as far as limits do not depend on the direction; along
    another line a smaller rise may do.

    Args:
        errand: What is planned.
        around: What was judged.
        ends: Local points [m] on the map.
        step: Length of a stretch [cells].
        on_progress: Called with the share that is done, and what is done.
    """
    if not all(errand.raster.frame.contains(*end) for end in ends):
        return ()
    around.widen(ends, 1.0 + FIRST)
    line = _line(around.found, ends)
    along = lengths(line)
    count = max(1, round(float(along[-1]) / (step * errand.raster.frame.cell)))
    edges = itertools.pairwise(np.linspace(0.0, float(along[-1]), count + 1))
    parts = [cut(line, along, *edge) for edge in edges]
    first, closed = np.array(ends[0]), list[tuple[Barrier, ...]]()
    for n, (part, look) in enumerate(in_turn(lambda p: (p, _look(errand, p)), parts)):
        if look is not None and not look.holds(first):  # the last free ground lies farther back
            look = _look(errand, np.vstack([first, part]))
        if look is None or look.ground is None:
            return ()
        off = 0.0 if n == count - 1 else NEAR * around.found.side
        opens, first = _passed(look, first, part[-1], off)
        if opens is not None:
            closed.append(opens)
        if len(closed) > MOST or opens == ():
            return ()
        on_progress((n + 1) / count, "looking for what stands in the way")
    return _common(closed, errand.rover.name)


def _line(found: Survey, ends: tuple[Point, Point]) -> F64:
    """The way with the least forbidden ground over blocks (k, 2) [m], whatever is closed."""
    middles = found.middle(*ends[0]), found.middle(*ends[1])
    route = any_angle(found.forced(), *middles)
    return np.vstack([ends[0], route.points + found.corner, ends[1]])


def _look(errand: Errand, part: F64) -> Look | None:
    window = window_over(errand, part, MARGIN)
    return None if window is None else Look(errand, window)


def _passed(
    look: Look, first: F64, target: F64, off: float
) -> tuple[tuple[Barrier, ...] | None, F64]:
    """What would open a stretch, or None where it is open; and where the next one begins.

    It ends at most `off` beside its target [m] where free ground is there.
    """
    assert look.ground is not None
    goal = look.near(first, target, off) if off > 0.0 else target
    goal = _exit(look, target) if goal is None else goal
    if goal is None:
        return (), first
    if look.way(first, goal) is not None:
        return None, goal
    found = barriers(look.ground, at(first - look.corner), at(goal - look.corner))
    return tuple(_moved(one, look.corner) for one in found), goal


def _exit(look: Look, target: F64) -> F64 | None:
    """The nearest place to a target in a piece of free ground of some size; None without any."""
    from scipy import ndimage

    assert look.ground is not None
    regions, _count = cast(Any, ndimage).label(look.ground.blocked == 0)
    sizes = np.bincount(regions.ravel())
    sizes[0] = 0
    cells = np.argwhere((sizes >= max(1, min(WIDE, int(sizes.max()))))[regions])
    if not len(cells):
        return None
    middles = (cells[:, ::-1] + 0.5) * look.ground.frame.cell + look.corner
    return middles[int(((middles - target) ** 2).sum(axis=1).argmin())]


def _moved(barrier: Barrier, corner: F64) -> Barrier:
    where = None if barrier.at is None else at(np.array(barrier.at) + corner)
    return dataclasses.replace(barrier, at=where)


def _common(closed: Sequence[tuple[Barrier, ...]], rover: str) -> tuple[Barrier, ...]:
    """What opens all closed places: limits that all of them share, or one of each together."""
    if not closed:
        return ()
    shared = set.intersection(*({one.limit for one in opens} for opens in closed))
    if not shared:
        return (_together([opens[0] for opens in closed], rover),)
    found: list[Barrier] = []
    for limit in shared:
        same = [one for opens in closed for one in opens if one.limit == limit]
        hardest = min(same, key=_ease) if limit == "margin" else max(same, key=_ease)
        found.append(dataclasses.replace(hardest, words=f"{LINE}, {_words(hardest, rover)}"))
    return tuple(sorted(found, key=lambda one: (_rise(one), one.limit)))


def _together(each: Sequence[Barrier], rover: str) -> Barrier:
    """Different limits in different places."""
    names = list(dict.fromkeys(one.limit for one in each))
    hardest = [max((one for one in each if one.limit == name), key=_ease) for name in names]
    told = ", and ".join(_words(one, rover) for one in hardest)
    return Barrier(
        limit=" and ".join(names), now=0.0, needed=math.nan, unit="", at=hardest[0].at,
        words=f"{LINE}, no single limit opens a way: {told}",
    )  # fmt: skip


def _ease(barrier: Barrier) -> float:
    return 0.0 if math.isnan(barrier.needed) else barrier.needed


def _rise(barrier: Barrier) -> float:
    return barrier.needed / barrier.now if barrier.now > 0.0 else math.inf


def _words(barrier: Barrier, rover: str) -> str:
    """What would have to give, with units for people."""
    limit, unit = barrier.limit, barrier.unit
    where = "" if barrier.at is None else f", hardest at {place_words(barrier.at)}"
    if limit == "no data":
        return f"a way opens if ground without data can be driven{where}"
    if limit == "zone":
        return f"a way opens if the zones are lifted{where}"
    now, needed = unit_words(barrier.now, unit), unit_words(barrier.needed, unit)
    if limit == "margin":
        return f"a way opens if the margin around zones falls from {now} to {needed}"
    if limit == "slope and step":
        return f"slope and step limits {barrier.needed:.4g} times as high open a way{where}"
    return f"a way opens if the {limit} limit of {rover} rises from {now} to {needed}{where}"
