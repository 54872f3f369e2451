"""A path drawn tight where going costs by direction: points left out, points moved sideways.

As in `tracing`, under the cost function of `going`; the path keeps its direction. Coordinates are
in cells, x along the columns and y along the rows.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ._jit import kernel
from .going import Going, piece
from .polyline import across


@kernel()
def tighten(points: Any, g: Going, ahead: int, room: tuple[Any, Any], out: Any) -> int:
    """Leave out points without which the path costs no more.

    Args:
        points: The path (k, 2).
        g: The ground.
        ahead: Points that one piece may replace.
        room: Cells and lengths for `going.walk`.
        out: Room for the path (k, 2).

    Returns:
        Number of points kept; the first and the last are.
    """
    cells, within = room
    n = points.shape[0]
    costs = np.empty(max(n - 1, 1))
    for k in range(n - 1):
        a, b = (points[k, 0], points[k, 1]), (points[k + 1, 0], points[k + 1, 1])
        costs[k] = piece(a, b, g, cells, within)
    out[0] = points[0]
    count, i = 1, 0
    while i < n - 1:
        far, total = i + 1, costs[i]
        for end in range(i + 2, min(i + ahead, n - 1) + 1):
            total += costs[end - 1]
            a, b = (points[i, 0], points[i, 1]), (points[end, 0], points[end, 1])
            if piece(a, b, g, cells, within) <= total:
                far = end
            elif end > far + 8:
                break
        i = far
        out[count] = points[i]
        count += 1
    return count


@kernel()
def bend(
    points: Any, g: Going, step: float, half: int, least: float, room: tuple[Any, Any], out: Any
) -> float:
    """Move every inner point sideways so that the whole path costs least, all at once.

    Each point may go to 2 half + 1 places on a line across the path; a dynamic programme over
    pairs of places of neighbouring points, no more than `half` places apart, finds the cheapest
    choice. Staying is one of them, so that the path never gets dearer.

    Args:
        points: The path (k, 2).
        g: The ground.
        step: Distance between places [cells].
        half: Places on either side.
        least: Cost per cell that no cell undercuts.
        room: Cells and lengths for `going.walk`.
        out: The new path (k, 2).

    Returns:
        Its cost.
    """
    cells, within = room
    n, places = points.shape[0], 2 * half + 1
    total, following = np.full(places, np.inf), np.empty(places)
    came = np.zeros((n, places), np.int8)
    total[half] = 0.0
    for k in range(1, n):
        pnx, pny = across(points, k - 1, step)
        nx, ny = across(points, k, step)
        following[:] = np.inf
        for b in range(places):
            if b != half and nx == 0.0 and ny == 0.0:
                continue
            to = (points[k, 0] + (b - half) * nx, points[k, 1] + (b - half) * ny)
            for a in range(max(b - half, 0), min(b + half, places - 1) + 1):
                x, y = points[k - 1, 0] + (a - half) * pnx, points[k - 1, 1] + (a - half) * pny
                if total[a] + least * np.hypot(to[0] - x, to[1] - y) < following[b]:
                    cost = total[a] + piece((x, y), to, g, cells, within)
                    if cost < following[b]:
                        following[b] = cost
                        came[k, b] = a
        total[:] = following
    b = half
    for back in range(n):
        k = n - 1 - back
        nx, ny = across(points, k, step)
        out[k, 0] = points[k, 0] + (b - half) * nx
        out[k, 1] = points[k, 1] + (b - half) * ny
        b = came[k, b]
    return total[half]
