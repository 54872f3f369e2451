"""Beams over a grid of heights: where ground first rises to a straight line, and what it hides.

The ground is the bilinear surface between posts in the middle of cells, level within half a cell of
the grid's edge, and nowhere beyond. A patch is the square between four neighbouring posts; one with
a missing post (NaN) is not met. Along a line the surface of a patch is a parabola, so where it
rises to the line is the root of a quadratic, not a sample.

Blocks of 4 x 4, 8 x 8, ... patches know their highest post. A line that stays above it has nothing
to do in that block: no patch of it could pass its own first test, which is the same comparison.

Symbols: a, b ends of a segment, t in [0, 1] the place on it, c cell; u, v places counted in posts
along the axis that the line changes most on, and across it; f height of the ground over the line.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ._jit import kernel
from .geometry import MISS

FIRST = 2
"""Level of the smallest blocks: 2^2 patches on a side."""
SLACK = 1e-9
"""More than the rounding of a place [cells] on grids that fit a memory."""
TINY = 1e-290
"""Changes smaller than this are none: one over them is no number."""


class GroundArrays(NamedTuple):
    """Heights of worlds as arrays.

    Attributes:
        heights: Heights of each world or one grid for all (g, h, w), float32 [m]; (0, 0, 0) where
            worlds are flat.
        cell: Distance of posts [m].
        tops: Highest post of each block (g, m), float32 [m]; see `tops_of`.
        levels: Where each level of blocks begins in a row of `tops`, and the end (l + 1,).
    """

    heights: Any
    cell: float
    tops: Any
    levels: Any


def levels_of(h: int, w: int) -> Any:
    """Where the levels of blocks of an (h, w) grid begin in a row of `tops`, and the end (l + 1,).

    Level k has blocks of 2^(2 + k) patches on a side; the last has one block.
    """
    starts, side = [0], 1 << FIRST
    while True:
        rows, columns = -(-(h + 1) // side), -(-(w + 1) // side)
        starts.append(starts[-1] + rows * columns)
        if rows * columns == 1:
            return np.array(starts, dtype=np.int64)
        side *= 2


@kernel()
def tops_of(heights: Any, levels: Any, out: Any) -> None:
    """Highest post of each block of patches, level by level; missing posts do not count.

    Patch (i, j) lies between the posts i - 1 and i, j - 1 and j; those beyond the edge are its
    nearest posts.

    Args:
        heights: Heights of each world (g, h, w), float32 [m].
        levels: From `levels_of`.
        out: To here (g, levels[-1]), float32 [m].
    """
    h, w = heights.shape[1], heights.shape[2]
    side = 1 << FIRST
    for g in range(heights.shape[0]):
        top, low = out[g], np.float32(-np.inf)
        top[:] = low
        rows, columns = (h + side) // side, (w + side) // side
        for i in range(rows):
            for j in range(columns):
                highest = low
                for m in range(max(0, i * side - 1), min(h, (i + 1) * side)):
                    for n in range(max(0, j * side - 1), min(w, (j + 1) * side)):
                        z = heights[g, m, n]
                        highest = z if z > highest else highest
                top[i * columns + j] = highest
        for k in range(1, levels.size - 1):
            below, here, wide = levels[k - 1], levels[k], (columns + 1) // 2
            for i in range(rows):
                for j in range(columns):
                    at = here + (i // 2) * wide + j // 2
                    top[at] = max(top[at], top[below + i * columns + j])
            rows, columns = (rows + 1) // 2, wide


class _Line(NamedTuple):
    """A segment as the walk needs it: begin, change, and one over its changes along and across."""

    u: float
    v: float
    z: float
    du: float
    dv: float
    dz: float
    along: float
    across: float


@kernel(inline=True)
def _span(a: float, d: float, over: float, low: float, high: float) -> tuple[float, float]:
    """First and last t in [0, 1] with a + t d in [low, high]; none: the first is the larger."""
    if d == 0.0:
        return (0.0, 1.0) if low <= a <= high else (1.0, 0.0)
    first, last = (low - a) * over, (high - a) * over
    if d < 0.0:
        first, last = last, first
    return max(0.0, first), min(1.0, last)


@kernel(inline=True)
def _still(d: float) -> float:
    """A change so small that one over it is no number is none."""
    return d if abs(d) > TINY else 0.0


@kernel()
def first_rise(layer: int, a: Any, b: Any, ground: GroundArrays) -> float:
    """Smallest t at which the ground is at or above the segment from a to b, or MISS.

    Args:
        layer: Which grid of heights.
        a: One end: x, y, z [m].
        b: The other end.
        ground: The heights.

    Returns:
        t; 0 where a itself is not above the ground; MISS also if an end is not finite.
    """
    shape = (ground.heights.shape[1], ground.heights.shape[2])
    if shape[0] == 0:
        return MISS
    heights, tops = ground.heights[layer].ravel(), ground.tops[layer]
    return walk(a, b, ground.cell, shape, heights, tops, ground.levels)


@kernel()
def walk(a: Any, b: Any, c: float, shape: Any, heights: Any, tops: Any, levels: Any) -> float:
    """`first_rise` over one grid of heights, flat."""
    h, w = shape
    u, v = a[0] / c + 0.5, a[1] / c + 0.5  # patch (i, j) covers [i, i + 1] x [j, j + 1]
    du, dv, dz = _still((b[0] - a[0]) / c), _still((b[1] - a[1]) / c), b[2] - a[2]
    if not abs(u) + abs(v) + abs(du) + abs(dv) + abs(dz) + abs(a[2]) < np.inf:
        return MISS
    along, across = (w, 1), (h, w)  # posts, and how far apart they are in memory
    if abs(dv) > abs(du):
        u, v, du, dv, along, across = v, u, dv, du, across, along
    over, aside = 1.0 / du if du != 0.0 else 0.0, 1.0 / dv if dv != 0.0 else 0.0
    line = _Line(u, v, a[2], du, dv, dz, over, aside)
    begin, end = _span(u, du, over, 0.5, along[0] + 0.5)
    other = _span(v, dv, aside, 0.5, across[0] + 0.5)
    ends = (max(begin, other[0]), min(end, other[1]))
    if not ends[0] <= ends[1]:
        return MISS
    near, far = u + ends[0] * du, u + ends[1] * du
    lowest = max(0, int(np.floor(min(near, far) - SLACK)))
    highest = min(along[0], int(np.floor(max(near, far) + SLACK)))
    forward = du >= 0.0
    j, last = (lowest, highest) if forward else (highest, lowest)
    step, top, level = (1 if forward else -1), levels.size - 2, 0
    while (last - j) * step >= 0:
        if level >= 0:
            size = FIRST + level
            final = _block_end(j, last, size, forward)
            if _clear(line, (j, final), size, levels[level], tops, (w, along[1], across[0])):
                j, level = final + step, min(level + 1, top)
            else:
                level -= 1
            continue
        t = _column(line, ends, j, heights, along, across)
        if t <= 1.0:
            return t
        j += step
        if (j if forward else j + 1) & ((1 << FIRST) - 1) == 0:
            level = 0
    return MISS


@kernel(inline=True)
def _block_end(j: int, last: int, size: int, forward: bool) -> int:
    """The last column in driving direction of the block that column j is in."""
    if forward:
        return min(last, (((j >> size) + 1) << size) - 1)
    return max(last, (j >> size) << size)


@kernel(inline=True)
def _strip(line: _Line, j: int, end: int) -> tuple[float, float, float, float]:
    """First and last t of the line in the columns from j to end, and the least and largest v."""
    t0, t1 = 0.0, 1.0
    if line.du != 0.0:
        low, high = (j, end + 1) if line.du > 0.0 else (j + 1, end)
        t0 = min(1.0, max(0.0, (low - line.u) * line.along))
        t1 = min(1.0, max(0.0, (high - line.u) * line.along))
    v0, v1 = line.v + t0 * line.dv, line.v + t1 * line.dv
    return t0, t1, min(v0, v1) - SLACK, max(v0, v1) + SLACK


@kernel(inline=True)
def _clear(line: _Line, columns: Any, size: int, at: int, tops: Any, grid: Any) -> bool:
    """Whether the line stays above every post of the blocks it passes in these columns.

    Args:
        line: The line.
        columns: First and last one.
        size: Blocks have 2^size patches on a side.
        at: Where their level begins.
        tops: Highest post of each block.
        grid: Posts in a row, step in memory from column to column, posts across the line.
    """
    w, apart, others = grid
    j, end = columns
    t0, t1, south, north = _strip(line, j, end)
    low = min(line.z + t0 * line.dz, line.z + t1 * line.dz)
    wide = (w >> size) + 1
    first = max(0, int(np.floor(south))) >> size
    final = min(others, int(np.floor(north))) >> size
    for i in range(first, final + 1):
        block = i * wide + (j >> size) if apart == 1 else (j >> size) * wide + i
        if not low > tops[at + block]:
            return False
    return True


@kernel(inline=True)
def _column(line: _Line, ends: Any, j: int, heights: Any, along: Any, across: Any) -> float:
    """Smallest t at which the ground of column j of patches is at or above the line, or MISS."""
    t0, t1, south, north = _strip(line, j, j)
    t0, t1 = max(t0, ends[0]), min(t1, ends[1])
    first, last = max(0, int(np.floor(south))), min(across[0], int(np.floor(north)))
    for m in range(last - first + 1):
        i = first + m if line.dv >= 0.0 else last - m
        e, x = _span(line.v, line.dv, line.across, i, i + 1.0)
        e, x = max(e, t0), min(x, t1)
        if e <= x:
            j0, j1 = max(j - 1, 0) * along[1], min(j, along[0] - 1) * along[1]
            i0, i1 = max(i - 1, 0) * across[1], min(i, across[0] - 1) * across[1]
            z = (heights[i0 + j0], heights[i0 + j1], heights[i1 + j0], heights[i1 + j1])
            t = _patch(line, e, x, (j, i), z)
            if t <= 1.0:
                return t
    return MISS


@kernel(inline=True)
def _patch(line: _Line, e: float, x: float, corner: Any, posts: Any) -> float:
    """Smallest t from e to x at which a patch is at or above the line, or MISS."""
    u, v, z, du, dv, dz = line[:6]
    near, right = np.float64(posts[0]), np.float64(posts[1])
    left, far = np.float64(posts[2]), np.float64(posts[3])
    if min(z + e * dz, z + x * dz) > max(max(near, right), max(left, far)):
        return MISS
    p, q = u + e * du - corner[0], v + e * dv - corner[1]
    gu, gv, twist = right - near, left - near, (far - left) - (right - near)
    f = (near + gu * p + gv * q + twist * p * q) - (z + e * dz)
    if f >= 0.0:
        return e
    curve = twist * du * dv
    rate = gu * du + gv * dv + twist * (p * dv + q * du) - dz
    square = rate * rate - 4.0 * curve * f
    if not square >= 0.0 or (rate <= 0.0 and curve <= 0.0):  # never, or there is no ground
        return MISS
    root = np.sqrt(square)
    t = e + ((root - rate) / (2.0 * curve) if rate < 0.0 else -2.0 * f / (rate + root))
    return t if t <= x else MISS


@kernel()
def rise_fan(eye: Any, ways: Any, of: Any, reach: float, ground: GroundArrays, out: Any) -> None:
    """Distance [m] from each eye along each beam to the ground, at most `reach`.

    Args:
        eye: Where the sensors are (n, 3): x, y, z [m].
        ways: Directions of unit length in the world (n, b, 3).
        of: World of each rover (n,).
        reach: Longest distance along a beam [m].
        ground: The heights.
        out: Distances (n, b) [m].
    """
    shape = (ground.heights.shape[1], ground.heights.shape[2])
    if shape[0] == 0:
        out[:] = reach
        return
    for k in range(eye.shape[0]):
        layer = of[k] if ground.heights.shape[0] > 1 else 0
        heights, tops = ground.heights[layer].ravel(), ground.tops[layer]
        x, y, z = eye[k, 0], eye[k, 1], eye[k, 2]
        for n in range(ways.shape[1]):
            dx, dy, dz = ways[k, n, 0], ways[k, n, 1], ways[k, n, 2]
            b = (x + reach * dx, y + reach * dy, z + reach * dz)
            t = walk((x, y, z), b, ground.cell, shape, heights, tops, ground.levels)
            out[k, n] = reach * min(1.0, t)


@kernel()
def in_view(eye: Any, target: Any, of: Any, slack: float, ground: GroundArrays, out: Any) -> None:
    """1 where the straight line from each eye to its target is free, else 0.

    Args:
        eye: Where the sensors are (n, 3): x, y, z [m].
        target: What they look at (n, 3).
        of: World of each rover (n,).
        slack: Ground within this much of the target hides nothing [m]: targets lie on ground.
        ground: The heights.
        out: 1 or 0 (n, 1).
    """
    for k in range(eye.shape[0]):
        layer = of[k] if ground.heights.shape[0] > 1 else 0
        a = (eye[k, 0], eye[k, 1], eye[k, 2])
        b = (target[k, 0], target[k, 1], target[k, 2])
        length = np.sqrt((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2 + (b[2] - a[2]) ** 2)
        t = first_rise(layer, a, b, ground)
        out[k, 0] = 1.0 if t > 1.0 or (1.0 - t) * length <= slack else 0.0
