"""Where a rover can stand: ground that is known, not too steep and without too high a ledge."""

from __future__ import annotations

import enum
import itertools

import numpy as np
from numpy.typing import NDArray

from ..core import F32, F64, U8, Frame, value
from ..kernels import distance as k
from ..terrain import Planes, Terrain, ledge_height, planes_over
from ._model import Rover

I32 = NDArray[np.int32]


class Reason(enum.IntEnum):
    """Why a rover cannot stand with its middle on a cell; stored as uint8."""

    FREE = 0
    """It can."""
    NO_DATA = 1
    """A height within its footing is missing."""
    SLOPE = 2
    """Steeper than the rover's limit, over its footing."""
    STEP = 3
    """A ledge higher than its wheels climb."""
    NEAR = 4
    """Free itself, but within the rover's radius of a cell that is not."""


@value
class Standing:
    """Where one rover can stand on one terrain.

    Attributes:
        frame: Where the cells lie.
        blocked: 1 where the rover's middle must not be (h, w), uint8, C-ordered.
        reason: A `Reason` for each cell (h, w), uint8.
        slope: Slope over the rover's footing (h, w), float32 [rad]; NaN where it is not known.
        step: Highest ledge within a wheel's diameter (h, w), float32 [m]; NaN without data.
        plain: Whether the terrain is a map of free and blocked cells; `Reason.NO_DATA` then means
            a cell that is not free.
    """

    frame: Frame
    blocked: U8
    reason: U8
    slope: F32
    step: F32
    plain: bool = False

    @property
    def share(self) -> float:
        """Share of the cells that are blocked, 0 to 1."""
        return float(self.blocked.mean())

    def share_by_reason(self) -> dict[str, float]:
        """Share of all cells, 0 to 1, by lower-case reason: free, no_data, slope, step, near."""
        count = np.bincount(self.reason.ravel(), minlength=len(Reason))
        return {r.name.lower(): float(count[r]) / self.reason.size for r in Reason}

    def steepest(self, path: F64) -> float:
        """Steepest ground under a path of local points (k, 2) [m], as an angle [rad].

        The path is looked at every quarter of a cell; cells without a slope do not count.
        """
        h, w = self.frame.shape
        ends = path if len(path) > 1 else np.repeat(path, 2, axis=0)
        worst = 0.0
        for a, b in itertools.pairwise(ends):
            count = 2 + int(4.0 * np.hypot(*(b - a)) / self.frame.cell)
            points = np.linspace(a, b, count) / self.frame.cell
            rows = np.clip(points[:, 1].astype(int), 0, h - 1)
            columns = np.clip(points[:, 0].astype(int), 0, w - 1)
            under = self.slope[rows, columns]
            worst = max(worst, float(np.max(under, initial=0.0, where=np.isfinite(under))))
        return worst


def standing(terrain: Terrain, rover: Rover) -> Standing:
    """Where `rover` can stand on `terrain`.

    Slope is that of a plane fitted to a square as wide as the rover's footing, because single
    posts are noisy and a body feels the ground as a whole. A step is a rise between two posts
    within a wheel's diameter that is both steeper than the rover's slope limit (otherwise it is a
    slope, however far apart the posts are) and higher than the rover's step limit. Blocked cells
    grow by the circle around the rover: exact distances between cell centres, equality included.
    The edge of the grid blocks nothing: leaving the map is another matter than standing on it.

    Args:
        terrain: The ground.
        rover: The rover, for its footing, wheels, limits and radius.

    Returns:
        A map of the terrain's own frame; no data comes before slope and slope before step where
        several reasons hold.
    """
    planes = planes_over(terrain, rover.footing)
    if rover.radius < terrain.frame.cell:  # reaches no other cell's middle
        tilt, step, reason = _reasons(terrain, rover, planes)
        return _standing(terrain, tilt, step, reason)
    return judged(terrain, rover, planes)[0]


def judged(terrain: Terrain, rover: Rover, planes: Planes) -> tuple[Standing, I32]:
    """Where `rover` can stand, from planes fitted to its footing, and the squares of distances.

    Returns:
        The map, and the squared distance [cells^2] of each cell to the nearest one that blocks by
        itself (h, w), `FAR` squared or more where there is none.
    """
    frame = terrain.frame
    tilt, step, reason = _reasons(terrain, rover, planes)
    squared = np.empty(frame.shape, np.int32)
    k.columns(reason, squared)
    k.squares(squared)
    cells = rover.radius / frame.cell
    k.near(squared, cells * cells * (1.0 + 2e-12), reason)
    return _standing(terrain, tilt, step, reason), squared


def _reasons(terrain: Terrain, rover: Rover, planes: Planes) -> tuple[F32, F32, U8]:
    """Slope, steps, and why a cell is forbidden by itself."""
    tilt = planes.slope()
    if terrain.plain:
        tilt[np.isnan(terrain.height)] = np.nan
    step = ledge_height(terrain, within=2.0 * rover.wheel_radius, steeper=rover.max_slope)
    reason = np.empty(terrain.frame.shape, np.uint8)
    k.reasons(tilt, step, (rover.max_slope, rover.max_step), reason)
    return tilt, step, reason


def _standing(terrain: Terrain, tilt: F32, step: F32, reason: U8) -> Standing:
    blocked = (reason != Reason.FREE).view(np.uint8)
    return Standing(
        frame=terrain.frame, blocked=blocked, reason=reason, slope=tilt, step=step,
        plain=terrain.plain,
    )  # fmt: skip
