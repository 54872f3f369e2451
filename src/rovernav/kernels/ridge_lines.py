"""Lines over heights, eight at a time: how beams set out, and what one column of ground does.

The arithmetic of `ridges.walk`, operation for operation, without its branches; `vectors` tells how
it becomes vectors of the compiler's own. Under NUMBA_DISABLE_JIT NumPy does it.

Symbols: as in `ridges`; e, x where a line enters and leaves a patch.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from . import ridge_lanes as lanes
from ._jit import JIT_DISABLED
from .geometry import MISS
from .ridges import SLACK, TINY
from .vectors import WIDE, Own, Plain, least, most

U, V, Z, DU, DV, DZ, ALONG, ACROSS, BEGIN, END, COLUMN, UP = range(12)
"""What a line is: begin and change along the main axis, across it and up, one over its changes
along and across, its ends on the grid, its first column, and 1 where the main axis is y."""
LINE = 2 * WIDE
"""Numbers of a line, some unused: two vectors."""
(
    X,
    Y,
    EYE,
    U0,
    V0,
    FX,
    FY,
    FZ,
    LX,
    LY,
    LZ,
    REACH,
    CELL,
    WIDTH,
    HEIGHT,
    LOWEST,
    GRAIN,
    ONE,
    MARGIN,
    FAR,
) = range(20)
"""What the beams of one eye have in common: where it is [m] and, along x and y, [posts]; unit
vectors forward and left, reach and cell [m], posts in a row and in a column, lowest post [m] and
one over a grain [1/m]; parts of a row, the margin for their rounding [rows], the reach [posts]."""
COMMON = 20
_LEAST, _LARGEST = 1e-3, 1e6
"""Least change along the main axis, and largest coordinate [posts], that are marched."""


def _span(do: Any, a: Any, d: Any, over: Any, low: Any, high: Any) -> tuple[Any, Any]:
    """`ridges._span`."""
    first, last = (low - a) * over, (high - a) * over
    back = d < 0.0
    first, last = do.where(back, last, first), do.where(back, first, last)
    first, last = most(do, 0.0, first), least(do, 1.0, last)
    inside, still = (a >= low) & (a <= high), (d <= 0.0) & (d >= 0.0)
    first = do.where(still, do.where(inside, 0.0, 1.0), first)
    return first, do.where(still, do.where(inside, 1.0, 0.0), last)


def _set_out(do: Any, p: Any, q: Any, g: Any) -> tuple[list[Any], ...]:
    """Lines, states, heights and ends of beams in the ways (p, q) of an eye.

    A beam's end is MISS, or NaN where the lanes' numbers are not enough for it.
    """
    x, y, z, c, w, h = g(X), g(Y), g(EYE), g(CELL), g(WIDTH), g(HEIGHT)
    dx = (x + g(REACH) * (p * g(FX) + q * g(LX)) - x) / c
    dy = (y + g(REACH) * (p * g(FY) + q * g(LY)) - y) / c
    dz = z + g(REACH) * (p * g(FZ) + q * g(LZ)) - z
    dx, dy = (do.where(do.size(d) > TINY, d, 0.0) for d in (dx, dy))
    up = do.size(dy) > do.size(dx)
    u, v = do.where(up, g(V0), g(U0)), do.where(up, g(U0), g(V0))
    du, dv = do.where(up, dy, dx), do.where(up, dx, dy)
    columns, rows = do.where(up, h, w), do.where(up, w, h)
    along = do.where(do.size(du) > 0.0, 1.0 / du, 0.0)
    across = do.where(do.size(dv) > 0.0, 1.0 / dv, 0.0)
    begin, end = _span(do, u, du, along, 0.5, columns + 0.5)
    other = _span(do, v, dv, across, 0.5, rows + 0.5)
    begin, end = most(do, begin, other[0]), least(do, end, other[1])
    near, far = u + begin * du, u + end * du
    lowest = most(do, 0.0, do.floor(least(do, near, far) - SLACK))
    highest = least(do, columns, do.floor(most(do, near, far) + SLACK))
    on = du > 0.0
    line = [u, v, z, du, dv, dz, along, across, begin, end, do.where(on, lowest, highest)]
    line.append(do.where(up, 1.0, 0.0))
    well, state, height = _marching(do, line, g)
    state[lanes.LAST_ROW] = rows
    state[lanes.QUARTER] = do.where(dy >= 0.0, 0.0, 2.0) + do.where(dx >= 0.0, 0.0, 1.0)
    state[lanes.LAST] = do.where(well & (begin <= end), highest - lowest, -1.0)
    return line, state, height, [do.where(well, MISS, np.nan)]


def _marching(do: Any, line: list[Any], g: Any) -> tuple[Any, list[Any], list[Any]]:
    """Whether the lanes' numbers are enough for lines; the states and heights to march with."""
    u, v, z, du, dv, dz, along, _, begin, end, column, up = line
    on, margin = du > 0.0, g(MARGIN)
    s, rise = dv * do.size(along), dz * do.size(along)
    ahead = do.where(on, column - u, u - column - 1.0)
    v0, z0 = v + s * ahead, (z + rise * ahead - g(LOWEST)) * g(GRAIN)
    rise = rise * g(GRAIN)
    slack = 0.25 + 1e-6 * (do.size(z0) + (g(FAR) + 32.0) * do.size(rise))
    well = (do.size(du) > _LEAST) & (do.size(s) < 1.0 - 4.0 * margin) & (slack < 1e30)
    well = well & (do.size(g(U0)) + do.size(g(V0)) < _LARGEST)
    sets_out, row = well & (begin <= end), do.floor(v0)

    def held(a: Any) -> Any:
        return do.where(sets_out, a, 0.0)

    state: list[Any] = [0.0] * lanes.STATE
    state[lanes.SLOPE] = held(do.floor(s * g(ONE)))
    low = v0 - row + do.where(s < 0.0, margin, -1.0 * margin)
    state[lanes.LOW] = held(do.floor(low * g(ONE)))
    state[lanes.CORNER], state[lanes.COLUMN] = held(row), held(column)
    state[lanes.TURN] = do.where(on, 1.0, -1.0)
    state[lanes.UP] = do.where(up > 0.5, -1.0, 0.0)
    return well, state, [held(z0 - slack), held(rise), held(least(do, 0.0, rise))]


def _judged(do: Any, q: Any, gone: Any, posts: Any, h: Any, w: Any) -> Any:
    """Smallest t at which the ground of one column is at or above a line, or MISS: `_column`."""
    line = [q(row) for row in range(UP + 1)]
    u, v, _, du, dv, _, along, across, begin, end, column, up = line
    zero, one = 0.0, 1.0
    up, forward = up > 0.5, du > 0.0
    columns, by = do.where(up, h, w), do.where(up, w, one)
    rows, apart = do.where(up, w, h), do.where(up, one, w)
    j = do.where(forward, column + gone, column - gone)
    near, far = do.where(forward, j, j + 1.0), do.where(forward, j + 1.0, j)
    t0 = least(do, one, most(do, zero, (near - u) * along))
    t1 = least(do, one, most(do, zero, (far - u) * along))
    v0, v1 = v + t0 * dv, v + t1 * dv
    first = most(do, zero, do.floor(least(do, v0, v1) - SLACK))
    last = least(do, rows, do.floor(most(do, v0, v1) + SLACK))
    t0, t1 = most(do, t0, begin), least(do, t1, end)
    j0 = most(do, j - 1.0, zero) * by
    j1 = least(do, j, columns - 1.0) * by
    there, second = first <= last, last > first  # a line of this kind touches two rows at most
    i0 = most(do, do.where(there, first, zero) - 1.0, zero)
    i1, i2 = least(do, do.where(there, first, zero), rows - 1.0), least(do, last, rows - 1.0)
    i2 = do.where(second, i2, i1)
    posts_of = [[posts(at * apart + along) for along in (j0, j1)] for at in (i0, i1, i2)]
    found = []
    for number in (0, 1):
        i = first + float(number)
        e, x = _span(do, v, dv, across, i, i + 1.0)
        e, x = most(do, e, t0), least(do, x, t1)
        t = _patch(do, line[: DZ + 1], (e, x), (j, i), posts_of[number] + posts_of[number + 1])
        on = (second if number else there) & (e <= x) & (t <= 1.0)
        found.append(do.where(on, t, MISS))
    near, far = (do.where(dv >= 0.0, found[m], found[1 - m]) for m in (0, 1))
    return do.where(near <= 1.0, near, far)


def _patch(do: Any, line: Any, ends: Any, corner: Any, posts: list[Any]) -> Any:
    """`ridges._patch`."""
    (u, v, z, du, dv, dz), (e, x), (near, right, left, far) = line, ends, posts
    top = most(do, most(do, near, right), most(do, left, far))
    over = least(do, z + e * dz, z + x * dz) > top
    p, q = u + e * du - corner[0], v + e * dv - corner[1]
    gu, gv, twist = right - near, left - near, (far - left) - (right - near)
    f = (near + gu * p + gv * q + twist * p * q) - (z + e * dz)
    curve = twist * du * dv
    rate = gu * du + gv * dv + twist * (p * dv + q * du) - dz
    square = rate * rate - 4.0 * curve * f
    met = (square >= 0.0) & ~((rate <= 0.0) & (curve <= 0.0))
    root = do.root(do.where(met, square, 0.0))
    t = e + do.where(rate < 0.0, (root - rate) / (2.0 * curve), -2.0 * f / (rate + root))
    t = do.where(met & (t <= x), t, MISS)
    return do.where(over, MISS, do.where(f >= 0.0, e, t))


def _typed_set_out(
    _context: Any, ways: Any, common: Any, line: Any, state: Any, height: Any, t: Any, at: Any
) -> Any:
    """Eight beams from column at[0] of `ways` on set out, from column at[1] of the pool on."""

    def build(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        given, numbers, lines, states, heights, ends, places = args
        begin, to = (builder.extract_value(places, which) for which in (0, 1))
        do = Own(context, builder)
        data = context.make_array(common)(context, builder, numbers).data
        known = [do.every(builder.gep(data, [ir.IntType(64)(row)])) for row in range(COMMON)]
        p, q = (do.load(do.row(ways, given, row, begin)) for row in (0, 1))
        numbers_of, *parts = _set_out(do, p, q, known.__getitem__)
        data = context.make_array(line)(context, builder, lines).data
        for part in (0, WIDE):
            for lane, vector in enumerate(do.turned(numbers_of[part : part + WIDE])):
                offset = builder.mul(builder.add(to, to.type(lane)), to.type(LINE))
                do.store(vector, builder.gep(data, [builder.add(offset, to.type(part))]))
        kinds = ((state, states, "whole"), (height, heights, "single"), (t, ends, "double"))
        for rows, (kind, array, number) in zip(parts, kinds, strict=True):
            for row, vector in enumerate(rows):
                do.store(vector, do.row(kind, array, row, to), number)
        return context.get_dummy_value()

    return types.void(ways, common, line, state, height, t, at), build


def _typed_judge(
    _context: Any, line: Any, heights: Any, where: Any, stops: Any, t: Any, at: Any
) -> Any:
    """Eight stops from column `at` on, beams and columns gone: their ends are written.

    `where` are begin, rows and columns of the grid of heights.
    """

    def build(context: Any, builder: Any, _signature: Any, args: Any) -> Any:
        lines, posts, grid, listed, ends, first = args
        begin, tall, wide = (builder.extract_value(grid, which) for which in range(3))
        do = Own(context, builder)
        beam = do.whole(do.row(stops, listed, 0, first))
        gone = do.real(do.whole(do.row(stops, listed, 1, first)))
        data = context.make_array(line)(context, builder, lines).data
        rows: list[Any] = []
        for part in (0, WIDE):
            parts = []
            for lane in range(WIDE):
                number = builder.zext(
                    builder.extract_element(beam, ir.IntType(32)(lane)), begin.type
                )
                offset = builder.add(builder.mul(number, begin.type(LINE)), begin.type(part))
                parts.append(do.load(builder.gep(data, [offset])))
            rows += do.turned(parts)
        data = builder.gep(context.make_array(heights)(context, builder, posts).data, [begin])
        sizes = [_spread(do, number) for number in (tall, wide)]
        found = _judged(
            do, rows.__getitem__, gone, lambda at: do.gather(data, do.index(at)), *sizes
        )
        _scatter(do, found, do.row(t, ends, 0, begin.type(0)), beam)
        return context.get_dummy_value()

    return types.void(line, heights, where, stops, t, at), build


def _spread(do: Own, number: Any) -> Any:
    slot = do.builder.alloca(ir.DoubleType())
    do.builder.store(do.builder.sitofp(number, ir.DoubleType()), slot)
    return do.every(slot)


def _scatter(do: Own, found: Any, place: Any, index: Any) -> None:
    for lane in range(WIDE):
        at = do.builder.extract_element(index, ir.IntType(32)(lane))
        value = do.builder.extract_element(found.value, ir.IntType(32)(lane))
        do.builder.store(value, do.builder.gep(place, [at]))


def plain_set_out(
    ways: Any, common: Any, line: Any, state: Any, height: Any, t: Any, at: tuple[int, int]
) -> None:
    """The same in NumPy."""
    first, to = at
    with np.errstate(all="ignore"):
        p, q = ways[:, first : first + WIDE]
        parts = _set_out(Plain, p, q, common.__getitem__)
        for rows, into in zip(parts, (line.T, state, height, t), strict=True):
            for row, vector in enumerate(rows):
                into[row, to : to + WIDE] = vector


def plain_judge(
    line: Any, heights: Any, where: tuple[int, int, int], stops: Any, t: Any, at: int
) -> None:
    """The same in NumPy."""
    beam, gone = stops[:, at : at + WIDE]
    begin, h, w = where
    posts, rows = heights.reshape(-1)[begin:], line[beam].T
    with np.errstate(all="ignore"):
        t[0, beam] = _judged(
            Plain,
            rows.__getitem__,
            gone.astype(np.float64),
            lambda at: Plain.gather(posts, Plain.index(at)),
            float(h),
            float(w),
        )


set_out: Any = plain_set_out if JIT_DISABLED else intrinsic(_typed_set_out)
judge: Any = plain_judge if JIT_DISABLED else intrinsic(_typed_judge)
