"""Worlds to practise in, and start and goal pairs to be tested on."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..core import F64, I64, U8, Bool, Frame, Mission, SettingError
from ..kernels import drive as kernels
from ..rover import Rover, standing
from ..sim import Grid, Worlds
from ..terrain import hills, scatter_rocks, with_rocks
from ._ground import fenced

MOST_BLOCKED = 0.4
"""Share of forbidden ground above which a world leaves no room for a task."""

MOST_CELLS = 2e7
"""Cells of worlds that are drawn before there is taken to be no task: small worlds are often full,
and whoever trains in them draws many."""


def practice_grid(rng: np.random.Generator, rover: Rover, *, side: float, cell: float) -> Grid:
    """A generated world to learn in: rocky hills, or shapes with bays and gaps.

    Args:
        rng: Where it comes from.
        rover: Whose limits say where it can stand.
        side: Side of the square world [m].
        cell: Cell [m].
    """
    cells = round(side / cell)
    if rng.random() < 0.4:
        return _rocky_hills(rng, rover, cells, cell)
    frame = Frame(cell=cell, shape=(cells, cells))
    return Grid(frame=frame, blocked=fenced(_shapes(rng, frame)))


def practice_task(
    rng: np.random.Generator,
    rover: Rover,
    *,
    side: float,
    cell: float,
    nearest: float,
    farthest: float,
) -> tuple[Grid, F64, F64]:
    """A world to learn in with one task in it: the same generator's state gives the same.

    Worlds without such a task, or with more than 40 % forbidden ground, are drawn again.

    Args:
        rng: Where it comes from.
        rover: Whose limits say where it can stand.
        side: Side of the square world [m].
        cell: Cell [m].
        nearest: Shortest straight line [m].
        farthest: Longest straight line [m].

    Returns:
        The world, the start (3,) with any heading, and the goal (2,), which can be reached, but not
        in a straight line.

    Raises:
        SettingError: None of a hundred to two thousand worlds had such a task, the more the fewer
            cells they have.
    """
    for _ in range(min(2000, max(100, round(MOST_CELLS * (cell / side) ** 2)))):
        grid = practice_grid(rng, rover, side=side, cell=cell)
        if grid.blocked.mean() > MOST_BLOCKED:
            continue
        try:
            return grid, *another_task(rng, grid, nearest=nearest, farthest=farthest)
        except SettingError:
            continue
    raise SettingError(
        f"worlds of {side:g} m have no tasks {nearest:g} to {farthest:g} m long; "
        "choose a larger world or shorter tasks"
    )


def another_task(
    rng: np.random.Generator, grid: Grid, *, nearest: float, farthest: float
) -> tuple[F64, F64]:
    """A start (3,) and a goal (2,) as of `practice_task`, in a world that is there already.

    Raises:
        SettingError: The world has none.
    """
    starts, goals = free_pairs(grid, 1, rng, nearest=nearest, farthest=farthest)
    return np.append(starts[0], rng.uniform(-math.pi, math.pi)), goals[0]


def _rocky_hills(rng: np.random.Generator, rover: Rover, cells: int, cell: float) -> Grid:
    terrain = hills(
        rng, shape=(cells, cells), cell=cell, relief=float(rng.uniform(2.0, 7.0)),
        hurst=float(rng.uniform(0.75, 0.95)), craters=int(rng.integers(5, 60)),
    )  # fmt: skip
    rocks = scatter_rocks(
        terrain.frame, float(rng.uniform(0.01, 0.12)), smallest=0.15, largest=2.0, rng=rng
    )
    return Grid(
        frame=terrain.frame, blocked=fenced(standing(with_rocks(terrain, rocks), rover).blocked)
    )


def _shapes(rng: np.random.Generator, frame: Frame) -> U8:
    """Discs, bars, and rings with an opening: what craters, rocks and ridges look like."""
    width, height = frame.extent
    y, x = np.meshgrid(
        (np.arange(frame.shape[0]) + 0.5) * frame.cell,
        (np.arange(frame.shape[1]) + 0.5) * frame.cell,
        indexing="ij",
    )
    blocked = np.zeros(frame.shape, bool)
    for _ in range(int(rng.integers(8, 40))):
        dx, dy = x - rng.uniform(0, width), y - rng.uniform(0, height)
        blocked |= _shape(rng, dx, dy)
    return blocked.astype(np.uint8)


def _shape(rng: np.random.Generator, dx: Any, dy: Any) -> Bool:
    kind = rng.random()
    if kind < 0.4:
        return np.hypot(dx, dy) < rng.uniform(0.3, 2.5)
    a = rng.uniform(-math.pi, math.pi)
    along, across = dx * math.cos(a) + dy * math.sin(a), dy * math.cos(a) - dx * math.sin(a)
    if kind < 0.65:
        return (np.abs(along) < rng.uniform(1.0, 6.0)) & (np.abs(across) < rng.uniform(0.2, 0.6))
    radius, opening = rng.uniform(1.5, 6.0), rng.uniform(0.0, 2.6)
    ring = np.abs(np.hypot(dx, dy) - radius) < rng.uniform(0.25, 0.9)
    return ring & (np.abs(np.arctan2(across, along)) > opening / 2.0)


def free_pairs(
    grid: Grid, count: int, rng: np.random.Generator, *, nearest: float, farthest: float
) -> tuple[F64, F64]:
    """Starts and goals that are free, connected, and whose straight line is blocked.

    Connected means: a way exists from cell to cell over shared edges.

    Args:
        grid: The ground.
        count: Pairs.
        rng: Where they come from.
        nearest: Shortest straight line [m].
        farthest: Longest straight line [m].

    Returns:
        Starts (count, 2) and goals (count, 2), cell centres [m].

    Raises:
        SettingError: So many pairs cannot be found.
    """
    from scipy.ndimage import label

    region = np.asarray(label(grid.blocked == 0)[0])  # pyright: ignore[reportIndexIssue]
    rows, columns = np.nonzero(region)
    starts: list[F64] = []
    goals: list[F64] = []
    for _ in range(200):
        if len(rows) < 2 or len(starts) >= count:
            break
        a, b = rng.integers(0, len(rows), (2, max(4 * count, 64)))
        p, q = (_centres(rows[i], columns[i], grid.frame.cell) for i in (a, b))
        far = np.hypot(*(q - p).T)
        good = (region[rows[a], columns[a]] == region[rows[b], columns[b]]) & (far >= nearest)
        good &= far <= farthest
        good[good] = _blocked(grid, p[good], q[good])
        starts += list(p[good])
        goals += list(q[good])
    if len(starts) < count:
        raise SettingError(
            f"found {len(starts)} of {count} start and goal pairs {nearest:g} to {farthest:g} m "
            f"apart with a blocked straight line; the ground may be too open or too closed"
        )
    return np.array(starts[:count]), np.array(goals[:count])


def _centres(rows: I64, columns: I64, cell: float) -> F64:
    """Centres (m, 2) of cells [m]."""
    return np.stack([columns + 0.5, rows + 0.5], axis=1).astype(np.float64) * cell


def pair_mission(starts: F64, goals: F64, *, goal_radius: float, pace: float) -> Mission:
    """Missions (n) between pairs, facing the goals, with five times the straight line's time."""
    heading = np.arctan2(goals[:, 1] - starts[:, 1], goals[:, 0] - starts[:, 0])
    farthest = float(np.hypot(*(goals - starts).T).max())
    return Mission(
        start=np.column_stack([starts, heading]),
        goal=goals,
        goal_radius=goal_radius,
        time_limit=max(60.0, 5.0 * farthest / pace),
    )


def _blocked(grid: Grid, starts: F64, goals: F64) -> Bool:
    """Which straight lines meet something."""
    out = np.empty((len(starts), 1))
    worlds = Worlds.single(grid=grid, rovers=len(starts))
    pose = np.column_stack([starts, np.zeros(len(starts))])
    kernels.clear_sight(pose, goals, worlds.arrays(), out)
    return out[:, 0] == 0.0
