# pyright: reportPrivateUsage=false
"""Beams that do not lie level, among obstacles that are as high as one likes.

Such an obstacle ends a beam where the beam's shadow on the map meets it. Grids are looked through
as in `rays`, with the same table and the same judge; the beams here differ in how long their
shadows are.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from . import ray_lanes as lanes
from ._jit import kernel
from .drive import WorldArrays, first_contact
from .ray_lanes import LANES
from .rays import (
    _LARGEST,
    _LONGEST,
    ConeArrays,
    _elsewhere,
    _Fan,
    _through_grid,
)
from .ridge_fan import Looks, end_of


@kernel()
def obstacle_fan(
    looks: Looks, reach: float, world: WorldArrays, cones: ConeArrays, share: Any
) -> None:
    """Share of `reach` from each eye along each beam to an obstacle, where that is nearer.

    Args:
        looks: Who looks where.
        reach: Longest distance along a beam [m].
        world: The true worlds.
        cones: Table of their grid; without one every beam takes the plain walk.
        share: What is met otherwise (n, b); lowered to what is met here.
    """
    if world.blocked.size + world.boxes.size + world.shapes.size == 0:
        return
    n, count = share.shape
    c, room = world.cell, -(-count // LANES) * LANES
    far = reach / c
    quick = cones.free.shape[0] > 0 and 1e-3 <= far <= _LONGEST
    bits = 29 - int(np.ceil(np.log2(far + 4.0))) if quick else 0
    fan = _Fan(
        np.empty((2, room)),
        np.zeros((lanes.STATE, room), np.int32),
        np.empty(room),
        np.empty(room, np.bool_),
    )
    fan.state[lanes.LAST] = -1  # lanes without a beam never start
    for k in range(n):
        x, y = looks.eye[k, 0], looks.eye[k, 1]
        for b in range(count):
            fan.ends[0, b], fan.ends[1, b], _ = end_of(looks, k, b, reach)
        if quick and abs(x) + abs(y) + abs(looks.axes[k, 0, 0]) < _LARGEST * c:
            layer = world.of[k] if cones.free.shape[0] > 1 else 0
            _through_grid(x / c, y / c, c, fan, bits, layer, (count, far), (world, cones.free))
            others = world.boxes.shape[0] + world.shapes.size > 0
            for b in range(count):
                t = fan.t[b]
                if others:
                    t = min(t, _elsewhere(k, x, y, fan.ends[0, b], fan.ends[1, b], world))
                share[k, b] = min(share[k, b], t)
        else:
            for b in range(count):
                t = first_contact(k, x, y, fan.ends[0, b], fan.ends[1, b], world)
                share[k, b] = min(share[k, b], t)
