"""A fan of range beams: an idealised sensor, exact and without noise."""

from __future__ import annotations

import math
from typing import final

import numpy as np

from ..core import F64, Mission, RoverState, SettingError
from ..kernels import rays as kernels
from ..kernels.obstacle_fan import obstacle_fan
from ..kernels.ridge_fan import Looks, ground_fan, looks_of
from ._seeing import seen
from ._tables import cones_of, tops_of
from ._world import Worlds


@final
class RangeFan:
    """Distance to the nearest obstacle or ground that cannot be stood on, beam by beam.

    Idealised: exact, without noise, and it tells ground that is too steep from ground that is not
    as if it were a wall. Beams spread evenly from right to left. What touches a beam, corners
    included, ends it; over a grid a table of free distances is made once it pays, which changes no
    bit (decision 0018).

    With a `height` it looks over the ground instead of through it: the beams lie in the body's own
    plane, pitched and rolled with it, and the ground ends them too, rocks on it. Obstacles without
    a height (boxes, discs, polygons, blocked cells) then count as higher than any beam.

    Args:
        reach: Longest distance it sees [m]; such a reading met nothing.
        beams: How many.
        view: Angle between the outermost beams [rad].
        height: Of the sensor over the ground under the rover's middle, along the body's own up
            [m]; None for a fan that lies level and knows no ground.
    """

    name = "beams"

    def __init__(
        self, *, reach: float, beams: int = 49, view: float = math.pi, height: float | None = None
    ) -> None:
        if not (math.isfinite(reach) and reach > 0):
            raise SettingError(f"a fan must reach farther than 0 m, got {reach!r}")
        if not 3 <= beams <= 4096:
            raise SettingError(f"a fan has 3 to 4096 beams, got {beams!r}")
        if not 0 < view <= 2 * math.pi:
            raise SettingError(f"a fan spans more than 0 and at most 360 deg, got {view!r} rad")
        if height is not None and not (math.isfinite(height) and height > 0):
            raise SettingError(f"a fan over the ground needs a height above 0 m, got {height!r}")
        self.reach, self.height = float(reach), None if height is None else float(height)
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
        if self.height is not None:
            self._over(world, state, self.height, cones, out)
            return out, None
        kernels.range_fan(state.pose, self._ways, self.reach, world.arrays(), cones, out)
        return out, None

    def _over(
        self, world: Worlds, state: RoverState, height: float, cones: kernels.ConeArrays, out: F64
    ) -> None:
        """Distances over the ground and among obstacles, to `out`."""
        n, ground = len(state.pose), seen(world)
        looks = Looks(
            np.empty((n, 3)), np.empty((n, 2, 3)), self._ways, np.ascontiguousarray(world.of)
        )
        looks_of(state.pose, state.attitude, height, ground, looks)
        ground_fan(looks, self.reach, ground, tops_of(ground, beams=out.size), out)
        obstacle_fan(looks, self.reach, world.arrays(), cones, out)
        np.minimum(out, 1.0, out=out)
        np.multiply(out, self.reach, out=out)
