"""What a rover sees of the ground: a patch of heights ahead of it, and how far down it is.

Symbols: r distance from the eye [m].
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ._jit import kernel
from .field import deviate
from .noise import PER_BEAM, share
from .ridges import GroundArrays, first_rise
from .surface import height_at


class Eyes(NamedTuple):
    """A pair of cameras on a mast.

    Attributes:
        mast: Height of the eyes above the ground under the rover's middle [m].
        noise: Standard deviation of a height, for each square metre of r^2 [1/m].
        lose: Chance that a place has no match in a picture.
        slack: Ground within this much of a place does not hide it [m].
    """

    mast: float
    noise: float
    lose: float
    slack: float


@kernel()
def under(layer: int, x: float, y: float, ground: GroundArrays) -> float:
    """Height of the ground at (x, y) [m]; 0 in flat worlds, NaN where it is not known."""
    if ground.heights.size == 0:
        return 0.0
    return height_at(ground.heights[layer], ground.cell, x, y)


@kernel()
def seen_patch(
    pose: Any, of: Any, rovers: Any, step: int, ground: GroundArrays, p: Eyes, places: Any, out: Any
) -> None:
    """Heights of places ahead of each rover, over the ground under its middle.

    A place whose straight line to the eye meets the ground before it is hidden: NaN. So is one
    without a match, and one beyond the map. To the others `noise` r^2 times a deviate is added: in
    a picture of two eyes the distance is a base over a difference of angles, so an error of that
    difference grows with r^2.

    Args:
        pose: True poses (n, 3).
        of: World of each rover (n,).
        rovers: Key of each rover (n,).
        step: Number of this reading.
        ground: The ground of all worlds.
        p: The eyes.
        places: Forward, left of each place (m, 2) [m].
        out: Heights (n, m) [m], NaN where nothing is seen; written.
    """
    for k in range(pose.shape[0]):
        layer = of[k] if ground.heights.shape[0] > 1 else 0
        c, s = math.cos(pose[k, 2]), math.sin(pose[k, 2])
        base = under(layer, pose[k, 0], pose[k, 1], ground)
        eye = (pose[k, 0], pose[k, 1], base + p.mast)
        for m in range(places.shape[0]):
            x = pose[k, 0] + c * places[m, 0] - s * places[m, 1]
            y = pose[k, 1] + s * places[m, 0] + c * places[m, 1]
            z = under(layer, x, y, ground)
            out[k, m] = np.nan
            if not abs(z - base) < np.inf or share(rovers[k], step, PER_BEAM * m) < p.lose:
                continue
            rr = (x - eye[0]) ** 2 + (y - eye[1]) ** 2 + (z - eye[2]) ** 2
            t = first_rise(layer, eye, (x, y, z), ground)
            if t > 1.0 or (1.0 - t) * math.sqrt(rr) <= p.slack:
                error = p.noise * rr * deviate(rovers[k], step, PER_BEAM * m + 1)
                out[k, m] = z - base + error


@kernel(inline=True)
def turned(x: float, y: float, z: float, pose: Any, attitude: Any) -> tuple[float, float, float]:
    """A direction forward, left, up in the body, in the world: rolled, pitched, then turned."""
    c, s = math.cos(attitude[2]), math.sin(attitude[2])
    y, z = c * y - s * z, s * y + c * z
    c, s = math.cos(attitude[1]), math.sin(attitude[1])
    x, z = c * x - s * z, s * x + c * z
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return c * x - s * y, s * x + c * y, z


@kernel()
def look_down(
    pose: Any, attitude: Any, of: Any, mounts: Any, down: Any, reach: float,
    ground: GroundArrays, out: Any,
) -> None:  # fmt: skip
    """Distance from each mount to the ground, along a beam that points ahead and down.

    Args:
        pose: True poses (n, 3).
        attitude: Height, pitch, roll (n, 3); the height is not used.
        of: World of each rover (n,).
        mounts: Forward, left, and above the ground under the rover's middle (b, 3) [m].
        down: Angle of each beam below the body's own level (b,) [rad].
        reach: Longest distance [m].
        ground: The ground of all worlds.
        out: Distances (n, b) [m], at most `reach`.
    """
    for k in range(pose.shape[0]):
        layer = of[k] if ground.heights.shape[0] > 1 else 0
        base = under(layer, pose[k, 0], pose[k, 1], ground)
        for b in range(mounts.shape[0]):
            dx, dy, dz = turned(math.cos(down[b]), 0.0, -math.sin(down[b]), pose[k], attitude[k])
            x, y, z = turned(mounts[b, 0], mounts[b, 1], mounts[b, 2], pose[k], attitude[k])
            eye = (pose[k, 0] + x, pose[k, 1] + y, base + z)
            end = (eye[0] + reach * dx, eye[1] + reach * dy, eye[2] + reach * dz)
            if ground.heights.size == 0:
                t = eye[2] / (eye[2] - end[2]) if end[2] < eye[2] else 2.0
                out[k, b] = reach * min(max(t, 0.0), 1.0)
            else:
                out[k, b] = reach * min(1.0, first_rise(layer, eye, end, ground))
