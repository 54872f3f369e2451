"""Peers that go from cell to cell: skimage, pyastar2d, scipy, dijkstra3d, networkx, xarray-spatial.

Some pass the corners of forbidden cells, which the judge forbids; each is told to keep off them
where it can be told. pyastar2d charges diagonal steps like straight ones.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from harness.model import Skipped

from . import task

SQRT2 = math.sqrt(2.0)


def skimage(cost: Any, start: Any, goal: Any) -> Callable[[], Any]:
    """`MCP_Geometric`, whose steps cost their length times the mean of both cells."""
    from skimage.graph import MCP_Geometric

    known = np.where(np.isfinite(cost), cost, -1.0)

    def plan() -> Any:
        search = MCP_Geometric(known)
        search.find_costs([start], [goal])
        return task.middles(search.traceback(goal))

    return plan


def pyastar2d(cost: Any, start: Any, goal: Any) -> Callable[[], Any]:
    """A* in C++ over float32 weights."""
    import pyastar2d as astar

    weights = np.where(np.isfinite(cost), cost, np.inf).astype(np.float32)
    return lambda: task.middles(astar.astar_path(weights, start, goal, allow_diagonal=True))


def dijkstra3d(cost: Any, start: Any, goal: Any) -> Callable[[], Any]:
    """Dijkstra's algorithm in C++ over the eight neighbours of a field of weights."""
    import dijkstra3d as d3

    field = np.asfortranarray(task.dear(cost), np.float32)[:, :, None]

    def plan() -> Any:
        path = d3.dijkstra(field, (*start, 0), (*goal, 0), connectivity=26)
        return task.middles(path[:, :2].astype(int))

    return plan


def scipy(cost: Any, start: Any, goal: Any) -> Callable[[], Any]:
    """`csgraph.dijkstra` on a sparse graph of all free cells; building the graph is timed too."""
    from scipy.sparse import csgraph

    w = cost.shape[1]

    def plan() -> Any:
        graph = _graph(cost)
        source, target = start[0] * w + start[1], goal[0] * w + goal[1]
        _, before = csgraph.dijkstra(graph, indices=source, return_predecessors=True)
        cells = [target]
        while cells[-1] != source:
            cells.append(before[cells[-1]])
        return task.middles(np.column_stack(np.divmod(cells[::-1], w)))

    return plan


def _graph(cost: Any) -> Any:
    """Every allowed step and what it costs."""
    from scipy import sparse

    h, w = cost.shape
    ids = np.arange(h * w, dtype=np.int32).reshape(h, w)
    rows, columns, steps = [], [], []
    for di, dj in ((0, 1), (1, 0), (1, 1), (1, -1)):
        a = (slice(0, h - di), slice(max(0, -dj), w - max(0, dj)))
        b = (slice(di, h), slice(max(0, dj), w - max(0, -dj)))
        step = 0.5 * math.hypot(di, dj) * (cost[a] + cost[b])
        if di and dj:
            beside = (slice(0, h - di), b[1]), (slice(di, h), a[1])
            step = np.where(np.isfinite(cost[beside[0]] + cost[beside[1]]), step, np.inf)
        good = np.isfinite(step)
        rows += [ids[a][good], ids[b][good]]
        columns += [ids[b][good], ids[a][good]]
        steps += [step[good]] * 2
    parts = (np.concatenate(part) for part in (steps, rows, columns))
    values, row, column = parts
    return sparse.csr_array((values, (row, column)), shape=(h * w, h * w))


def networkx(cost: Any, start: Any, goal: Any) -> Callable[[], Any]:
    """A* on a graph of Python objects; the graph is ready before the clock starts."""
    import networkx as nx

    h, w = cost.shape
    if h > 1024:
        raise Skipped("its graph of Python objects would need some 30 GB")
    graph = nx.Graph()
    for i, j in map(tuple, np.argwhere(np.isfinite(cost))):
        for di, dj in ((0, 1), (1, 0), (1, 1), (1, -1)):
            a, b = i + di, j + dj
            if not (a < h and 0 <= b < w) or not np.isfinite(cost[a, b]):
                continue
            if di and dj and not (np.isfinite(cost[a, j]) and np.isfinite(cost[i, b])):
                continue
            step = 0.5 * math.hypot(di, dj) * float(cost[i, j] + cost[a, b])
            graph.add_edge((i, j), (a, b), weight=step)

    def bound(a: Any, b: Any) -> float:
        di, dj = abs(a[0] - b[0]), abs(a[1] - b[1])
        return max(di, dj) + (SQRT2 - 1.0) * min(di, dj)

    return lambda: task.middles(nx.astar_path(graph, start, goal, bound))


def xarray_spatial(cost: Any, start: Any, goal: Any) -> Callable[[], Any]:
    """`a_star_search`, where its release takes a field of frictions."""
    import inspect

    import xarray
    from xrspatial import a_star_search

    h, w = cost.shape
    y, x = np.arange(h, dtype=float), np.arange(w, dtype=float)
    ground = xarray.DataArray(
        np.where(np.isfinite(cost), 1.0, np.nan), coords={"y": y, "x": x}, dims=("y", "x")
    )
    if "friction" not in inspect.signature(a_star_search).parameters:
        raise Skipped("this release knows no cost per cell, and needs minutes at this size")
    friction = ground.copy(data=np.where(np.isfinite(cost), cost, np.nan).astype(float))

    def plan() -> Any:
        steps = np.asarray(a_star_search(ground, start, goal, friction=friction))
        cells = np.argwhere(np.isfinite(steps))
        return task.middles(cells[np.argsort(steps[tuple(cells.T)])])

    return plan
