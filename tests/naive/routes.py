"""Ways over grids, cell by cell and in plain Python; slow."""

from __future__ import annotations

import heapq
import itertools
import math

import numpy as np

Cell = tuple[int, int]


def neighbours(cost: np.ndarray, cell: Cell, *, corners: bool) -> list[tuple[float, Cell]]:
    """Cost of a step to each neighbour that may be entered."""
    i, j = cell
    h, w = cost.shape
    found: list[tuple[float, Cell]] = []
    for di, dj in itertools.product((-1, 0, 1), repeat=2):
        a, b = i + di, j + dj
        if (di, dj) == (0, 0) or not (0 <= a < h and 0 <= b < w) or np.isinf(cost[a, b]):
            continue
        beside = np.isinf(cost[a, j]) or np.isinf(cost[i, b])
        if di and dj and beside and not corners:
            continue
        found.append((math.hypot(di, dj) * (float(cost[i, j]) + float(cost[a, b])) / 2, (a, b)))
    return found


def dijkstra(cost: np.ndarray, start: Cell, *, corners: bool = False) -> np.ndarray:
    """Cost of the cheapest way from a cell to every other, with a heap."""
    far = np.full(cost.shape, np.inf)
    far[start] = 0.0
    heap = [(0.0, start)]
    while heap:
        here, cell = heapq.heappop(heap)
        if here > far[cell]:
            continue
        for step, other in neighbours(cost, cell, corners=corners):
            if here + step < far[other]:
                far[other] = here + step
                heapq.heappush(heap, (here + step, other))
    return far


def share_inside(a: np.ndarray, b: np.ndarray, row: int, column: int) -> tuple[float, bool]:
    """Share of the segment a-b within a closed unit cell, and whether they touch at all."""
    begin, end = 0.0, 1.0
    for start, delta, low in ((a[0], b[0] - a[0], column), (a[1], b[1] - a[1], row)):
        if delta == 0.0:
            if not low <= start <= low + 1:
                return 0.0, False
            continue
        near, far = sorted(((low - start) / delta, (low + 1 - start) / delta))
        begin, end = max(begin, near), min(end, far)
    return max(end - begin, 0.0), begin <= end


def line_cost(a: np.ndarray, b: np.ndarray, cost: np.ndarray) -> float:
    """Line integral of the cost along a segment in general position: every cell is asked."""
    total = 0.0
    for (row, column), here in np.ndenumerate(cost):
        share, touches = share_inside(a, b, row, column)
        if touches and np.isinf(here):
            return math.inf
        total += share * float(here) if share else 0.0
    return total * math.dist(a, b)
