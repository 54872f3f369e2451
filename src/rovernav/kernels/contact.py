"""What a rover with a body meets on its way: obstacles, and rocks that are too high for it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from . import footprint as fp
from . import settle as st
from . import wheels as wh
from ._jit import kernel
from .drive import WorldArrays
from .geometry import MISS


class BodyArrays(NamedTuple):
    """A rover: numbers of `wheels` (BODY,), chassis of `settle`, row of `traction` (1, COLUMNS)."""

    numbers: Any
    chassis: Any
    table: Any


class GroundArrays(NamedTuple):
    """Ground of each world or one for all, made ready for one rover; rocks that are too high.

    Attributes:
        wheel: Heights of wheel centres (g, h, w); (0, 0, 0) where the ground is level.
        gradient: East and north (g, 2, h, w).
        ground: Heights (g, h, w).
        step: Ledges (g, h, w).
        cell: [m].
        offset: What heights count from [m].
        rocks: x, y, radius, height (m, 4) [m].
        offsets: World i has the rocks offsets[i] to offsets[i + 1] (w + 1,).
    """

    wheel: Any
    gradient: Any
    ground: Any
    step: Any
    cell: float
    offset: float
    rocks: Any
    offsets: Any


@kernel(bare=True)
def _touches(
    a: Any,
    b: Any,
    e: float,
    of: int,
    body: BodyArrays,
    ground: GroundArrays,
    world: WorldArrays,
    hull: Any,
) -> bool:
    """Whether the body meets something on the straight way from pose a to b, grown by e."""
    n, chassis = body.numbers, body.chassis
    half = n[wh.HALF_WIDTH]
    whole = (n[wh.REAR], n[wh.FRONT], -half, half)
    m = fp.hull_of(a, b, whole, hull)
    if fp.meets_world(hull, m, of, world, n[wh.GRID] > 0.0, e):
        return True
    for k in range(ground.offsets[of], ground.offsets[of + 1]):
        x, y, r, high = ground.rocks[k, 0], ground.rocks[k, 1], ground.rocks[k, 2] + e, 0.0
        high = ground.rocks[k, 3]
        if not fp.meets_disc(hull, m, x, y, r):
            continue
        on_wheels, on_belly = high > chassis[st.MAX_STEP], high > n[wh.LIFT]
        if on_wheels and on_belly:
            return True
        met = False
        if on_wheels:
            for side in range(2):
                low, top = n[wh.STRIP_IN], n[wh.STRIP_OUT]
                strip = (
                    (n[wh.REAR], n[wh.FRONT], low, top)
                    if side == 0
                    else (n[wh.REAR], n[wh.FRONT], -top, -low)
                )
                met = met or fp.meets_disc(hull, fp.hull_of(a, b, strip, hull), x, y, r)
        elif on_belly:
            wide = chassis[st.BELLY_HALF]
            belly = (chassis[st.BELLY_REAR], chassis[st.BELLY_FRONT], -wide, wide)
            met = fp.meets_disc(hull, fp.hull_of(a, b, belly, hull), x, y, r)
        if met:
            return True
        m = fp.hull_of(a, b, whole, hull)
    return False


@kernel(inline=True, bare=True)
def first_touch(
    pose: Any,
    step: Any,
    of: int,
    body: BodyArrays,
    ground: GroundArrays,
    world: WorldArrays,
    hull: Any,
) -> float:
    """Share of a step (forward, left, turn) after which the body first meets something, or MISS."""
    n = body.numbers
    grid = n[wh.GRID] > 0.0 and world.blocked.size > 0
    boxes = world.offsets[of + 1] > world.offsets[of]
    rocks = ground.offsets[of + 1] > ground.offsets[of]
    if not (grid or boxes or rocks or world.shapes.size):
        return MISS
    long = max(abs(n[wh.REAR]), abs(n[wh.FRONT]))
    far = np.sqrt(long * long + n[wh.HALF_WIDTH] * n[wh.HALF_WIDTH])
    bulge, blur = fp.spread_of(step, far)
    t, share = 0.0, 1.0
    while t < 1.0:
        share = min(share, 1.0 - t)
        start, e = fp.along_arc(pose, step, t), bulge * share * share
        after = fp.along_arc(pose, step, t + share)
        if not _touches(start, after, e, of, body, ground, world, hull):
            t, share = t + share, 2.0 * share
        elif blur * share + 2.0 * e > n[wh.SLACK]:
            share = 0.5 * share
        else:
            free, met = t, t + share
            for _ in range(fp.ROUNDS):
                mid = 0.5 * (free + met)
                after = fp.along_arc(pose, step, mid)
                if _touches(start, after, e, of, body, ground, world, hull):
                    met = mid
                else:
                    free = mid
            return free
    return MISS
