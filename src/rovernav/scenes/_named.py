"""Scenes by name: the paper's, and generated ground."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..core import SettingError, suggest
from ..rover import read_rover, standing
from ..terrain import Terrain, hills
from ._bassil import Scene, bassil_scene
from ._ground import Ground, ground_scene


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


def _ends(
    terrain: Terrain, blocked: np.ndarray
) -> tuple[tuple[float, float], tuple[float, float]]:
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
    "bassil-mirrored-v1": lambda seed: bassil_scene("bassil-v1", obstacle="mirrored"),
    "bassil-free-v1": lambda seed: bassil_scene("bassil-v1", obstacle="none"),
    "hills-v1": hills_scene,
}
