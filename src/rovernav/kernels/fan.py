"""The map of what range beams sensed, and rays in it.

Symbols: pose x [m], y [m], heading [rad]; c cell of the map [m], s its side in cells.

The local map rolls: world cell (i, j) of the map's own grid lies at ``cells[k, i & m, j & m]`` with
m = s - 1, because s is a power of two, and only cells within s/2 of the rover's cell count. Nothing
is moved when the rover moves; rows and columns that leave on one side are cleared for those that
enter on the other.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ._jit import kernel


@kernel()
def bearing(pose: Any, goal: Any, out: Any) -> None:
    """World direction from each rover to its goal [rad], to out (n,)."""
    for k in range(pose.shape[0]):
        out[k] = math.atan2(goal[k, 1] - pose[k, 1], goal[k, 0] - pose[k, 0])


@kernel()
def roll(cells: Any, centre: Any, pose: Any, c: float) -> None:
    """Move each map's centre (n, 2) to its rover's cell; cells that enter are unknown (0)."""
    s = cells.shape[1]
    half, mask = s // 2, s - 1
    for k in range(pose.shape[0]):
        row, column = int(np.floor(pose[k, 1] / c)), int(np.floor(pose[k, 0] / c))
        if abs(row - centre[k, 0]) >= s or abs(column - centre[k, 1]) >= s:
            cells[k] = 0
        for i in range(centre[k, 0] + half, row + half):
            cells[k, i & mask] = 0
        for i in range(row - half, centre[k, 0] - half):
            cells[k, i & mask] = 0
        for j in range(centre[k, 1] + half, column + half):
            cells[k, :, j & mask] = 0
        for j in range(column - half, centre[k, 1] - half):
            cells[k, :, j & mask] = 0
        centre[k, 0], centre[k, 1] = row, column


@kernel()
def mark(
    cells: Any,
    centre: Any,
    pose: Any,
    angles: Any,
    ranges: Any,
    reach: float,
    c: float,
    join: float,
) -> None:
    """Mark in each map where beams ended on something, and between neighbours that are near.

    Args:
        cells: Maps (n, s, s), uint8, changed: 1 where something was met.
        centre: Cell of each rover (n, 2).
        pose: Poses (n, 3).
        angles: Beam directions (b,) [rad].
        ranges: Readings (n, b) [m].
        reach: Readings of this or more met nothing [m].
        c: Cell of the map [m].
        join: Two neighbouring hits nearer than this are one surface [m].
    """
    for k in range(pose.shape[0]):
        last_x, last_y = np.inf, np.inf
        for b in range(angles.size):
            if ranges[k, b] >= reach:
                last_x = np.inf
                continue
            a, r = pose[k, 2] + angles[b], ranges[k, b] + 0.01 * c
            x, y = pose[k, 0] + r * math.cos(a), pose[k, 1] + r * math.sin(a)
            gap = np.hypot(x - last_x, y - last_y)
            parts = int(2.0 * gap / c) + 1 if gap <= join else 1
            for part in range(parts):
                share = part / parts if parts > 1 else 0.0
                px, py = x, y
                if parts > 1:
                    px, py = x + share * (last_x - x), y + share * (last_y - y)
                _set(cells, centre, k, int(np.floor(py / c)), int(np.floor(px / c)))
            last_x, last_y = x, y


@kernel(inline=True)
def _set(cells: Any, centre: Any, k: int, row: int, column: int) -> None:
    s = cells.shape[1]
    half, mask = s // 2, s - 1
    rows, columns = row - centre[k, 0], column - centre[k, 1]
    if -half <= rows < half and -half <= columns < half:
        cells[k, row & mask, column & mask] = 1


@kernel()
def window(cells: Any, centre: Any, k: int, out: Any) -> None:
    """Map k as a plain array (s, s) with the rover's cell at (s/2, s/2)."""
    s = cells.shape[1]
    half, mask = s // 2, s - 1
    for i in range(s):
        for j in range(s):
            row, column = centre[k, 0] - half + i, centre[k, 1] - half + j
            out[i, j] = cells[k, row & mask, column & mask]


@kernel()
def around(cells: Any, centre: Any, pose: Any, zero: Any, c: float, out: Any) -> None:
    """Distance [m] from each rover to the first marked cell, in rays all round.

    Looks every half cell and passes over the rover's own surroundings of 0.75 cells, where the map
    is too coarse to tell.

    Args:
        cells: Maps (n, s, s).
        centre: Cell of each rover (n, 2).
        pose: Poses (n, 3).
        zero: World direction of ray 0 for each rover (n,) [rad]; the others follow to the left.
        c: Cell of the map [m].
        out: Distances (n, rays) [m]; (s/2 - 1) c where nothing is marked.
    """
    s = cells.shape[1]
    half, mask = s // 2, s - 1
    rays = out.shape[1]
    for k in range(pose.shape[0]):
        x, y = pose[k, 0] / c, pose[k, 1] / c
        for ray in range(rays):
            a = zero[k] + 2.0 * math.pi * ray / rays
            dx, dy = 0.5 * math.cos(a), 0.5 * math.sin(a)
            free = 2 * (half - 1)
            for step in range(2, 2 * (half - 1)):
                row, column = int(np.floor(y + step * dy)), int(np.floor(x + step * dx))
                if cells[k, row & mask, column & mask] != 0:
                    free = step
                    break
            out[k, ray] = 0.5 * c * free
