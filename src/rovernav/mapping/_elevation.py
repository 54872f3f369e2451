"""The map of heights and hazards that a rover makes of what it sees, and of nothing else."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple, final

import numpy as np

from ..core import F32, F64, U8, Frame, Mission, SettingError, value
from ..kernels import drops, fan
from ..kernels import elevation as kernels
from ..rover import Rover
from ._local import LocalMap


@value
class Elevation:
    """The ground around n rovers, as they know it. Cells lie as those of `LocalMap` do.

    Attributes:
        height: Height over the ground at the start (n, s, s), float32 [m]; NaN where unknown.
        variance: Its variance (n, s, s), float32 [m^2]; NaN where unknown.
        top: Height that some ground in the cell surely reaches (n, s, s), float32 [m].
        slope: Slope over the rover's footing (n, s, s), float32 [rad]; NaN where unknown.
        step: Highest ledge (n, s, s), float32 [m]; NaN where unknown.
        reason: A `rover.Reason` for each cell (n, s, s), uint8; `NO_DATA` where it is unknown.
        marks: 1 where a range beam met something (n, s, s), uint8.
        unsure: Variances of place and height of each rover as last told (n, 2) [m^2].
    """

    height: F32
    variance: F32
    top: F32
    slope: F32
    step: F32
    reason: U8
    marks: U8
    unsure: F64


class View(NamedTuple):
    """The map of one rover as plain grids, south edge first.

    Attributes:
        frame: Where they lie; the local point (0, 0) of the frame is its `origin` in the rover's
            own metres.
        height: (s, s) [m].
        variance: (s, s) [m^2].
        top: (s, s) [m].
        slope: (s, s) [rad].
        step: (s, s) [m].
        reason: (s, s).
        blocked: 1 where its middle must not be (s, s).
    """

    frame: Frame
    height: F32
    variance: F32
    top: F32
    slope: F32
    step: F32
    reason: U8
    blocked: U8


class Look(NamedTuple):
    """What a mapper needs to know about the eyes; a `sim.Patch` has it all.

    Attributes:
        places: Forward, left of the patch's places (m, 2) [m].
        far: Farthest of them [m].
        mast: Height of the eyes [m].
        noise: Of heights, for each square metre of distance squared [1/m].
    """

    places: F64
    far: float
    mast: float
    noise: float


@final
class ElevationMapper:
    """Makes a map of heights from patches, and judges it by the rover's limits.

    Height and variance in each cell as by Kalman; what is not seen again grows less sure as the
    rover's estimate of its pose does. Ground that was never seen counts as free for going there,
    but is marked as unknown. What range beams met is kept too, if the rover has a fan.

    The map is a `LocalMap` whose `ground` is an `Elevation`: drivers that know the one can use the
    other. A rover without a fan gets one that looks at its map: the channel ``beams``.

    Args:
        rover: Whose limits judge the ground.
        look: The eyes: a `sim.Patch`, or a `Look`.
        fan: A range fan with `angles` and `reach`, or None.
        holes: Sensors that look down ahead of the wheels, a `sim.HoleSensor`, or None. They tell of
            ground that the eyes do not see.
        side: Cells along the map's side, a power of two.
        cell: Side of a cell [m]; such that the map reaches twice as far as the eyes where not
            given.
        rays: Directions in which the map is asked.
        margin: What is kept from hazards beyond the rover's radius [m]; one cell where not given.
        prudence: Share of the rover's step limit that a ledge may have: of a rock as narrow as a
            cell, a view from places between its posts shows some three quarters.
        sure: Standard deviations by which tops and ledges must be higher than read.
        closed: Whether unknown ground is blocked.
    """

    def __init__(  # noqa: PLR0913 - settings by keyword
        self,
        rover: Rover,
        look: Any,
        *,
        fan: Any = None,
        holes: Any = None,
        side: int = 128,
        cell: float | None = None,
        rays: int = 64,
        margin: float | None = None,
        prudence: float = 0.85,
        sure: float = 1.0,
        closed: bool = False,
    ) -> None:
        if side < 8 or side & (side - 1):
            raise SettingError(
                f"an elevation map needs a side of 8, 16, 32, ... cells, got {side!r}"
            )
        self.cell = float(cell) if cell is not None else 2.0 * look.far / (side // 2 - 1)
        if not (math.isfinite(self.cell) and self.cell > 0):
            raise SettingError(f"a map's cell must be above 0 m, got {cell!r}")
        self.side, self.rays, self.closed = int(side), int(rays), bool(closed)
        self.look = Look(look.places, float(look.far), float(look.mast), float(look.noise))
        self.fan = fan
        self.extent = self.cell * (side // 2 - 1)
        self.keep = rover.radius + (self.cell if margin is None else margin)
        self._fusion = kernels.Fusion(
            self.cell, self.look.mast, self.look.noise, LEAST**2, float(sure)
        )
        self._down = None if holes is None else drops.Down(
            mounts=holes.mounts, angle=holes.depressions, reach=float(holes.reach),
            doubt=holes.doubt, tilt=TILT, step=prudence * rover.max_step,
            slope=math.tan(rover.max_slope),
        )  # fmt: skip
        half = max(1, round(0.5 * rover.footing / self.cell))
        self._limits = kernels.Limits(
            cell=self.cell,
            half=half,
            wheel=max(1, round(2.0 * rover.wheel_radius / self.cell)),
            slope=math.tan(rover.max_slope),
            step=prudence * rover.max_step,
            radius=self.keep / self.cell,
            sure=float(sure),
            around=min(side // 2, math.ceil(self.look.far / self.cell) + half + 1),
        )

    def start(self, mission: Mission) -> LocalMap:
        """Nothing is known."""
        n, s = len(mission.start), self.side
        nan = np.full((n, s, s), np.nan, np.float32)
        ground = Elevation(
            height=nan, variance=nan, top=nan, slope=nan, step=nan,
            reason=np.full((n, s, s), kernels.UNKNOWN, np.uint8),
            marks=np.zeros((n, s, s), np.uint8), unsure=np.zeros((n, 2)),
        )  # fmt: skip
        at = np.floor(mission.start[:, [1, 0]] / self.cell).astype(np.int64)
        return LocalMap(
            cells=ground.marks, centre=at, pose=mission.start, goal=mission.goal, cell=self.cell,
            ground=ground,
        )  # fmt: skip

    def update(
        self, memory: LocalMap, pose: F64, goal: F64, channels: Mapping[str, F64]
    ) -> tuple[dict[str, F64], LocalMap]:
        """Take in a patch, judge the map, ask it.

        Args:
            memory: The map so far.
            pose: Where the rovers think they are (n, 3).
            goal: Goals (n, 2) [m].
            channels: Must hold ``patch``; ``estimate``, if it is there, says how sure the pose is
                and how high the rover is: otherwise the patch is laid where it fits best. With
                `holes`, ``down``, and ``tilt`` if the rover knows how it leans: otherwise it takes
                itself for level.

        Returns:
            ``around``, ``reach`` as `LocalMapper`; ``beams`` (n, 49) for a rover without a fan:
            free distance over 180 deg ahead; and the map.
        """
        was = memory.ground
        if not isinstance(was, Elevation):
            raise SettingError("an elevation map goes on from one of its own, not from another map")
        new = {name: getattr(was, name).copy() for name in LAYERS}
        centre = memory.centre.copy()
        for name, layer in new.items():
            if name != "marks":
                fill = kernels.UNKNOWN if name == "reason" else np.nan
                kernels.forget(layer, centre, pose, self.cell, fill)
        fan.roll(new["marks"], centre, pose, self.cell)
        unsure = self._take_in(new, centre, pose, channels, was.unsure)
        cells = self._judge(new, centre, pose, channels)
        now = LocalMap(
            cells=cells, centre=centre, pose=pose, goal=goal, cell=self.cell,
            ground=Elevation(**new, unsure=unsure),
        )  # fmt: skip
        return self._ask(now, channels), now

    def _take_in(
        self, new: dict[str, Any], centre: Any, pose: F64, channels: Mapping[str, F64], unsure: F64
    ) -> F64:
        """Take this patch into the layers; returns how unsure the rovers are now."""
        height, variance, top = new["height"], new["variance"], new["top"]
        patch, places, f = channels["patch"], self.look.places, self._fusion
        stand, estimate = np.empty((len(pose), 4)), channels.get("estimate")
        stand[:, :3] = pose
        if estimate is None:
            kernels.level(height, variance, centre, stand, places, patch, f)
        else:
            stand[:, 3] = estimate[:, 3]
            now = estimate[:, [4, 6]]
            grown = np.ascontiguousarray(np.maximum(now - unsure, 0.0).T)
            kernels.inflate(variance, top, new["slope"], grown[1], grown[0])
            unsure = now
        kernels.fuse(height, variance, top, centre, stand, places, patch, f)
        if self._down is not None:
            lean = channels.get("tilt")
            lean = np.zeros((len(pose), 2)) if lean is None else np.ascontiguousarray(lean)
            drops.take_drops(
                (height, variance, top), centre, stand, lean, channels["down"], self._down, f
            )
        return unsure

    def _judge(
        self, new: dict[str, Any], centre: Any, pose: F64, channels: Mapping[str, F64]
    ) -> U8:
        kernels.judge(
            new["height"], new["variance"], new["top"], centre, self._limits,
            new["slope"], new["step"], new["reason"],
        )  # fmt: skip
        marks = new["marks"]
        if self.fan is not None:
            fan.mark(
                marks, centre, pose, self.fan.angles, channels["beams"], self.fan.reach, self.cell,
                4.0 * self.cell,
            )  # fmt: skip
        cells = np.empty_like(marks)
        kernels.grow(new["reason"], marks, centre, self._limits.radius, self.closed, cells)
        return cells

    def _ask(self, now: LocalMap, channels: Mapping[str, F64]) -> dict[str, F64]:
        out = now.asked(self.rays)
        if "beams" not in channels:
            whole = np.empty((len(now.pose), 2 * (BEAMS - 1)))
            ahead = np.ascontiguousarray(now.pose[:, 2])
            fan.around(now.cells, now.centre, now.pose, ahead, self.cell, whole)
            side = BEAMS // 2
            out["beams"] = np.concatenate([whole[:, -side:], whole[:, : side + 1]], axis=1)
        return out


LAYERS = ("height", "variance", "top", "slope", "step", "reason", "marks")
"""The layers of a map, by name."""
LEAST = 0.01
"""Standard deviation of the best height: ground is not level within a cell [m]."""
TILT = 0.01
"""Standard deviation of the tilt that a rover takes itself to have [rad]."""
BEAMS = 49
"""Beams of the fan that looks at the map."""


def view(local: LocalMap, k: int = 0) -> View:
    """The elevation map of rover k as plain grids.

    Raises:
        SettingError: The map has no heights.
    """
    ground = local.ground
    if not isinstance(ground, Elevation):
        raise SettingError("this map has no heights; give the rover an ElevationMapper")
    s = local.cells.shape[1]
    low = local.centre[k] - s // 2
    rows, columns = np.arange(low[0], low[0] + s) & (s - 1), np.arange(low[1], low[1] + s) & (s - 1)

    def flat(layer: Any) -> Any:
        return layer[k][np.ix_(rows, columns)]

    origin = (float(low[1]) * local.cell, float(low[0]) * local.cell)
    return View(
        frame=Frame(cell=local.cell, shape=(s, s), origin=origin),
        height=flat(ground.height),
        variance=flat(ground.variance),
        top=flat(ground.top),
        slope=flat(ground.slope),
        step=flat(ground.step),
        reason=flat(ground.reason),
        blocked=flat(local.cells),
    )


def aimed(local: LocalMap, goal: F64) -> LocalMap:
    """The same map with other goals (n, 2) [m]."""
    return replace(local, goal=goal)
