"""Fans of range beams over grids: free cells are passed over by a table, what is met is judged.

Every beam runs along one axis, its columns, more than across it, its rows; in a column it touches
at most two rows. The table tells for each cell and each of the four directions how many columns on
the nearest blocked cell of the cone lies that opens one row to either side in every column: no beam
leaves that cone, so as many columns are free of anything to meet. Rays are marched in whole numbers
with a margin for their rounding, in which they touch too many cells, never too few. The first
blocked cell goes to `geometry.first_box`, the judge of every contact, and where the answer could
hang on the margin (corners, mostly) the plain walk `geometry.first_cell` decides. So a beam has the
bits of the plain walk.

Symbols: u place along a beam's main axis, v across it [cells]; s rows per column; m columns gone.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from . import ray_lanes as lanes
from ._jit import kernel
from .drive import WorldArrays, first_contact
from .geometry import MISS, first_boxes, first_cell, side_of
from .ray_lanes import LANES, MOST, TILE, march
from .shapes import first_shapes

_PADS = 4
"""Rows of the table beyond the grid: two before the first and two behind the last, so that a beam
beyond it is told of no row that there is."""
_LONGEST, _LARGEST = 1000.0, 1e6
"""Reach [cells] and coordinates [cells] that whole numbers of 32 bits are enough for."""
_FAR = 2**31 - 1
_EDGE = 1e-6
"""A beam that starts as near as this to a line between cells also touches the cells behind it."""


class ConeArrays(NamedTuple):
    """Free distances of each grid in four directions.

    Attributes:
        free: One row for each grid (g, m), uint8: towards +x and -x by column, +y and -y by row,
            then `SPARE` unused entries; (0, 0) where no table is used.
    """

    free: Any


SPARE = 3
"""Entries are read four at a time."""


@kernel(inline=True)
def _tiles(count: int) -> int:
    """Tiles that so many cells need."""
    return (count + TILE - 1) // TILE


@kernel()
def table_size(h: int, w: int) -> int:
    """Entries of the table of an (h, w) grid."""
    columns, rows = _tiles(w) * _tiles(h + _PADS), _tiles(h) * _tiles(w + _PADS)
    return 2 * TILE * TILE * (columns + rows) + SPARE


@kernel()
def free_cones(blocked: Any, out: Any) -> None:
    """Fill the table of each grid, in one pass over its cells for each direction.

    Args:
        blocked: Grids (g, h, w), uint8.
        out: To here (g, table_size(h, w)), uint8.
    """
    h, w = blocked.shape[1], blocked.shape[2]
    half = TILE * TILE * _tiles(w) * _tiles(h + _PADS)
    rest = TILE * TILE * _tiles(h) * _tiles(w + _PADS)
    out[:] = 0
    for g in range(blocked.shape[0]):
        upright = blocked[g].copy()  # read-only cells would compile `_cones` a second time
        turned = np.ascontiguousarray(upright.T)
        for way in range(2):
            _cones(turned, way == 0, out[g, way * half : (way + 1) * half])
            begin = 2 * half + way * rest
            _cones(upright, way == 0, out[g, begin : begin + rest])


@kernel()
def _cones(blocked: Any, forward: bool, out: Any) -> None:
    """Distances towards higher or lower first indices, the columns here, in tiles to `out`."""
    n, rows = blocked.shape
    most, one = np.uint8(MOST - 1), np.uint8(1)
    wide = TILE * TILE * _tiles(rows + _PADS)
    free = np.full(rows + _PADS, np.uint8(MOST))
    on = free.copy()
    for m in range(n):
        column = n - 1 - m if forward else m
        if m > 0:
            for i in range(1, rows + _PADS - 1):
                free[i] = min(min(min(on[i - 1], on[i]), on[i + 1]), most) + one
            free[0], free[rows + 3] = free[1], free[rows + 2]  # nearer: never too much
        for i in range(rows):
            free[i + 2] = np.uint8(0) if blocked[column, i] else free[i + 2]
        on[:] = free
        at = (column // TILE) * wide + column % TILE * TILE
        for i in range(rows + _PADS - 1):
            out[at + (i // TILE) * TILE * TILE + i % TILE] = free[i] | (free[i + 1] << np.uint8(4))


class _Fan(NamedTuple):
    """What the beams of one rover need, in arrays made once for all rovers.

    Attributes:
        ends: End of each beam (2, b) [cells].
        state: Rows of `ray_lanes` (STATE, b), int32.
        t: Where each beam ends (b,).
        plain: Nonzero where the plain walk must decide (b,).
    """

    ends: Any
    state: Any
    t: Any
    plain: Any


@kernel()
def range_fan(
    pose: Any, ways: Any, reach: float, world: WorldArrays, cones: ConeArrays, out: Any
) -> None:
    """Distance [m] from each rover along each beam to the first contact, at most `reach`.

    Beam b of a rover with heading a ends at (x, y) + reach (cos a wx - sin a wy, sin a wx + cos a
    wy), with (wx, wy) = ways[:, b]; a and its sine and cosine are taken once for all beams.

    Args:
        pose: Poses (n, 3).
        ways: Cosines and sines of the beams' angles in the rover's frame (2, b).
        reach: Longest distance [m].
        world: The true worlds.
        cones: Their table; without one every beam takes the plain walk.
        out: Distances (n, b) [m].
    """
    count = ways.shape[1]
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
    _fans(pose, ways, (reach, far, quick, bits), world, cones.free, fan, out)


@kernel(bare=True)
def _fans(
    pose: Any, ways: Any, size: Any, world: WorldArrays, free: Any, fan: _Fan, out: Any
) -> None:
    """`range_fan` with its room."""
    reach, far, quick, bits = size
    count, c = ways.shape[1], world.cell
    for k in range(pose.shape[0]):
        x, y = pose[k, 0], pose[k, 1]
        heading = pose[k, 2] if abs(pose[k, 2]) < np.inf else np.nan
        cosine, sine = math.cos(heading), math.sin(heading)
        for b in range(count):
            fan.ends[0, b] = x + reach * (cosine * ways[0, b] - sine * ways[1, b])
            fan.ends[1, b] = y + reach * (sine * ways[0, b] + cosine * ways[1, b])
        sure = abs(x) + abs(y) + abs(cosine) < _LARGEST * c
        if quick and sure:
            layer = world.of[k] if free.shape[0] > 1 else 0
            _through_grid(x / c, y / c, c, fan, bits, layer, (count, far), (world, free))
            others = world.boxes.shape[0] + world.shapes.size > 0
            for b in range(count):
                t = fan.t[b]
                if others:
                    t = min(t, _elsewhere(k, x, y, fan.ends[0, b], fan.ends[1, b], world))
                out[k, b] = reach * min(t, 1.0)
        else:
            for b in range(count):
                t = first_contact(k, x, y, fan.ends[0, b], fan.ends[1, b], world)
                out[k, b] = reach * min(t, 1.0)


@kernel(bare=True)
def _elsewhere(k: int, ax: float, ay: float, bx: float, by: float, world: WorldArrays) -> float:
    """Smallest t at which rover k's segment meets a box or a shape, or MISS."""
    of = world.of[k]
    t = first_boxes(ax, ay, bx, by, world.boxes, world.offsets[of], world.offsets[of + 1])
    if world.shapes.size:
        which = (world.shapes[of], world.shapes[of + 1])
        t = min(t, first_shapes(ax, ay, bx, by, world.corners, world.ends, world.radius, which))
    return t


@kernel(inline=True, bare=True)
def _through_grid(
    x: float, y: float, c: float, fan: _Fan, bits: int, layer: int, size: Any, where: Any
) -> None:
    """Where the beams from (x, y) [cells] first touch a blocked cell, to fan.t."""
    count, far = size
    world, free = where
    blocked = world.blocked[layer]
    _set_out(x, y, c, fan, bits, blocked.shape, (count, far))
    base = layer * free.shape[1]
    for first in range(0, fan.t.size, LANES):
        march(free, base, fan.state, first, bits)
    _judge(x, y, c, fan, count)
    for b in range(count):
        if fan.plain[b]:
            fan.t[b] = first_cell(x, y, fan.ends[0, b] / c, fan.ends[1, b] / c, blocked)


@kernel(bare=True)
def _set_out(x: float, y: float, c: float, fan: _Fan, bits: int, shape: Any, size: Any) -> None:
    """The state in which each beam sets out; those near a diagonal are left to the plain walk."""
    h, w = shape
    count, far = size
    state, one = fan.state, float(1 << bits)
    margin = far + 16.0  # more than the roundings of so many columns, in units of 1 / one
    steepest = 1.0 - 4.0 * margin / one
    for b in range(count):
        dx, dy = fan.ends[0, b] / c - x, fan.ends[1, b] / c - y
        up = abs(dy) > abs(dx)
        du, dv = (dy, dx) if up else (dx, dy)
        u, v = (y, x) if up else (x, y)
        n, rows = (h, w) if up else (w, h)
        on = du > 0.0
        s = dv / abs(du)
        column, row = np.floor(u - _EDGE) if on else np.floor(u + _EDGE), np.floor(v)
        end = np.floor(u + du + _EDGE) if on else np.floor(u + du - _EDGE)
        gone = max(0.0, -column if on else column - (n - 1.0))
        last = min(end, n - 1.0) - column if on else column - max(end, 0.0)
        plain = not abs(s) < steepest
        fan.plain[b] = plain
        s = 0.0 if plain else s
        low = v - row - s * (u - column if on else column + 1.0 - u)
        state[lanes.LOW, b] = int(np.floor((low + min(s, 0.0)) * one - margin))
        state[lanes.SLOPE, b] = int(np.floor(s * one))
        state[lanes.SPREAD, b] = int(abs(s) * one + 2.0 * margin)
        size_of_one = TILE * TILE * _tiles(n) * _tiles(rows + _PADS)
        first = 2 * TILE * TILE * _tiles(w) * _tiles(h + _PADS) if up else 0
        state[lanes.PLACE, b] = first + (0 if on else size_of_one)
        state[lanes.TILES, b] = TILE * TILE * _tiles(rows + _PADS)
        state[lanes.COLUMN, b] = int(column)
        state[lanes.ADVANCE, b] = 1 if on else -1
        state[lanes.CORNER, b] = int(row) + 2
        state[lanes.LAST_ROW, b] = rows + 2
        begin = (v - row) * one
        state[lanes.START, b] = int(np.floor(begin - margin)) if s > 0.0 else -_FAR
        state[lanes.STOP, b] = int(np.ceil(begin + margin)) if s < 0.0 else _FAR
        state[lanes.GONE, b] = int(min(gone, 2.0 * _LARGEST))
        state[lanes.LAST, b] = -1 if plain else int(max(last, -1.0))


@kernel(bare=True)
def _judge(x: float, y: float, c: float, fan: _Fan, count: int) -> None:
    """Where each beam touches the cell it was marched to; what hangs on a margin is marked plain.

    The comparisons and quotients of `geometry.first_box`, without its branches: eight at a time.
    """
    state = fan.state
    for b in range(count):
        bx, by = fan.ends[0, b] / c, fan.ends[1, b] / c
        dx, dy = bx - x, by - y
        up = abs(dy) > abs(dx)
        u, v, du = y if up else x, x if up else y, dy if up else dx
        m = state[lanes.GONE, b]
        column = np.floor(u - _EDGE) + m if du > 0.0 else np.floor(u + _EDGE) - m
        row = np.floor(v) + state[lanes.ROW, b]
        x0, y0 = row if up else column, column if up else row
        x1, y1 = x0 + 1.0, y0 + 1.0
        apart = (max(x, bx) < x0) | (min(x, bx) > x1) | (max(y, by) < y0) | (min(y, by) > y1)
        left, right = x0 if dy > 0.0 else x1, x1 if dy > 0.0 else x0
        top, bottom = y1 if dx > 0.0 else y0, y0 if dx > 0.0 else y1
        apart |= side_of(x, y, bx, by, left, top) < 0.0
        apart |= side_of(x, y, bx, by, right, bottom) > 0.0
        tx = ((x0 if dx > 0.0 else x1) - x) / dx if dx != 0.0 else 0.0
        ty = ((y0 if dy > 0.0 else y1) - y) / dy if dy != 0.0 else 0.0
        t = min(1.0, max(0.0, tx, ty))
        beyond = ((column + 1.0 if du > 0.0 else column) - u) / du  # no later column is met before
        met = m <= state[lanes.LAST, b]
        fan.plain[b] |= met & (apart | (t > beyond))
        fan.t[b] = t if met else MISS
