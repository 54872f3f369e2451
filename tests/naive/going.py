"""Directed costs and ways, plainly: crossings sorted, every edge relaxed until nothing changes."""

from __future__ import annotations

import itertools
import math

import numpy as np

from rovernav.plan import Going
from rovernav.rover import drive_cost


def rate(ground: Going, i: int, j: int, heading: float) -> float:
    """Cost of a metre in one cell in one direction."""
    if ground.blocked[i, j]:
        return math.inf
    layers = ground.hazards.layers
    p, q = float(layers["east"].values[i, j]), float(layers["north"].values[i, j])
    mobility = ground.rover.mobility
    assert ground.table is not None
    assert mobility is not None
    cost = drive_cost(p, q, heading, ground.table)
    if not cost.allowed:
        return math.inf
    if ground.objective == "distance":
        return 1.0
    if ground.objective == "time":
        return float(cost.time)
    if ground.objective == "energy":
        return float(cost.energy)
    steep = (p * p + q * q) / math.tan(ground.rover.max_slope) ** 2
    slip = float(cost.slip) / mobility.max_slip
    unsure = 0.0 if int(cost.code) < 8 else 1.0
    return 1.0 + 4.0 * float(ground.near[i, j]) + 2.0 * steep + 2.0 * slip**2 + unsure


def touches(i: int, j: int, a: tuple[float, float], b: tuple[float, float]) -> bool:
    """Whether a piece touches the closed cell (i, j), by clipping."""
    t0, t1 = 0.0, 1.0
    for start, end, low in ((a[0], b[0], j), (a[1], b[1], i)):
        step = end - start
        if abs(step) < 1e-12:
            if not low - 1e-9 <= start <= low + 1 + 1e-9:
                return False
            continue
        enter, leave = sorted(((low - start) / step, (low + 1 - start) / step))
        t0, t1 = max(t0, enter), min(t1, leave)
    return t0 <= t1 + 1e-9


def piece(ground: Going, a: tuple[float, float], b: tuple[float, float]) -> float:
    """Cost of a straight piece between points in cells, in units per metre times cells."""
    h, w = ground.frame.shape
    heading, length = math.atan2(b[1] - a[1], b[0] - a[0]), math.dist(a, b)
    for i in range(h):
        for j in range(w):
            if ground.blocked[i, j] and touches(i, j, a, b):
                return math.inf
    times = [0.0, 1.0]
    for start, end in zip(a, b, strict=True):
        if start != end:
            lines = range(math.ceil(min(start, end)), math.floor(max(start, end)) + 1)
            times += [(line - start) / (end - start) for line in lines]
    times = sorted(t for t in times if 0.0 <= t <= 1.0)
    total = 0.0
    for t0, t1 in itertools.pairwise(times):
        if t1 - t0 > 1e-12:
            middle = 0.5 * (t0 + t1)
            x, y = (s + middle * (e - s) for s, e in zip(a, b, strict=True))
            total += (t1 - t0) * length * rate(ground, int(y), int(x), heading)
    return total


def costs_from(ground: Going, start: tuple[int, int], reach: int) -> np.ndarray:
    """From the middle of a cell to those of all others, over moves up to `reach` cells (h, w)."""
    h, w = ground.frame.shape
    moves = [
        (i, j)
        for i in range(-reach, reach + 1)
        for j in range(-reach, reach + 1)
        if math.gcd(i, j) == 1
    ]
    edges = []
    for i in range(h):
        for j in range(w):
            for di, dj in moves:
                if 0 <= i + di < h and 0 <= j + dj < w:
                    cost = piece(ground, (j + 0.5, i + 0.5), (j + dj + 0.5, i + di + 0.5))
                    if cost < math.inf:
                        edges.append((i, j, i + di, j + dj, cost))
    best = np.full((h, w), np.inf)
    best[start] = 0.0
    changed = True
    while changed:
        changed = False
        for i, j, k, m, cost in edges:
            if best[i, j] + cost < best[k, m]:
                best[k, m], changed = best[i, j] + cost, True
    return best * ground.frame.cell
