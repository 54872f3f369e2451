"""The maps, the two ends, and the one judge of all paths."""

from __future__ import annotations

import math
import os
import resource
from collections.abc import Callable
from typing import Any

import numpy as np
from harness.model import Result, Stopwatch, Trial

SEED = 1
MARGIN = 20
"""The ends lie this many cells from two opposite corners, or in the free cell nearest to that."""
DEAR = 1e9
"""What a forbidden cell costs for peers that know no forbidden cells."""

BEST = {
    ("fractal", 4096): 8000.262802,
    ("fractal", 512): 967.889764,
    ("maze", 4096): 7026.810351,
    ("maze", 512): 912.196567,
}
"""Cost of the best path that anybody here has found, by map and size."""

Path = Any
"""Points (k, 2): column and row [cells], the middle of cell (0, 0) at (0.5, 0.5)."""


def fractal(n: int) -> Any:
    """A cost of 1 + slope^2 on self-affine ground (Hurst exponent 0.8), steep places forbidden."""
    rng = np.random.default_rng(SEED)
    waves = np.fft.rfft2(rng.standard_normal((n, n)))
    k = np.hypot(np.fft.fftfreq(n)[:, None], np.fft.rfftfreq(n)[None])
    k[0, 0] = 1.0
    waves *= k**-1.8
    waves[0, 0] = 0.0
    q, p = np.gradient(np.fft.irfft2(waves, s=(n, n)))
    slope = np.hypot(p, q)
    slope /= np.sqrt((slope**2).mean())
    return np.where(slope > 2.2, np.inf, 1.0 + slope**2).astype(np.float32)


def maze(n: int) -> Any:
    """Corridors 56 cells wide between walls 8 cells thick, some with a second way around."""
    rng = np.random.default_rng(SEED)
    cell, half = 64, 4
    m = n // cell
    cost = np.full((n, n), np.inf, np.float32)
    seen = np.zeros((m, m), bool)
    seen[0, 0] = True

    def dig(a: Any, b: Any) -> None:
        rows, columns = sorted((a[0], b[0])), sorted((a[1], b[1]))
        cost[
            rows[0] * cell + half : (rows[1] + 1) * cell - half,
            columns[0] * cell + half : (columns[1] + 1) * cell - half,
        ] = 1.0

    stack = [(0, 0)]
    while stack:
        i, j = stack[-1]
        near = [(i + a, j + b) for a, b in ((0, 1), (1, 0), (0, -1), (-1, 0))]
        near = [c for c in near if min(c) >= 0 and max(c) < m and not seen[c]]
        if not near:
            stack.pop()
            continue
        chosen = near[rng.integers(len(near))]
        seen[chosen] = True
        dig((i, j), chosen)
        stack.append(chosen)
    for _ in range(m * m // 4):
        i, j = rng.integers(m - 1, size=2)
        dig((i, j), (i + 1, j) if rng.random() < 0.5 else (i, j + 1))
    return cost


MAPS = {"fractal": fractal, "maze": maze}


def ends(cost: Any) -> tuple[tuple[int, int], tuple[int, int]]:
    """Row and column of start and goal."""
    n, free = len(cost), np.argwhere(np.isfinite(cost))
    found = [free[np.abs(free - at).sum(1).argmin()] for at in (MARGIN, n - MARGIN)]
    return tuple(map(int, found[0])), tuple(map(int, found[1]))  # type: ignore[return-value]


def middles(cells: Any) -> Path:
    """Points in the middles of cells (k, 2), row and column."""
    return np.asarray(cells)[:, ::-1] + 0.5


def dear(cost: Any, least: float = 1.0) -> Any:
    """Costs that are finite everywhere, at least `least`."""
    return np.maximum(np.where(np.isfinite(cost), cost, DEAR), least)


def judge(cost: Any, path: Path) -> tuple[float, int]:
    """What a path costs, the line integral along it, and how many forbidden corners it passes.

    rovernav calls passing such a corner forbidden; here it only counts, so that peers which cannot
    be told to keep off can be compared.
    """
    from rovernav.plan import CostMap

    pieces = CostMap.of(cost).pieces(path)
    a, b = (np.asarray(path)[k:][: len(pieces)] for k in (0, 1))
    step = np.abs(b - a)
    passes = np.isinf(pieces) & (step == 1.0).all(axis=1) & (a % 1.0 == 0.5).all(axis=1)
    for k in np.flatnonzero(passes):
        both = [cost[int(y), int(x)] for x, y in (a[k], b[k])]
        pieces[k] = math.sqrt(0.5) * sum(map(float, both))
    return float(pieces.sum()), int(passes.sum())


def one_route(
    name: str, prepare: Callable[[Any, Any, Any], Callable[[], Path]]
) -> Callable[[int], Trial]:
    """A peer: `prepare(cost, start, goal)` gives a function whose call is timed.

    The check is the cost of the path over the best known; the note tells the memory that the
    process needed at most on top of what it had when everything was ready.
    """

    def build(size: int) -> Trial:
        cost = MAPS[name](size)
        start, goal = ends(cost)
        plan = prepare(cost, start, goal)

        def trial(repeats: int) -> Result:
            watch, before, path = Stopwatch(), memory(), None
            forget_peak()
            with watch:
                for _ in range(repeats):
                    path = plan()
            extra = max(0.0, peak() - before)
            price, corners = judge(cost, path)
            note = f"{extra:.0f} MB extra, {extra * 1e6 / size**2:.1f} bytes per cell"
            note += f"; passes {corners} forbidden corners" if corners else ""
            relative = round(price / BEST[name, size], 4)
            return watch.result(repeats, relative)._replace(note=note)

        return trial

    return build


def memory() -> float:
    """Resident memory [MB]."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def forget_peak() -> None:
    """Count the peak anew, where the system allows it."""
    try:
        with open("/proc/self/clear_refs", "w") as file:
            file.write("5")
    except OSError:
        pass


def peak() -> float:
    """Largest resident memory so far [MB]."""
    try:
        with open("/proc/self/status") as file:
            line = next(line for line in file if line.startswith("VmHWM"))
        return int(line.split()[1]) * 1024 / 1e6
    except (OSError, StopIteration):
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6
