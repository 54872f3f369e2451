"""Sensors that see the ground: eyes on a mast, and infra-red that looks down for holes."""

from __future__ import annotations

import math
from typing import Any, final

import numpy as np

from ..core import F64, Bool, Mission, RoverState, SettingError, suggest
from ..kernels import noise
from ..kernels import patches as kernels
from ._curves import CURVES
from ._noise import FAR, Draws, draws
from ._seeing import seen
from ._world import Worlds


@final
class Patch:
    """Heights of the ground ahead, as a pair of cameras on a mast sees them.

    Places lie on a square lattice in the rover's frame, levelled: as far and as wide as the view
    reaches. A ridge hides what lies behind it. Heights count from the ground under the rover's
    middle. Obstacles that have no height (boxes, discs) are not seen.

    Args:
        near: Nearest place [m].
        far: Farthest place [m].
        view: Angle of view [rad].
        cell: Distance of places [m].
        mast: Height of the eyes above the ground under the rover [m].
        noise: Standard deviation of a height, for each square metre of distance squared [1/m].
        lose: Chance that a place has no match in the pictures.
    """

    name = "patch"

    def __init__(  # noqa: PLR0913 - settings by keyword
        self,
        *,
        near: float = 0.5,
        far: float = 6.0,
        view: float = math.radians(90.0),
        cell: float = 0.15,
        mast: float = 1.0,
        noise: float = 0.001,
        lose: float = 0.02,
    ) -> None:
        given = {"near": near, "far": far, "view": view, "cell": cell, "mast": mast}
        for what, got in given.items():
            if not (math.isfinite(got) and got > 0):
                raise SettingError(f"a patch needs a {what} above 0, got {got!r}")
        if not near < far or not far / cell <= MOST_CELLS or view > 2.0 * math.pi:
            raise SettingError(
                f"a patch must reach farther than {near:g} m, at most {MOST_CELLS} cells of "
                f"{cell:g} m, and see at most 360 deg; got {far:g} m and {view!r} rad"
            )
        if not (0.0 <= noise < math.inf and 0.0 <= lose < 1.0):
            raise SettingError(
                f"a patch's noise must be 0 or more and lose from 0 to below 1, got {noise!r} and "
                f"{lose!r}"
            )
        self.far, self.cell, self.mast, self.noise = far, cell, mast, noise
        self.places: F64 = _lattice(near, far, view, cell)
        self._eyes = kernels.Eyes(float(mast), float(noise), float(lose), slack=float(cell))

    def start(self, mission: Mission, rng: np.random.Generator) -> Draws:
        """Who sees."""
        return draws(mission, rng)

    def read(self, world: Worlds, state: RoverState, memory: Draws) -> tuple[F64, Draws]:
        """Heights (n, places) [m], NaN where nothing is seen."""
        out, now = np.empty((len(state.pose), len(self.places))), memory.next()
        kernels.seen_patch(
            state.pose, np.ascontiguousarray(world.of), now.keys, now.step, seen(world), self._eyes,
            self.places, out,
        )  # fmt: skip
        return out, now


@final
class HoleSensor:
    """Infra-red sensors that look down ahead of the wheels: how far it is to the ground.

    Args:
        curve: Which sensor, of `CURVES`.
        ahead: Where they are, forward of the rover's middle [m].
        across: Where they are to the left [m], one each.
        height: Above level ground [m].
        down: Angle below the body's level [rad]; several for rows of sensors that look less and
            less far, one at each place across.
    """

    name = "down"

    def __init__(
        self,
        curve: str = "GP2Y0A02YK0F",
        *,
        ahead: float = 0.3,
        across: tuple[float, ...] = (-0.25, 0.0, 0.25),
        height: float = 0.35,
        down: float | tuple[float, ...] = math.radians(50.0),
    ) -> None:
        if curve not in CURVES:
            raise SettingError(f"unknown infra-red sensor {curve!r}; {suggest(curve, CURVES)}")
        rows = (down,) if isinstance(down, int | float) else tuple(down)
        if not (height > 0 and rows and all(0 < a <= math.pi / 2 for a in rows) and across):
            raise SettingError(
                "a hole sensor needs a height above 0 m, an angle down of above 0 and at most 90 "
                f"deg, and one place across at least; got {height!r}, {down!r}, {across!r}"
            )
        self.curve, self.height = CURVES[curve], float(height)
        for angle in rows:
            level = height / math.sin(angle)
            if not self.curve.nearest < level < self.curve.reach:
                raise SettingError(
                    f"{curve} tells {self.curve.nearest:g} to {self.curve.reach:g} m apart, but "
                    f"level ground is {level:.3g} m away; change height or down"
                )
        # Not `angles`: a sensor with these and `reach` counts as a level fan in movies and bags.
        self.depressions: F64 = np.repeat(np.array(rows, np.float64), len(across))
        self.mounts: F64 = np.array(
            [[ahead, left, height] for _ in rows for left in across], np.float64
        )

    @property
    def reach(self) -> float:
        """Who reads this far saw no ground [m]."""
        return self.curve.reach

    @property
    def doubt(self) -> F64:
        """Readings, rising, and their standard deviations (t, 2) [m]; see `Curve.doubt`."""
        return self.curve.doubt()

    def start(self, mission: Mission, rng: np.random.Generator) -> Draws:
        """Who reads."""
        return draws(mission, rng)

    def read(self, world: Worlds, state: RoverState, memory: Draws) -> tuple[F64, Draws]:
        """Distances (n, sensors) [m], as `across` says, row after row."""
        true = np.empty((len(state.pose), len(self.mounts)))
        out, now, c = np.empty_like(true), memory.next(), self.curve
        kernels.look_down(
            state.pose, state.attitude, np.ascontiguousarray(world.of), self.mounts,
            self.depressions, FAR * c.reach, seen(world), true,
        )  # fmt: skip
        noise.infrared(true, now.keys, now.step, c.rows, c.noise, c.counts, c.volt, out)
        return out, now

    def holes(self, reading: F64, depth: float) -> Bool:
        """Where the ground ahead is more than `depth` [m] lower than level ground (n, sensors)."""
        return reading > (self.height + depth) / np.sin(self.depressions)


MOST_CELLS = 400
"""Places from the rover to the far edge of a patch."""


def _lattice(near: float, far: float, view: float, cell: float) -> Any:
    """Forward, left (m, 2) [m] of the places in view, nearest rows first."""
    count = int(far / cell)
    forward, left = np.meshgrid(
        np.arange(-count, count + 1) * cell, np.arange(-count, count + 1) * cell, indexing="ij"
    )
    distance, angle = np.hypot(forward, left), np.abs(np.arctan2(left, forward))
    inside = (distance >= near) & (distance <= far) & (angle <= view / 2 + 1e-12)
    return np.ascontiguousarray(np.stack([forward[inside], left[inside]], axis=1))
