"""Commands held back from ground that a rover's own map forbids."""

from __future__ import annotations

import math
from typing import Any

from ._jit import kernel
from .elevation import LEDGE, STEEP, at_cell

PARTS = 8.0
"""Looks for each cell of way."""


@kernel()
def hold_back(
    pose: Any, cells: Any, reason: Any, centre: Any, c: float, period: float, radius: float,
    twist: Any,
) -> None:  # fmt: skip
    """Shorten each command to the part of its arc that stays on ground where the rover may be.

    The arc of v and w over a period T is followed in `PARTS` looks for each cell. From ground that
    is free it ends before the first blocked cell. A rover that stands on blocked ground may go on
    over it as long as it comes no nearer to a hazard than it is, and from free ground not back.
    The part that is left is commanded: v and w times its share, so that the rover stays on the
    same arc. Where nothing is left it turns on the spot.

    Args:
        pose: Where the rovers think they are (n, 3).
        cells: 1 where a rover's middle must not be (n, s, s).
        reason: Verdicts of `kernels.elevation` (n, s, s).
        centre: Cell of each rover (n, 2).
        c: Cell [m].
        period: T [s].
        radius: How far from blocked ground its hazard may lie [cells].
        twist: Commands (n, 3), changed.
    """
    for k in range(pose.shape[0]):
        v, w = twist[k, 0], twist[k, 2]
        way = abs(v) * period
        if not 0.0 < way < math.inf:
            continue
        parts = math.ceil(PARTS * way / c)
        inside = _blocked(cells, k, centre, pose[k, 0], pose[k, 1], c)
        least = _hazard(reason, k, centre, pose[k, 0], pose[k, 1], c, radius) if inside else 0.0
        good = 0
        for m in range(1, parts + 1):
            x, y = after(pose[k], v * (m / parts), w * (m / parts), period)
            if not _blocked(cells, k, centre, x, y, c):
                inside = False
            elif not inside or _hazard(reason, k, centre, x, y, c, radius) < least:
                break
            good = m
        share = good / parts
        if good == 0:
            twist[k, 0] = 0.0
        elif good < parts:
            twist[k, 0], twist[k, 2] = v * share, w * share


@kernel(inline=True)
def after(pose: Any, v: float, w: float, period: float) -> tuple[float, float]:
    """Where an arc ends, as `kernels.drive.differential` has it."""
    half = 0.5 * w * period
    chord = v * period * (math.sin(half) / half if half != 0.0 else 1.0)
    a = pose[2] + half
    return pose[0] + chord * math.cos(a), pose[1] + chord * math.sin(a)


@kernel()
def _blocked(cells: Any, k: int, centre: Any, x: float, y: float, c: float) -> bool:
    i, j = at_cell(x, y, k, centre, cells.shape[1], c)
    return i >= 0 and cells[k, i, j] != 0


@kernel()
def _hazard(reason: Any, k: int, centre: Any, x: float, y: float, c: float, radius: float) -> float:
    """Distance to the middle of the nearest hazard within a radius, squared [cells^2]."""
    reach = int(radius) + 1
    nearest = math.inf
    for di in range(-reach, reach + 1):
        for dj in range(-reach, reach + 1):
            i, j = at_cell(x + dj * c, y + di * c, k, centre, reason.shape[1], c)
            if i >= 0 and reason[k, i, j] in (STEEP, LEDGE):
                u = math.floor(x / c) + dj + 0.5 - x / c
                t = math.floor(y / c) + di + 0.5 - y / c
                nearest = min(nearest, u * u + t * t)
    return nearest
