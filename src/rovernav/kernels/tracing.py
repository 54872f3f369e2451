"""From a field of costs to a path: downhill over the field, then drawn tight under the true cost.

A path is a list of points in cells, x along the columns and y along the rows. `descend` follows the
gradient of the field and never leaves cells that the field has reached; `tighten` leaves out points
that cost something; `bend` moves all points sideways at once to where the path costs least.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ._jit import kernel
from .marching import RING
from .polyline import across, piece

STEP = 0.5
"""Length of a step downhill [cells]."""

INSIDE = 0.02
"""Points keep this far from the border of their cell [cells], so that pieces touch no third."""

TINY = 1e-30
"""No slope is less steep, but for none."""

ALIKE = 1.0 + 1e-7
"""Costs that differ by less count as equal: points on a straight line shall go."""

PATIENCE = 16
"""Steps without getting lower after which whole cells are taken instead."""


@kernel()
def descend(u: Any, stride: int, x: float, y: float, out: Any) -> int:
    """Points downhill from (x, y) to the middle of the lowest cell, written to `out` (k, 2).

    Args:
        u: Cost from the seeds as `march` leaves it: flat, with its ring, inf where not reached.
        stride: Cells from one row to the next, the ring included.
        x: Where to begin, in a cell that the field has reached.
        y: As `x`.
        out: Room for the points.

    Returns:
        Number of points, or -1 where `out` is too short.
    """
    row, column = int(y), int(x)
    lowest, since, whole, count = np.inf, 0, 0, 0
    while True:
        if count == out.shape[0]:
            return -1
        out[count, 0], out[count, 1] = x, y
        count += 1
        cell = (row + RING) * stride + column + RING
        if u[cell] < lowest:
            lowest, since = u[cell], 0
        else:
            since += 1
            if since > PATIENCE:
                whole, since = 2 * PATIENCE, 0
        if 2 * count > out.shape[0]:
            whole = 1  # enough of wandering: whole cells only get lower
        nx, ny = x, y
        if whole == 0:
            gx, gy = _slope(u, stride, x, y)
            size = max(np.hypot(gx, gy), TINY)
            nx, ny = x - STEP * gx / size, y - STEP * gy / size
        i, j = int(np.floor(ny)), int(np.floor(nx))
        if (nx != x or ny != y) and _may(u, stride, cell, i - row, j - column):
            row, column = i, j
            x, y = _within(nx, j), _within(ny, i)
        else:
            whole = max(whole - 1, 0)
            di, dj = _steepest(u, stride, cell)
            if di == 0 and dj == 0:
                return count
            row, column = row + di, column + dj
            x, y = column + 0.5, row + 0.5


@kernel(inline=True)
def _within(x: float, column: int) -> float:
    return min(max(x, column + INSIDE), column + 1.0 - INSIDE)


@kernel(inline=True)
def _may(u: Any, stride: int, cell: int, di: int, dj: int) -> bool:
    """Whether one may go over to the cell (di, dj) away without touching what is not reached."""
    if di == 0 and dj == 0:
        return True
    side, ahead = cell + dj, cell + di * stride
    return u[side] < np.inf and u[ahead] < np.inf and u[ahead + dj] < np.inf


@kernel(inline=True)
def _steepest(u: Any, stride: int, cell: int) -> tuple[int, int]:
    """The way to the neighbour to which the field falls most; (0, 0) from the lowest cell."""
    best, way = 0.0, (0, 0)
    for di in range(-1, 2):
        for dj in range(-1, 2):
            other = cell + di * stride + dj
            if u[other] < u[cell] and _may(u, stride, cell, di, dj):
                fall = (u[cell] - u[other]) / np.sqrt(float(di * di + dj * dj))
                if fall > best:
                    best, way = fall, (di, dj)
    return way


@kernel()
def _slope(u: Any, stride: int, x: float, y: float) -> tuple[float, float]:
    """Upwind gradient of the field at a point: that of the four cells around, weighted."""
    i, j = int(np.floor(y - 0.5)), int(np.floor(x - 0.5))
    fy, fx = y - 0.5 - i, x - 0.5 - j
    gx, gy = 0.0, 0.0
    for di in range(2):
        for dj in range(2):
            cell = (i + di + RING) * stride + j + dj + RING
            here = np.float64(u[cell])
            if here < np.inf:
                share = (fy if di else 1.0 - fy) * (fx if dj else 1.0 - fx)
                gx += share * _upwind(here, u[cell - 1], u[cell + 1])
                gy += share * _upwind(here, u[cell - stride], u[cell + stride])
    return gx, gy


@kernel(inline=True)
def _upwind(here: float, before: float, after: float) -> float:
    if before <= after:
        return here - before if before < here else 0.0
    return after - here if after < here else 0.0


@kernel()
def tighten(points: Any, c: Any, ahead: int, out: Any) -> int:
    """Leave out points without which the path costs no more.

    Args:
        points: The path (k, 2).
        c: Cost per cell (h, w), inf where blocked.
        ahead: Points that one piece may replace.
        out: Room for the path (k, 2).

    Returns:
        Number of points kept; the first and the last are.
    """
    n = points.shape[0]
    out[0] = points[0]
    count, i = 1, 0
    while i < n - 1:
        far, span = i + 1, 2
        sofar = piece(points[i, 0], points[i, 1], points[far, 0], points[far, 1], c)
        while span <= ahead and i + span < n:
            total = sofar
            for k in range(far, i + span):
                total += piece(points[k, 0], points[k, 1], points[k + 1, 0], points[k + 1, 1], c)
            end = i + span
            straight = piece(points[i, 0], points[i, 1], points[end, 0], points[end, 1], c)
            if not straight <= total * ALIKE:
                break
            far, sofar = end, straight
            span *= 2
        i = far
        out[count] = points[i]
        count += 1
    return count


@kernel()
def bend(points: Any, c: Any, step: float, half: int, least: float, out: Any) -> float:
    """Move every inner point sideways so that the whole path costs least, all at once.

    Each point may go to 2 half + 1 places on a line across the path; a dynamic programme over
    pairs of places of neighbouring points, no more than `half` places apart, finds the cheapest
    choice. Staying is one of them, so that the path never gets dearer.

    Args:
        points: The path (k, 2).
        c: Cost per cell (h, w), inf where blocked.
        step: Distance between places [cells].
        half: Places on either side.
        least: Cost per cell that no cell undercuts.
        out: The new path (k, 2).

    Returns:
        Its cost.
    """
    n, places = points.shape[0], 2 * half + 1
    total, following = np.full(places, np.inf), np.empty(places)
    came = np.zeros((n, places), np.int8)
    total[half] = 0.0
    px, py, pnx, pny = points[0, 0], points[0, 1], 0.0, 0.0
    for k in range(1, n):
        nx, ny = across(points, k, step)
        following[:] = np.inf
        guess = half
        for b in range(places):
            if b != half and nx == 0.0 and ny == 0.0:
                continue
            qx, qy = points[k, 0] + (b - half) * nx, points[k, 1] + (b - half) * ny
            first, last = max(b - half, 0), min(b + half, places - 1)
            for turn in range(-1, last - first + 1):  # the likeliest place first: it rules out most
                a = first + turn if turn >= 0 else min(max(guess, first), last)
                sx, sy = px + (a - half) * pnx, py + (a - half) * pny
                if total[a] + least * np.hypot(qx - sx, qy - sy) < following[b]:
                    cost = total[a] + piece(sx, sy, qx, qy, c)
                    if cost < following[b]:
                        following[b] = cost
                        came[k, b] = a
            guess = came[k, b]
        total[:] = following
        px, py, pnx, pny = points[k, 0], points[k, 1], nx, ny
    b = half
    for back in range(n):
        k = n - 1 - back
        nx, ny = across(points, k, step)
        out[k, 0] = points[k, 0] + (b - half) * nx
        out[k, 1] = points[k, 1] + (b - half) * ny
        b = came[k, b]
    return total[half]
