"""The teacher of the neural driver: what each heading costs on the map of what was sensed.

Symbols: s side of the map in cells, u cost to go in cells, q cost of a heading in cells.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ._jit import kernel
from .eikonal import sweep
from .fan import window


class TeacherSettings(NamedTuple):
    """How the teacher weighs.

    Attributes:
        cell: Cell of the map [m].
        ahead: How far along a heading it looks before it asks for the cost to go [cells].
        shy: Extra cost per cell beside something, falling off over two cells.
        turn: Cost of turning away from the present heading [cells/rad].
        softness: Difference in cost that makes a heading e times less likely [cells].
    """

    cell: float
    ahead: float
    shy: float
    turn: float
    softness: float


@kernel()
def label(cells: Any, centre: Any, pose: Any, goal: Any, t: TeacherSettings, out: Any) -> None:
    """Write each rover's distribution over headings to out (n, bins), rows summing to 1.

    Heading 0 points at the goal, the others follow to the left. The goal is sought on the local
    map alone: what was never sensed is free, and beyond the map the way is straight.
    """
    s = cells.shape[1]
    blocked = np.empty((s, s), np.uint8)
    f, u = np.empty((s, s)), np.empty((s, s))
    q = np.empty(out.shape[1])
    for k in range(pose.shape[0]):
        window(cells, centre, k, blocked)
        _costs(blocked, t.shy, f)
        gx = goal[k, 0] / t.cell - (centre[k, 1] - s // 2)
        gy = goal[k, 1] / t.cell - (centre[k, 0] - s // 2)
        _seeds(f, gx, gy, u)
        sweep(f, u, 1e-2, 16)
        x = pose[k, 0] / t.cell - (centre[k, 1] - s // 2)
        y = pose[k, 1] / t.cell - (centre[k, 0] - s // 2)
        to_goal = math.atan2(gy - y, gx - x)
        _headings(f, u, x, y, to_goal, pose[k, 2], t, q)
        _soften(q, t.softness, out[k])


@kernel()
def _costs(blocked: Any, shy: float, f: Any) -> None:
    """Cost per cell: inf where something is, more beside it, 1 elsewhere."""
    s = blocked.shape[0]
    f[:] = 1.0
    for i in range(s):
        for j in range(s):
            if blocked[i, j]:
                for di in range(-2, 3):
                    for dj in range(-2, 3):
                        a, b = i + di, j + dj
                        if 0 <= a < s and 0 <= b < s:
                            near = max(abs(di), abs(dj))
                            f[a, b] = max(f[a, b], 1.0 + shy / (near if near > 0 else 1))
    for i in range(s):
        for j in range(s):
            if blocked[i, j]:
                f[i, j] = np.inf


@kernel()
def _seeds(f: Any, gx: float, gy: float, u: Any) -> None:
    """The goal if it lies on the map; the map's edge, from where the way is straight."""
    s = f.shape[0]
    u[:] = np.inf
    inside = 1.0 <= gx < s - 1 and 1.0 <= gy < s - 1
    penalty = float(s) if inside else 0.0
    for e in range(s):
        for i, j in ((0, e), (s - 1, e), (e, 0), (e, s - 1)):
            if f[i, j] < np.inf:
                u[i, j] = np.hypot(j + 0.5 - gx, i + 0.5 - gy) + penalty
    if inside:
        row, column = int(gy), int(gx)
        for i in range(row - 1, row + 2):
            for j in range(column - 1, column + 2):
                u[i, j] = np.hypot(j + 0.5 - gx, i + 0.5 - gy)


@kernel()
def _headings(
    f: Any, u: Any, x: float, y: float, to_goal: float, heading: float, t: TeacherSettings, q: Any
) -> None:
    """Cost of each heading: the way ahead, the cost to go from its end, and the turn.

    Where every heading is blocked nearby, the one that is free for longest costs least.
    """
    bins = q.size
    open_way = False
    for b in range(bins):
        a = to_goal + 2.0 * math.pi * b / bins
        turned = abs(math.atan2(math.sin(a - heading), math.cos(a - heading)))
        q[b] = _ray(f, u, x, y, a, t.ahead) + t.turn * turned
        open_way = open_way or q[b] < np.inf
    if not open_way:
        for b in range(bins):
            q[b] = -_free(f, x, y, to_goal + 2.0 * math.pi * b / bins)


NEAR = 3
"""Quarter cells around the rover where a marked cell is only dear: the map is coarse there."""


@kernel()
def _ray(f: Any, u: Any, x: float, y: float, a: float, ahead: float) -> float:
    """Cost of going `ahead` cells in direction a and on to the goal; inf where blocked."""
    s = f.shape[0]
    cost, steps = 0.0, int(4.0 * ahead)
    best = np.inf
    for step in range(1, steps + 1):
        px, py = x + 0.25 * step * math.cos(a), y + 0.25 * step * math.sin(a)
        i, j = int(np.floor(py)), int(np.floor(px))
        if i < 0 or j < 0 or i >= s or j >= s:
            return best
        if f[i, j] == np.inf:
            if step > NEAR:
                return best if step > steps // 2 else np.inf
            cost += 1.0
            continue
        cost += 0.25 * f[i, j]
        best = cost + _between(u, px, py)
    return best


@kernel()
def _free(f: Any, x: float, y: float, a: float) -> float:
    """Quarter cells that are free in direction a, beyond the rover's own surroundings."""
    s = f.shape[0]
    for step in range(3, 4 * s):
        i = int(np.floor(y + 0.25 * step * math.sin(a)))
        j = int(np.floor(x + 0.25 * step * math.cos(a)))
        if i < 0 or j < 0 or i >= s or j >= s or f[i, j] == np.inf:
            return float(step)
    return 4.0 * s


@kernel()
def _between(u: Any, x: float, y: float) -> float:
    """Cost to go between cell centres; blocked neighbours do not count."""
    s = u.shape[0]
    i, j = int(np.floor(y - 0.5)), int(np.floor(x - 0.5))
    fy, fx = y - 0.5 - i, x - 0.5 - j
    total, weight = 0.0, 0.0
    for di in range(2):
        for dj in range(2):
            a, b = i + di, j + dj
            if 0 <= a < s and 0 <= b < s and u[a, b] < np.inf:
                share = (fy if di else 1.0 - fy) * (fx if dj else 1.0 - fx)
                total += share * u[a, b]
                weight += share
    return total / weight if weight > 1e-9 else np.inf


@kernel()
def _soften(q: Any, softness: float, out: Any) -> None:
    """Turn costs into a distribution: exp(-(q - min q) / softness), normalised."""
    least = q.min()
    total = 0.0
    for b in range(q.size):
        share = 1.0 if not least < np.inf else math.exp(-min((q[b] - least) / softness, 700.0))
        out[b] = share
        total += share
    for b in range(q.size):
        out[b] /= total
