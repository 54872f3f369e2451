"""The local map as a Python set of world cells; slow, and nothing rolls."""

from __future__ import annotations

import math


def marks(
    pose: tuple[float, float, float],
    angles: list[float],
    ranges: list[float],
    *,
    reach: float,
    cell: float,
    join: float,
) -> set[tuple[int, int]]:
    """World cells (row, column) that one scan marks."""
    found: set[tuple[int, int]] = set()
    last: tuple[float, float] | None = None
    for angle, distance in zip(angles, ranges, strict=True):
        if distance >= reach:
            last = None
            continue
        a, r = pose[2] + angle, distance + 0.01 * cell
        here = (pose[0] + r * math.cos(a), pose[1] + r * math.sin(a))
        points = [here]
        if last is not None and math.hypot(here[0] - last[0], here[1] - last[1]) <= join:
            gap = math.hypot(here[0] - last[0], here[1] - last[1])
            parts = int(2.0 * gap / cell) + 1
            points = [
                (
                    here[0] + k / parts * (last[0] - here[0]),
                    here[1] + k / parts * (last[1] - here[1]),
                )
                for k in range(parts)
            ]
        found |= {(math.floor(y / cell), math.floor(x / cell)) for x, y in points}
        last = here
    return found


def near(cells: set[tuple[int, int]], centre: tuple[int, int], side: int) -> set[tuple[int, int]]:
    """The cells that a map of `side` cells around `centre` can hold."""
    half = side // 2
    return {
        (i, j) for i, j in cells if -half <= i - centre[0] < half and -half <= j - centre[1] < half
    }
