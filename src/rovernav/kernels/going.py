"""What going costs in a direction: rates per cell, straight pieces, the cheapest way on a graph.

The one cost function of routes: planner, table and "why here" all read it. A piece pays for each
cell that it crosses the cell's rate, for the piece's own direction, times its length within the
cell. Cells are closed: a piece that touches a blocked cell, be it at a corner, costs infinitely
much. A piece on the border of two cells pays half to each. Coordinates are in cells, x along the
columns and y along the rows.

Symbols: p, q gradient of the ground to the east and north; (ex, ey) unit direction of travel.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ._jit import kernel
from .traction import EFFICIENCY, IDLE, ROLLING, SPEED, WEIGHT, drive_edge

NEAR = 1e-9
"""Cells within this distance [cells] of a piece count as touched."""
FULL = -1
"""What a search returns when its heap has no room left: begin anew with a larger one."""

DISTANCE, TIME, ENERGY, RISK = range(4)
"""Kinds of cost: what a metre of map costs in metres, seconds, joules or risk."""

PACE, W_NEAR, W_SLOPE, W_SLIP, W_UNSURE, MOST_SLIP, STEEPEST = range(7)
"""Items of `Going.rates`: seconds a metre without a table; the weights of risk; the largest slip
and the square of the steepest slope that they are counted against."""
RATES = 7

TERMS = 5
"""Parts that every kind of cost is split into."""


class Going(NamedTuple):
    """Ground as the kernels have it.

    Attributes:
        east: Gradient p (h, w), float32.
        north: Gradient q (h, w), float32.
        near: Nearness of hazards (h, w), float32, 0 to 1.
        blocked: 1 where it is forbidden to go (h, w), uint8.
        table: What driving costs, `rover.drive_table` (1, columns).
        rates: See PACE and its companions, float64.
        kind: What to count.
        drives: Whether the table counts; without one there is neither slip nor energy.
    """

    east: Any
    north: Any
    near: Any
    blocked: Any
    table: Any
    rates: Any
    kind: int
    drives: bool


class Stencil(NamedTuple):
    """Moves of a graph over the cells, with the cells that each one touches.

    Attributes:
        down: Rows of each move, int64.
        right: Columns of each move, int64.
        first: For each move its first touched cell, and one more number for the end, int64.
        row: Touched cells, rows from the move's own, int64.
        column: Touched cells, columns from the move's own, int64.
        within: Length of the move in each touched cell [cells], float64.
    """

    down: Any
    right: Any
    first: Any
    row: Any
    column: Any
    within: Any


class Heap(NamedTuple):
    """Room for a binary heap: keys, float64, and cells, int64."""

    key: Any
    cell: Any


@kernel(inline=True)
def rate(g: Going, i: int, j: int, ex: float, ey: float) -> float:
    """Cost per metre of map in one cell for one direction; inf where it is not allowed."""
    if g.blocked[i, j] != 0:
        return np.inf
    p, q = np.float64(g.east[i, j]), np.float64(g.north[i, j])
    energy, time, slip, code = 0.0, g.rates[PACE], 0.0, 0
    if g.drives:
        energy, time, slip, _side, code = drive_edge(p, q, ex, ey, g.table, 0)
        if code & 7 != 0 or not energy < np.inf:
            return np.inf
    if g.kind == DISTANCE:
        return 1.0
    if g.kind == TIME:
        return time
    if g.kind == ENERGY:
        return energy
    slope = g.rates[W_SLOPE] * (p * p + q * q) / g.rates[STEEPEST]
    lost = max(slip, 0.0) / g.rates[MOST_SLIP]
    unsure = g.rates[W_UNSURE] if code > 7 else 0.0
    return 1.0 + g.rates[W_NEAR] * g.near[i, j] + slope + g.rates[W_SLIP] * lost * lost + unsure


@kernel()
def parts(g: Going, i: int, j: int, way: tuple[float, float], out: Any) -> None:
    """Split the rate of a cell (TERMS,): its sum is what `rate` gives, where going is allowed.

    distance: all in the first. time: level ground, slope, weak motors, slip. energy: rolling,
    climbing (below 0 downhill), slip, idle power. risk: exposure, nearness, slope, slip, unsure.
    """
    out[:] = 0.0
    ex, ey = way
    p, q = np.float64(g.east[i, j]), np.float64(g.north[i, j])
    if g.kind == DISTANCE or (not g.drives and g.kind != RISK):
        out[0] = 1.0 if g.kind == DISTANCE else g.rates[PACE]
        return
    slip, side, code, energy, time = 0.0, 0.0, 0, 0.0, 0.0
    if g.drives:
        energy, time, slip, side, code = drive_edge(p, q, ex, ey, g.table, 0)
    if g.kind == RISK:
        out[0], out[1] = 1.0, g.rates[W_NEAR] * g.near[i, j]
        out[2] = g.rates[W_SLOPE] * (p * p + q * q) / g.rates[STEEPEST]
        lost = max(slip, 0.0) / g.rates[MOST_SLIP]
        out[3] = g.rates[W_SLIP] * lost * lost
        out[4] = g.rates[W_UNSURE] if code > 7 else 0.0
        return
    along = p * ex + q * ey
    stretch = np.sqrt(1.0 + along * along)
    progress = np.sqrt((1.0 - slip) * (1.0 - slip) - side * side)
    if g.kind == TIME:
        level = 1.0 / g.table[0, SPEED]
        out[0], out[1] = level, (stretch - 1.0) * level
        out[2] = time * progress - stretch * level
        out[3] = time * (1.0 - progress)
    else:
        idle = g.table[0, IDLE] * time
        driven = energy - idle
        rolling = g.table[0, WEIGHT] * g.table[0, ROLLING] / g.table[0, EFFICIENCY]
        out[0], out[1] = rolling, driven * progress - rolling
        out[2], out[3] = driven * (1.0 - progress), idle


@kernel(inline=True)
def _touched(low: float, high: float, count: int) -> tuple[int, int]:
    """First and last of `count` cells in a row that touch [low, high], as far as there are any."""
    first = max(int(np.floor(low - NEAR)), 0)
    return min(first, count - 1), min(int(np.floor(high + NEAR)), count - 1)


@kernel()
def walk(
    a: tuple[float, float], b: tuple[float, float], shape: Any, cells: Any, within: Any
) -> int:
    """Cells that the straight piece from a to b touches, and its length in each.

    Args:
        a: One end (x, y) [cells].
        b: The other.
        shape: Rows and columns of the grid.
        cells: Room for rows and columns (m, 2), int64.
        within: Room for the lengths (m,) [cells]; 0 where only touched.

    Returns:
        How many; -1 where the piece leaves the grid.
    """
    h, w = shape
    ax, ay, bx, by = a[0], a[1], b[0], b[1]
    if not (min(ax, bx) >= 0.0 and max(ax, bx) <= w and min(ay, by) >= 0.0 and max(ay, by) <= h):
        return -1
    dx, dy = bx - ax, by - ay
    steep = abs(dy) > abs(dx)
    if steep:  # x runs along the longer side, whichever that is
        ax, ay, bx, by, dx, dy, h, w = ay, ax, by, bx, dy, dx, w, h
    if dx < 0.0:
        ax, ay, bx, by, dx, dy = bx, by, ax, ay, -dx, -dy
    length = np.hypot(dx, dy)
    first, last = _touched(ax, bx, w)
    per = 1.0 / dx if dx > 0.0 else 0.0
    slope, count = dy * per, 0
    for column in range(first, last + 1):
        x0, x1 = max(ax, float(column)), min(bx, column + 1.0)
        y0, y1 = ay + (x0 - ax) * slope, ay + (x1 - ax) * slope
        low, high = min(y0, y1), max(y0, y1)
        south, north = _touched(low, high, h)
        here = max(x1 - x0, 0.0) * per * length
        for row in range(south, north + 1):
            if high - low <= 2.0 * NEAR:
                share = 1.0 / (north - south + 1)
            else:
                share = max(min(high, row + 1.0) - max(low, float(row)), 0.0) / (high - low)
            cells[count, 0], cells[count, 1] = (column, row) if steep else (row, column)
            within[count] = here * share
            count += 1
    return count


@kernel()
def piece(
    a: tuple[float, float], b: tuple[float, float], g: Going, cells: Any, within: Any
) -> float:
    """Cost of the straight piece from a to b [per metre times cells]; inf where not allowed.

    `cells` and `within` are room for `walk`.
    """
    dx, dy = b[0] - a[0], b[1] - a[1]
    length = np.hypot(dx, dy)
    count = walk(a, b, g.blocked.shape, cells, within)
    if count < 0:
        return np.inf
    ex, ey = (dx / length, dy / length) if length > 0.0 else (1.0, 0.0)
    total = 0.0
    for k in range(count):
        i, j = cells[k, 0], cells[k, 1]
        if within[k] > NEAR:
            total += within[k] * rate(g, i, j, ex, ey)
        elif g.blocked[i, j] != 0:
            return np.inf
        if not total < np.inf:
            return np.inf
    return total


@kernel()
def pieces(points: Any, g: Going, cells: Any, within: Any, out: Any) -> None:
    """Write the cost of each piece of a path (k, 2) to `out` (k-1,)."""
    for k in range(points.shape[0] - 1):
        a, b = (points[k, 0], points[k, 1]), (points[k + 1, 0], points[k + 1, 1])
        out[k] = piece(a, b, g, cells, within)


@kernel()
def split(points: Any, g: Going, cells: Any, within: Any, out: Any) -> None:
    """Write the terms of each piece of a path (k, 2) to `out` (k-1, TERMS); limits do not count."""
    some = np.empty(TERMS)
    out[:] = 0.0
    for k in range(points.shape[0] - 1):
        a, b = (points[k, 0], points[k, 1]), (points[k + 1, 0], points[k + 1, 1])
        length = np.hypot(b[0] - a[0], b[1] - a[1])
        count = walk(a, b, g.blocked.shape, cells, within) if length > 0.0 else 0
        for m in range(count):
            if within[m] > NEAR:
                way = ((b[0] - a[0]) / length, (b[1] - a[1]) / length)
                parts(g, cells[m, 0], cells[m, 1], way, some)
                for term in range(TERMS):
                    out[k, term] += within[m] * some[term]


@kernel()
def move(g: Going, s: Stencil, k: int, i: int, j: int) -> float:
    """Cost of the k-th move from the middle of cell (i, j) [per metre times cells]."""
    h, w = g.blocked.shape
    di, dj = s.down[k], s.right[k]
    if not (0 <= i + di < h and 0 <= j + dj < w):
        return np.inf
    for m in range(s.first[k], s.first[k + 1]):
        if g.blocked[i + s.row[m], j + s.column[m]] != 0:
            return np.inf
    length = np.sqrt(float(di * di + dj * dj))
    ex, ey, total = dj / length, di / length, 0.0
    for m in range(s.first[k], s.first[k + 1]):
        if s.within[m] > 0.0:
            total += s.within[m] * rate(g, i + s.row[m], j + s.column[m], ex, ey)
    return total


@kernel()
def search(
    g: Going, s: Stencil, goal: tuple[float, float], least: float, last: Any, d: Any, came: Any,
    heap: Heap,
) -> tuple[float, int]:  # fmt: skip
    """Lower `d` to the cost of the cheapest way from the seeds on the graph of the stencil's moves.

    A* with the bound `least` times the straight line: every move costs at least that, so the bound
    is consistent and no cell is taken twice.

    Args:
        g: The ground.
        s: The moves.
        goal: Where to (x, y) [cells].
        least: Cost per cell that no cell undercuts; 0 searches without a bound.
        last: Cost from the middles of (2 r + 1, 2 r + 1) cells around the goal's to the goal,
            float64; inf where it cannot be reached from there. An empty array has no goal.
        d: Costs of the seeds, inf elsewhere, float64 (h, w); changed.
        came: The move by which each cell was reached, -1 elsewhere, int8 (h, w); changed.
        heap: Room.

    Returns:
        Cost to the goal, and its last cell (flat), -1 where there is no way; or FULL as the cost.
    """
    w = d.shape[1]
    reach, gi, gj = last.shape[0] // 2, int(goal[1]), int(goal[0])
    best, end = np.inf, -1
    size = _seed(d, goal, least, heap)
    while size > 0 and heap.key[0] < best:
        key, cell = heap.key[0], heap.cell[0]
        size = _pop(heap, size)
        i, j = cell // w, cell % w
        here = d[i, j]
        if key > here + _bound(i, j, goal, least):
            continue  # it was lowered meanwhile
        if last.size > 0 and abs(i - gi) <= reach and abs(j - gj) <= reach:
            whole = here + last[i - gi + reach, j - gj + reach]
            if whole < best:
                best, end = whole, cell
        for k in range(s.down.size):
            step = move(g, s, k, i, j)
            if here + step < np.inf:
                oi, oj = i + s.down[k], j + s.right[k]
                if here + step < d[oi, oj]:
                    if size == heap.key.size:
                        return float(FULL), -1
                    d[oi, oj], came[oi, oj] = here + step, k
                    size = _push(heap, size, here + step + _bound(oi, oj, goal, least), oi * w + oj)
    return best, end


@kernel()
def _seed(d: Any, goal: tuple[float, float], least: float, heap: Heap) -> int:
    """Put every cell that has a cost into the heap; returns how many."""
    size = 0
    for i in range(d.shape[0]):
        for j in range(d.shape[1]):
            if d[i, j] < np.inf:
                size = _push(heap, size, d[i, j] + _bound(i, j, goal, least), i * d.shape[1] + j)
    return size


@kernel(inline=True)
def _bound(i: int, j: int, goal: tuple[float, float], least: float) -> float:
    dx, dy = goal[0] - j - 0.5, goal[1] - i - 0.5
    return least * np.sqrt(dx * dx + dy * dy)


@kernel()
def _push(heap: Heap, size: int, key: float, cell: int) -> int:
    at = size
    while at > 0 and heap.key[(at - 1) // 2] > key:
        up = (at - 1) // 2
        heap.key[at], heap.cell[at] = heap.key[up], heap.cell[up]
        at = up
    heap.key[at], heap.cell[at] = key, cell
    return size + 1


@kernel()
def _pop(heap: Heap, size: int) -> int:
    size -= 1
    key, cell, at = heap.key[size], heap.cell[size], 0
    while 2 * at + 1 < size:
        child = 2 * at + 1
        if child + 1 < size and heap.key[child + 1] < heap.key[child]:
            child += 1
        if heap.key[child] >= key:
            break
        heap.key[at], heap.cell[at] = heap.key[child], heap.cell[child]
        at = child
    heap.key[at], heap.cell[at] = key, cell
    return size


@kernel()
def walk_back(came: Any, s: Stencil, end: int, out: Any) -> int:
    """Cells (flat) of the way to `end`, from the end to a seed; their number, or FULL."""
    w, cell, count = came.shape[1], end, 0
    while count < out.size:
        out[count] = cell
        count += 1
        k = came[cell // w, cell % w]
        if k < 0:
            return count
        cell -= s.down[k] * w + s.right[k]
    return FULL
