"""A rover set onto the ground: how it stands, and what would stop it standing so."""

from __future__ import annotations

import enum
from typing import Any

import numpy as np

from ..core import F32, F64, U8, Frame, InputError, ShapeError, value
from ..kernels import settle as k
from ..kernels.standing import settle as settle_all
from ..kernels.surface import wheel_centres
from ..terrain import Terrain, ledge_height, planes_over
from ._model import Rover


class Pose(enum.IntEnum):
    """Why a rover must not stand in a pose; stored as uint8."""

    SAFE = 0
    """It may."""
    NO_DATA = 1
    """Ground under a wheel or the belly is missing, or the pose reaches off the map."""
    TILT = 2
    """Tilt, pitch or roll beyond the limits."""
    SUSPENSION = 3
    """A joint beyond its limit, or a wheel that cannot reach the ground."""
    BELLY = 4
    """The belly touches the ground."""
    STEP = 5
    """A step under a wheel that is higher than it climbs."""
    UNPROVEN = 6
    """Only from `bound`: nothing could be shown."""


@value
class Surface:
    """Ground made ready for one rover's wheels.

    Attributes:
        frame: Where the cells lie.
        ground: Heights of the posts (h, w), float32 [m].
        wheel: Height of a wheel's centre over each post (h, w), float32 [m].
        gradient: Slope to the east and to the north of planes fitted to the rover's footing
            (2, h, w), float32.
        step: Highest step within a wheel's diameter (h, w), float32 [m].
        offset: The height that the others count from [m].
        rover: Whose wheels.
        chassis: The rover's chassis as the kernels take it.
    """

    frame: Frame
    ground: F32
    wheel: F32
    gradient: F32
    step: F32
    offset: float
    rover: Rover
    chassis: F64


def surface(terrain: Terrain, rover: Rover) -> Surface:
    """`terrain` made ready for settling `rover` on it, any number of times.

    A wheel is a sphere of the wheel's radius: its centre is where it rests on the highest of the
    posts below it. Between posts, centres lie bilinearly. Steps are those of `standing`.

    Raises:
        SettingError: The rover has no wheels.
    """
    chassis, planes = rover.chassis_array(), planes_over(terrain, rover.footing)
    wheel = np.empty(terrain.frame.shape, np.float32)
    wheel_centres(terrain.height, terrain.frame.cell, rover.wheel_radius, wheel)
    return Surface(
        frame=terrain.frame,
        ground=terrain.height,
        wheel=wheel,
        gradient=np.stack((planes.east, planes.north)),
        step=ledge_height(terrain, within=2.0 * rover.wheel_radius, steeper=rover.max_slope),
        offset=terrain.offset,
        rover=rover,
        chassis=chassis,
    )


@value
class Settled:
    """How a rover stands at each of n poses; NaN where the ground is not known.

    Attributes:
        z: Height of the rover's middle, level with its axles (n,) [m].
        pitch: Nose up (n,) [rad].
        roll: Left side up (n,) [rad].
        tilt: Angle of the body against level (n,) [rad].
        rocker: Angle of the left rocker against the body, nose up; the right one's is the opposite
            (n,) [rad].
        bogie_left: Angle of the left bogie against the body, nose up (n,) [rad].
        bogie_right: Of the right one (n,) [rad].
        clearance: Least distance of the belly from the ground, square to the belly (n,) [m].
        step: Highest step under a wheel (n,) [m].
        error: Last change of an angle while settling (n,) [rad]; above 1e-7 the rover stands
            where a wheel is about to drop or climb, and the numbers are one way it can stand.
        code: A `Pose` for each (n,), uint8.
    """

    z: F64
    pitch: F64
    roll: F64
    tilt: F64
    rocker: F64
    bogie_left: F64
    bogie_right: F64
    clearance: F64
    step: F64
    error: F64
    code: U8

    @property
    def safe(self) -> Any:
        """Whether each pose keeps all limits (n,)."""
        return self.code == Pose.SAFE


def settle(ground: Surface, poses: Any) -> Settled:
    """Settle the rover on the ground at each pose.

    Args:
        ground: From `surface`.
        poses: x, y, heading of the rover's middle (n, 3), local frame [m, m, rad].

    Raises:
        ShapeError: `poses` is not (n, 3).
    """
    rows = checked_poses(poses)
    out = np.empty((len(rows), k.SETTLED))
    g, cell = ground, ground.frame.cell
    settle_all(g.wheel, g.gradient, g.ground, g.step, cell, g.chassis, rows, out)
    out[:, k.Z] += ground.offset
    columns = {name: np.ascontiguousarray(out[:, i]) for i, name in enumerate(_COLUMNS)}
    return Settled(**columns, code=out[:, k.CODE].astype(np.uint8))


_COLUMNS = (
    *("z", "pitch", "roll", "tilt", "rocker", "bogie_left", "bogie_right", "clearance", "step"),
    "error",
)


def checked_poses(poses: Any) -> F64:
    """Poses as the kernels take them: float64, C-ordered, finite.

    Raises:
        ShapeError: Not (n, 3).
        InputError: A number is NaN or infinite.
    """
    rows = np.ascontiguousarray(poses, dtype=np.float64)
    if rows.ndim != 2 or rows.shape[1] != 3:
        raise ShapeError(f"poses must be (n, 3): x, y, heading, got shape {rows.shape}")
    if not np.isfinite(rows).all():
        raise InputError("poses must be finite numbers")
    return rows
