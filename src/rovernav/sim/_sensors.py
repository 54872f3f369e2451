"""The paper's two sensors. Each reads one channel of 0 or 1."""

from __future__ import annotations

from typing import final

import numpy as np

from ..core import F64, Mission, RoverState, SettingError
from ..kernels import drive as kernels
from ._world import Worlds


@final
class ClearSight:
    """x of the paper: 1 when the straight segment from the rover to its goal meets nothing.

    An idealised sensor: it sees as far as the goal, without error. What it looks for are the
    world's obstacles and the ground on which the rover cannot stand.
    """

    name = "clear_sight"

    def start(self, mission: Mission, rng: np.random.Generator) -> Mission:
        """Remembers the mission; draws nothing."""
        return mission

    def read(self, world: Worlds, state: RoverState, memory: Mission) -> tuple[F64, Mission]:
        """1 or 0 for each rover (n, 1)."""
        out = np.empty((len(state.pose), 1))
        kernels.clear_sight(state.pose, memory.goal, world.arrays(), out)
        return out, memory


@final
class OffLine:
    """y of the paper: 1 when the rover is more than `threshold` off the line start-goal.

    Args:
        threshold: Distance [m]; half a step in the paper's scenarios.
    """

    name = "off_line"

    def __init__(self, threshold: float) -> None:
        if not (np.isfinite(threshold) and threshold >= 0):
            raise SettingError(f"the threshold must be 0 m or more, got {threshold!r}")
        self.threshold = float(threshold)

    def start(self, mission: Mission, rng: np.random.Generator) -> Mission:
        """Remembers the mission; draws nothing."""
        return mission

    def read(self, world: Worlds, state: RoverState, memory: Mission) -> tuple[F64, Mission]:
        """1 or 0 for each rover (n, 1)."""
        out = np.empty((len(state.pose), 1))
        kernels.off_line(state.pose, memory.start, memory.goal, self.threshold, out)
        return out, memory
