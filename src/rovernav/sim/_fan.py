"""A fan of range beams: an idealised sensor, exact and without noise."""

from __future__ import annotations

import math
from typing import final

import numpy as np

from ..core import F64, Mission, RoverState, SettingError
from ..kernels import rays as kernels
from ._tables import cones_of
from ._world import Worlds


@final
class RangeFan:
    """Distance to the nearest obstacle or ground that cannot be stood on, beam by beam.

    Idealised: exact, without noise, and it tells ground that is too steep from ground that is not
    as if it were a wall. Beams spread evenly from right to left. What touches a beam, corners
    included, ends it; over a grid a table of free distances is made once it pays, which changes no
    bit (decision 0018).

    Args:
        reach: Longest distance it sees [m]; such a reading met nothing.
        beams: How many.
        view: Angle between the outermost beams [rad].
    """

    name = "beams"

    def __init__(self, *, reach: float, beams: int = 49, view: float = math.pi) -> None:
        if not (math.isfinite(reach) and reach > 0):
            raise SettingError(f"a fan must reach farther than 0 m, got {reach!r}")
        if not 3 <= beams <= 4096:
            raise SettingError(f"a fan has 3 to 4096 beams, got {beams!r}")
        if not 0 < view <= 2 * math.pi:
            raise SettingError(f"a fan spans more than 0 and at most 360 deg, got {view!r} rad")
        self.reach = float(reach)
        self.angles: F64 = np.linspace(-view / 2, view / 2, beams)
        self._ways = np.stack([np.cos(self.angles), np.sin(self.angles)])

    def points(self, poses: F64, readings: F64) -> F64:
        """Where the beams of one rover met something: local points (m, 2) [m].

        Args:
            poses: Poses (t, 3) at which it looked.
            readings: What it read there (t, beams) [m].
        """
        a = poses[:, 2:3] + self.angles
        x = poses[:, :1] + readings * np.cos(a)
        y = poses[:, 1:2] + readings * np.sin(a)
        met = readings < self.reach
        return np.stack([x[met], y[met]], axis=1)

    def start(self, mission: Mission, rng: np.random.Generator) -> None:
        """Nothing to remember."""
        return

    def read(self, world: Worlds, state: RoverState, memory: None) -> tuple[F64, None]:
        """Distances (n, beams) [m], at most `reach`."""
        out = np.empty((len(state.pose), len(self.angles)))
        cones = cones_of(world.grid, beams=out.size)
        kernels.range_fan(state.pose, self._ways, self.reach, world.arrays(), cones, out)
        return out, None
