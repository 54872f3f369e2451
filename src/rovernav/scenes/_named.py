"""Scenes by name: the paper's, and generated ground."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from ..core import SettingError, suggest
from ..rover import read_rover, standing
from ..sim import Grid
from ..terrain import Terrain, hills, scatter_rocks, with_rocks
from ._bassil import Scene, bassil_scene
from ._ground import Ground, fenced, ground_scene
from ._practice import free_pairs


def named_scene(name: str, *, seed: int = 0) -> Scene | Ground:
    """The scene of that name.

    Args:
        name: See `scene_names`.
        seed: Seed of generated ground; the paper's scenes do not use it.

    Raises:
        SettingError: No scene has that name.
    """
    if name not in _SCENES:
        raise SettingError(f"unknown scenario {name!r}; {suggest(name, _SCENES)}")
    return _SCENES[name](seed)


def scene_names() -> list[str]:
    """Names of all scenes."""
    return sorted(_SCENES)


def hills_scene(seed: int) -> Ground:
    """``hills-v1``: 60 m of generated hills and craters, crossed by the paper's rover.

    Start and goal are the free places nearest to the south-west and the north-east corner, a tenth
    of the way in.
    """
    terrain = hills(np.random.default_rng(seed), shape=(300, 300), cell=0.2, relief=6.0, craters=60)
    rover = read_rover("paper-point")
    start, goal = _ends(terrain, standing(terrain, rover).blocked)
    return ground_scene(terrain, rover, start, goal)


def rocky_hills_scene(seed: int) -> Ground:
    """``rocky-hills-v1``: 50 m of generated hills, craters and rocks for the research rover.

    Rocks cover 5 % of the ground (Golombek and Rapp 1997), 0.2 to 2 m large. Start and goal are
    free and connected, at least 30 m apart, and their straight line is blocked.
    """
    rng = np.random.default_rng([seed, 5])
    terrain = hills(rng, shape=(400, 400), cell=0.125, relief=4.0, craters=40)
    rocks = scatter_rocks(terrain.frame, 0.05, smallest=0.2, largest=2.0, rng=rng)
    terrain = with_rocks(terrain, rocks)
    rover = read_rover("research")
    grid = Grid(frame=terrain.frame, blocked=fenced(standing(terrain, rover).blocked))
    starts, goals = free_pairs(grid, 1, rng, nearest=30.0, farthest=60.0)
    return ground_scene(terrain, rover, tuple(starts[0].tolist()), tuple(goals[0].tolist()))


def _variant(name: str, obstacle: str) -> Scene:
    return dataclasses.replace(bassil_scene("bassil-v1", obstacle=obstacle), name=name)


def _ends(terrain: Terrain, blocked: np.ndarray) -> tuple[tuple[float, float], tuple[float, float]]:
    """The free cells nearest to the corners a tenth of the way in from two opposite corners."""
    h, w = blocked.shape
    rows, columns = np.nonzero(blocked == 0)
    ends: list[tuple[float, float]] = []
    for row, column in ((0.1 * h, 0.1 * w), (0.9 * h, 0.9 * w)):
        nearest = int(np.argmin((rows - row) ** 2 + (columns - column) ** 2))
        ends.append(terrain.frame.centre_of(int(rows[nearest]), int(columns[nearest])))
    return ends[0], ends[1]


_SCENES: dict[str, Callable[[int], Scene | Ground]] = {
    "bassil-v1": lambda seed: bassil_scene("bassil-v1"),
    "bassil-replay-v1": lambda seed: bassil_scene("bassil-replay-v1"),
    "bassil-mirrored-v1": lambda seed: _variant("bassil-mirrored-v1", "mirrored"),
    "bassil-free-v1": lambda seed: _variant("bassil-free-v1", "none"),
    "hills-v1": hills_scene,
    "rocky-hills-v1": rocky_hills_scene,
}
