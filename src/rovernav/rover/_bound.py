"""What holds for a rover wherever in a small box of poses it really is."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core import F64, U8, SettingError, value
from ..kernels import clearance as k
from ._settle import Pose, Surface, checked_poses


@value
class Bound:
    """Bounds for n boxes of poses; NaN where nothing could be shown.

    Attributes:
        tilt: Tilt is at most this (n,) [rad].
        pitch: Ends of the pitch (n, 2) [rad].
        roll: Ends of the roll (n, 2) [rad].
        rocker: Rockers turn by at most this (n,) [rad].
        bogie: Bogies turn by at most this (n,) [rad].
        clearance: The belly is at least this far from the ground (n,) [m].
        step: Steps under wheels are at most this (n,) [m].
        code: `Pose.SAFE` where every pose of the box is safe, proven; otherwise the first limit
            that could not be shown to hold (n,), uint8.
    """

    tilt: F64
    pitch: F64
    roll: F64
    rocker: F64
    bogie: F64
    clearance: F64
    step: F64
    code: U8

    @property
    def safe(self) -> Any:
        """Whether every pose of each box is proven safe (n,)."""
        return self.code == Pose.SAFE


def bound(ground: Surface, poses: Any, *, position: Any = 0.1, heading: Any = 0.05) -> Bound:
    """Bounds of attitude, joints and clearance for boxes of poses, without settling each.

    A pose called safe is safe: whatever the ground, every pose of its box settles within the
    bounds given (docs/derivations.md has the proof). One that is not may still be safe.

    Args:
        ground: From `surface`.
        poses: x, y, heading of the rover's middle (n, 3), local frame [m, m, rad].
        position: Half the side of the square in which the middle lies, along the grid [m]; a
            number or (n,).
        heading: Half the range of headings [rad]; a number or (n,), at most 1.

    Raises:
        ShapeError: `poses` is not (n, 3).
        SettingError: A negative doubt, or one without end.
    """
    middle = checked_poses(poses)
    rows = np.empty((len(middle), 5))
    rows[:, :3], rows[:, 3], rows[:, 4] = middle, position, heading
    if not ((rows[:, 3:] >= 0.0) & (rows[:, 3:] <= (100.0, 1.0))).all():
        raise SettingError("doubt of position must be 0 to 100 m, of heading 0 to 1 rad")
    out = np.empty((len(rows), k.BOUND))
    g, cell = ground, ground.frame.cell
    k.bound(g.wheel, g.gradient, g.ground, g.step, cell, g.chassis, rows, out)
    return Bound(
        tilt=out[:, k.TILT].copy(),
        pitch=out[:, k.PITCH_LOW : k.PITCH_HIGH + 1].copy(),
        roll=out[:, k.ROLL_LOW : k.ROLL_HIGH + 1].copy(),
        rocker=out[:, k.ROCKER].copy(),
        bogie=out[:, k.BOGIE].copy(),
        clearance=out[:, k.CLEARANCE].copy(),
        step=out[:, k.STEP].copy(),
        code=out[:, k.CODE].astype(np.uint8),
    )
