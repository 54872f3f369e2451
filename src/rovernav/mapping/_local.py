"""The local map: what the range beams met, kept in a square that rolls along with the rover."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, final

import numpy as np

from ..core import F64, I64, U8, Mission, SettingError, value
from ..kernels import fan as kernels


@value
class LocalMap:
    """What n rovers remember around them.

    Attributes:
        cells: 1 where something was met (n, s, s), uint8; world cell (i, j) is at i and j modulo s.
        centre: The cell of each rover (n, 2): row, column.
        pose: Where each rover thinks it is (n, 3) [m, m, rad].
        goal: Where it wants to go (n, 2) [m].
        cell: Side of a cell [m].
        ground: The heights that it was made from, an `Elevation`; None without heights.
    """

    cells: U8
    centre: I64
    pose: F64
    goal: F64
    cell: float
    ground: Any = None

    def asked(self, rays: int) -> dict[str, F64]:
        """How far it is free all round.

        Returns:
            ``around``: free distance (n, rays) [m], ray 0 towards the goal, the others following to
            the left; ``reach`` (n, 1), the longest such distance [m].
        """
        out = np.empty((len(self.pose), rays))
        kernels.around(
            self.cells, self.centre, self.pose, bearing(self.pose, self.goal), self.cell, out
        )
        extent = self.cell * (self.cells.shape[1] // 2 - 1)
        return {"around": out, "reach": np.full((len(self.pose), 1), extent)}


@final
class LocalMapper:
    """Keeps where beams ended, and says how far it is free all round.

    The pose is taken as known: dead reckoning without drift. What was never sensed is free.

    Args:
        angles: Directions of the fan's beams in the rover's frame (b,) [rad].
        reach: The fan's reach [m].
        rays: Directions in which the map is asked.
        side: Cells along the map's side, a power of two.
        memory: How far the map reaches, as a multiple of the fan's reach.
    """

    def __init__(
        self,
        angles: F64,
        *,
        reach: float,
        rays: int = 64,
        side: int = 128,
        memory: float = 2.0,
    ) -> None:
        if side < 8 or side & (side - 1):
            raise SettingError(f"a local map needs a side of 8, 16, 32, ... cells, got {side!r}")
        self.angles, self.reach = angles, float(reach)
        self.rays, self.side = int(rays), int(side)
        self.extent = self.reach * float(memory)
        self.cell = self.extent / (side // 2 - 1)

    def start(self, mission: Mission) -> LocalMap:
        """An empty map around each start."""
        n = len(mission.start)
        cells = np.zeros((n, self.side, self.side), np.uint8)
        at = np.floor(mission.start[:, [1, 0]] / self.cell).astype(np.int64)
        return LocalMap(
            cells=cells, centre=at, pose=mission.start, goal=mission.goal, cell=self.cell
        )

    def update(
        self, memory: LocalMap, pose: F64, goal: F64, channels: Mapping[str, F64]
    ) -> tuple[dict[str, F64], LocalMap]:
        """Take in a scan and ask the map.

        Args:
            memory: The map so far.
            pose: Poses (n, 3).
            goal: Goals (n, 2) [m].
            channels: Must hold ``beams`` (n, b) [m].

        Returns:
            ``around``: free distance (n, rays) [m], ray 0 towards the goal, the others following to
            the left; ``reach`` (n, 1), the longest such distance [m]; and the map.
        """
        cells, centre = memory.cells.copy(), memory.centre.copy()
        kernels.roll(cells, centre, pose, self.cell)
        kernels.mark(
            cells, centre, pose, self.angles, channels["beams"], self.reach, self.cell,
            4.0 * self.cell,
        )  # fmt: skip
        now = LocalMap(cells=cells, centre=centre, pose=pose, goal=goal, cell=self.cell)
        return {**now.asked(self.rays), "reach": np.full((len(pose), 1), self.extent)}, now


def bearing(pose: F64, goal: F64) -> F64:
    """World direction from each rover to its goal (n,) [rad]."""
    out = np.empty(len(pose))
    kernels.bearing(pose, goal, out)
    return out
