"""Fans of beams over heights: high above the ground by a table, what may be met is judged.

A beam marches through a table that tells how high the ground is at most in the next columns
(`ridge_tops`), in numbers with a margin for their rounding, so that it never passes ground which it
could touch. The first column in which the ground may be as high goes to `ridges.column`, the judge
of the plain walk; where nothing is met there the beam marches on. The walk meets nothing in columns
whose ground is lower than the line, so each beam has the bits of the plain walk, `ridges.walk`.

Symbols: u place along a beam's main axis, v across it [posts]; s rows per column; t in [0, 1].
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from . import ridge_lanes as lanes
from . import ridge_lines as lines
from ._jit import kernel
from .geometry import MISS
from .patches import under
from .ridge_lanes import LANES, march
from .ridge_lines import judge, set_out
from .ridge_tops import TopArrays, blocks_of
from .ridges import GroundArrays, walk
from .vectors import WIDE

_ROOM = 1024
"""Beams that march together: many, so that lanes are full until few are left, yet in the caches."""
_TILE = 32
"""Side of a tile of ground [posts] whose eyes look one after the other."""
_LONGEST = 1000.0
"""Reach [posts] that the lanes' numbers are enough for."""


class _Pool(NamedTuple):
    """Beams that march together.

    Attributes:
        ways: Cosines and sines of the beams' angles, with unused ones to full vectors (2, b).
        given: What the beams of one eye have in common (lines.COMMON,).
        plan: What all beams have in common (lanes.COMMON,), int64.
        line: The line of each beam (r, lines.LINE).
        t: Where it meets the ground (1, r): MISS, or NaN where the plain walk must tell.
        state: Rows of `ridge_lanes` (STATE, r), int32: of those that still go on, in front.
        height: Its rows of heights (HEIGHTS, r), float32.
        stops: Beams whose ground is to be judged, and columns they have gone (2, r), int32.
        at: As long as all rows (r,).
    """

    ways: Any
    given: Any
    plan: Any
    line: Any
    t: Any
    state: Any
    height: Any
    stops: Any
    at: Any


class Looks(NamedTuple):
    """Who looks where.

    Attributes:
        eye: Where the eyes are (n, 3): x, y, z [m].
        axes: Unit vectors forward and left of each (n, 2, 3).
        ways: Cosines and sines of the beams' angles, from forward to left (2, b).
        of: World of each (n,).
    """

    eye: Any
    axes: Any
    ways: Any
    of: Any


@kernel(inline=True)
def end_of(looks: Looks, k: int, b: int, reach: float) -> tuple[float, float, float]:
    """Where beam b of eye k ends if it meets nothing."""
    p, q, axes = looks.ways[0, b], looks.ways[1, b], looks.axes
    return (
        looks.eye[k, 0] + reach * (p * axes[k, 0, 0] + q * axes[k, 1, 0]),
        looks.eye[k, 1] + reach * (p * axes[k, 0, 1] + q * axes[k, 1, 1]),
        looks.eye[k, 2] + reach * (p * axes[k, 0, 2] + q * axes[k, 1, 2]),
    )


@kernel()
def ground_fan(looks: Looks, reach: float, ground: GroundArrays, top: TopArrays, out: Any) -> None:
    """Share of `reach` from each eye along each beam to the ground, or MISS.

    Args:
        looks: Who looks where.
        reach: Longest distance along a beam [m].
        ground: The heights; the ground is level at 0 where there are none.
        top: Their table; without one every beam takes the plain walk.
        out: Shares (n, b) in [0, 1], MISS where no ground is met.
    """
    shape = (ground.heights.shape[1], ground.heights.shape[2])
    n, count = out.shape
    if top.coarse.shape[0] == 0 or shape[0] == 0 or not reach / ground.cell <= _LONGEST:
        for k in range(n):
            for b in range(count):
                out[k, b] = _plain(looks, k, b, reach, ground)
        return
    pool = _pool(looks.ways, reach, shape, ground.cell)
    wide = pool.ways.shape[1]
    each = pool.at.size // wide
    order, at = _order(looks, ground), 0
    while at < n:
        first, layer = at, _layer(looks, order[at], ground)
        while at < n and at < first + each and _layer(looks, order[at], ground) == layer:
            scale = (top.low[layer], top.grain[layer])
            _set_out(looks, order[at], (at - first) * wide, scale, pool)
            at += 1
        _march_all(pool, (at - first) * wide, layer, ground, top)
        for m in range(first, at):
            k = order[m]
            for b in range(count):
                t = pool.t[0, (m - first) * wide + b]
                out[k, b] = t if t == t else _plain(looks, k, b, reach, ground)


@kernel()
def _order(looks: Looks, ground: GroundArrays) -> Any:
    """Eyes by world and by tile of the ground: neighbours read the same part of the tables."""
    n, (g, h, w) = looks.eye.shape[0], ground.heights.shape
    side = _TILE
    while g * (h // side + 1) * (w // side + 1) > 4 * n + 1024:
        side *= 2
    rows, columns, c = h // side + 1, w // side + 1, side * ground.cell
    place, count = np.empty(n, np.int64), np.zeros(g * rows * columns + 1, np.int64)
    for k in range(n):
        i = int(min(rows - 1.0, max(0.0, looks.eye[k, 1] / c)))  # 0 for NaN
        j = int(min(columns - 1.0, max(0.0, looks.eye[k, 0] / c)))
        there = (_layer(looks, k, ground) * rows + i) * columns + (columns - 1 - j if i & 1 else j)
        place[k] = there
        count[there + 1] += 1
    for m in range(count.size - 1):
        count[m + 1] += count[m]
    order = np.empty(n, np.int64)
    for k in range(n):
        order[count[place[k]]] = k
        count[place[k]] += 1
    return order


@kernel()
def _pool(ways: Any, reach: float, shape: Any, c: float) -> _Pool:
    """Room for the beams of some eyes, and what they all have in common."""
    h, w = shape
    wide, far = -(-ways.shape[1] // WIDE) * WIDE, reach / c
    room = -(-max(1, _ROOM // wide) * wide // LANES) * LANES
    padded = np.zeros((2, wide))
    padded[:, : ways.shape[1]] = ways
    given, plan = np.zeros(lines.COMMON), np.zeros(lanes.COMMON, np.int64)
    bits = 29 - int(np.ceil(np.log2(far + 4.0)))
    given[lines.REACH], given[lines.CELL], given[lines.FAR] = reach, c, far
    given[lines.WIDTH], given[lines.HEIGHT], given[lines.ONE] = w, h, float(1 << bits)
    given[lines.MARGIN] = (far + 16.0) / given[lines.ONE]  # more than so many columns' roundings
    rows, columns = blocks_of(h, w)
    plan[lanes.ACROSS], plan[lanes.QUADRANT] = columns, rows * columns
    plan[lanes.WIDE], plan[lanes.PART], plan[lanes.BITS] = w + 1, (h + 1) * (w + 1), bits
    return _Pool(
        padded,
        given,
        plan,
        np.zeros((room, lines.LINE)),
        np.zeros((1, room)),
        np.zeros((lanes.STATE, room), np.int32),
        np.zeros((lanes.HEIGHTS, room), np.float32),
        np.zeros((2, room), np.int32),
        np.zeros(room, np.int64),
    )


@kernel()
def looks_of(pose: Any, attitude: Any, height: float, ground: GroundArrays, out: Looks) -> None:
    """Eyes at `height` [m] over the ground under each rover's middle, along the body's own up.

    The body is rolled, pitched and turned, as in `patches.turned`. Where the ground is not known
    the eye is nowhere (NaN).

    Args:
        pose: Poses (n, 3).
        attitude: Height, pitch and roll (n, 3); the height is not used.
        height: Of the eye [m].
        ground: The heights; the ground is level at 0 where there are none.
        out: `eye` and `axes` are written, by `of`.
    """
    for k in range(pose.shape[0]):
        base = under(_layer(out, k, ground), pose[k, 0], pose[k, 1], ground)
        roll, pitch, heading = attitude[k, 2], attitude[k, 1], pose[k, 2]
        cr, sr = math.cos(roll), math.sin(roll)
        cp, sp = math.cos(pitch), math.sin(pitch)
        ch, sh = math.cos(heading), math.sin(heading)
        out.axes[k, 0, 0], out.axes[k, 0, 1], out.axes[k, 0, 2] = cp * ch, cp * sh, sp
        ahead, aside, up = -sp * sr, cr, cp * sr
        out.axes[k, 1, 0], out.axes[k, 1, 1] = ahead * ch - aside * sh, ahead * sh + aside * ch
        out.axes[k, 1, 2] = up
        ahead, aside, up = -sp * cr * height, -sr * height, cp * cr * height
        out.eye[k, 0] = pose[k, 0] + ahead * ch - aside * sh
        out.eye[k, 1] = pose[k, 1] + ahead * sh + aside * ch
        out.eye[k, 2] = base + up


@kernel(inline=True)
def _layer(looks: Looks, k: int, ground: GroundArrays) -> int:
    return looks.of[k] if ground.heights.shape[0] > 1 else 0


@kernel(inline=True)
def _level(z: float, end: float) -> float:
    """Smallest t at which a line from height z to `end` is at or below 0, or MISS."""
    if z <= 0.0:
        return 0.0
    return z / (z - end) if end <= 0.0 else MISS


@kernel()
def _plain(looks: Looks, k: int, b: int, reach: float, ground: GroundArrays) -> float:
    """The plain walk of one beam."""
    layer, end = _layer(looks, k, ground), end_of(looks, k, b, reach)
    if ground.heights.shape[1] == 0:
        return _level(looks.eye[k, 2], end[2])
    shape = (ground.heights.shape[1], ground.heights.shape[2])
    heights, tops = ground.heights[layer].ravel(), ground.tops[layer]
    a = (looks.eye[k, 0], looks.eye[k, 1], looks.eye[k, 2])
    return walk(a, end, ground.cell, shape, heights, tops, ground.levels)


@kernel()
def _set_out(looks: Looks, k: int, at: int, scale: Any, pool: _Pool) -> None:
    """The beams of eye k set out, from column `at` of the pool on."""
    g = pool.given
    g[lines.X], g[lines.Y], g[lines.EYE] = looks.eye[k, 0], looks.eye[k, 1], looks.eye[k, 2]
    for axis in range(3):
        g[lines.FX + axis], g[lines.LX + axis] = looks.axes[k, 0, axis], looks.axes[k, 1, axis]
    g[lines.U0], g[lines.V0] = g[lines.X] / g[lines.CELL] + 0.5, g[lines.Y] / g[lines.CELL] + 0.5
    g[lines.LOWEST], g[lines.GRAIN] = scale[0], 1.0 / scale[1]
    for first in range(0, pool.ways.shape[1], WIDE):
        set_out(pool.ways, g, pool.line, pool.state, pool.height, pool.t, (first, at + first))
    for n in range(at, at + pool.ways.shape[1]):
        pool.state[lanes.BEAM, n] = n


@kernel()
def _march_all(pool: _Pool, count: int, layer: int, ground: GroundArrays, top: TopArrays) -> None:
    """Where the first `count` beams of the pool meet ground, to `pool.t`."""
    state, plan, stops = pool.state, pool.plan, pool.stops
    coarse, fine, heights = top.coarse.ravel(), top.fine.ravel(), ground.heights.ravel()
    h, w = ground.heights.shape[1], ground.heights.shape[2]
    plan[lanes.COARSE], plan[lanes.FINE] = layer * top.coarse.shape[1], layer * top.fine.shape[1]
    while count > 0:
        plan[lanes.FEW] = LANES // 4 if count > LANES else 0
        room = -(-count // LANES) * LANES
        for n in range(count, room):
            state[lanes.LAST, n], state[lanes.GONE, n] = -1, 0
        for first in range(0, room, LANES):
            march(coarse, fine, plan, state, pool.height, first)
        stopped = 0
        for n in range(count):
            stops[0, stopped], stops[1, stopped] = state[lanes.BEAM, n], state[lanes.GONE, n]
            stopped += state[lanes.MET, n] & 1
        for n in range(stopped, -(-stopped // WIDE) * WIDE):
            stops[:, n] = stops[:, stopped - 1]
        for first in range(0, stopped, WIDE):
            judge(pool.line, heights, (layer * h * w, h, w), stops, pool.t, first)
        count = _left(pool, count)


@kernel()
def _left(pool: _Pool, count: int) -> int:
    """Bring those to the front that still go on; how many they are."""
    state, height, left = pool.state, pool.height, 0
    for n in range(count):
        gone = state[lanes.GONE, n] + (state[lanes.MET, n] & 1)
        if gone > state[lanes.LAST, n] or pool.t[0, state[lanes.BEAM, n]] <= 1.0:
            continue
        for row in range(lanes.STATE):
            state[row, left] = state[row, n]
        for row in range(lanes.HEIGHTS):
            height[row, left] = height[row, n]
        state[lanes.GONE, left] = gone
        left += 1
    return left
