"""Where a rover thinks it is: wheels, a gyro and perhaps the sun; how sure it is of it.

Symbols: a heading [rad]; way: path of the wheels [m]; the estimate has x, y, a, z and the variances
V of place (both axes together) [m^2], P of heading [rad^2], C of heading with the sideways error
[m rad], Z of height [m^2], and the whole way D [m].
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ._jit import kernel
from .field import deviate
from .surface import height_at

SCALE, CURL, ALONG, TURN, RISE, SUN = range(6)
"""Channels of the draws."""
X, Y, A, Z, V, P, VZ, C, D = range(9)
"""Columns of an estimate."""
TOLD = 7
"""So many of them are told; the others are the estimate's own."""


class Drift(NamedTuple):
    """How an estimate drifts.

    Attributes:
        scale: Standard deviation of the constant error of length, of each rover [1].
        walk: Random error of length [m/sqrt(m)].
        turn: Random error of heading [rad/sqrt(m)].
        curl: Standard deviation of the constant error of heading [rad/m].
        rise: Random error of height [m/sqrt(m)].
        sun: Standard deviation of a heading by the sun [rad]; 0 without a sun sensor.
    """

    scale: float
    walk: float
    turn: float
    curl: float
    rise: float
    sun: float


class Heights(NamedTuple):
    """The ground of all worlds.

    Attributes:
        height: Heights of each world or of all (g, h, w), float32 [m]; (0, 0, 0): flat at 0.
        cell: [m].
        of: World of each rover (n,).
    """

    height: Any
    cell: float
    of: Any


@kernel()
def base(k: int, x: float, y: float, ground: Heights) -> float:
    """Height of the ground under (x, y) in rover k's world [m]; NaN where it is not known."""
    if ground.height.size == 0:
        return 0.0
    layer = ground.of[k] if ground.height.shape[0] > 1 else 0
    return height_at(ground.height[layer], ground.cell, x, y)


@kernel()
def advance(
    pose: Any,
    last: Any,
    slip: Any,
    rovers: Any,
    step: int,
    ground: Heights,
    d: Drift,
    estimate: Any,
) -> None:
    """Take the estimates from the last poses to these, as the sensors would.

    The chord of the true motion, seen along the mean heading, is (f, l). Wheels turn
    w = f / (1 - slip) and do not feel that the rover slides sideways by slip[1] w. The rover adds
    w (1 + scale) + walk sqrt(|w|) along its own mean heading, and turns by what it turned, plus
    curl |w| + turn sqrt(|w|), each times a deviate. A heading by the sun is taken in as by Kalman.

    The variances grow by

        P' = turn^2 + 2 curl^2 D,           C' = P + curl^2 D^2 / 2,
        V' = walk^2 + 2 scale^2 D + 2 C,    Z' = rise^2

    for each metre of way, which is right on a straight line; a sun's fix scales P and C.

    Args:
        pose: True poses (n, 3).
        last: True poses at the last reading (n, 3).
        slip: Along, and to the left (n, 2), as shares of the wheels' way.
        rovers: Key of each rover (n,).
        step: Number of this reading, from 1.
        ground: The true ground.
        d: How the estimate drifts.
        estimate: (n, 9), changed.
    """
    for k in range(pose.shape[0]):
        key, e = rovers[k], estimate[k]
        turned = wrap(pose[k, 2] - last[k, 2])
        middle = last[k, 2] + 0.5 * turned
        c, s = math.cos(middle), math.sin(middle)
        dx, dy = pose[k, 0] - last[k, 0], pose[k, 1] - last[k, 1]
        way = (c * dx + s * dy) / (1.0 - min(slip[k, 0], 0.99))
        aside = c * dy - s * dx - slip[k, 1] * way
        length = abs(way) + abs(aside)
        root = math.sqrt(length)
        way *= 1.0 + d.scale * deviate(key, 0, SCALE)
        way += d.walk * root * deviate(key, step, ALONG)
        before = e[A]
        turned += d.curl * length * deviate(key, 0, CURL) + d.turn * root * deviate(key, step, TURN)
        e[A] = wrap(before + turned)
        c, s = math.cos(before + 0.5 * turned), math.sin(before + 0.5 * turned)
        e[X] += c * way - s * aside
        e[Y] += s * way + c * aside
        rise = base(k, pose[k, 0], pose[k, 1], ground) - base(k, last[k, 0], last[k, 1], ground)
        e[Z] += (rise if rise == rise else 0.0) + d.rise * root * deviate(key, step, RISE)
        _spread(e, length, d)
        if d.sun > 0.0:
            seen = pose[k, 2] + d.sun * deviate(key, step, SUN)
            gain = e[P] / (e[P] + d.sun * d.sun)
            e[A] = wrap(e[A] + gain * wrap(seen - e[A]))
            e[P] *= 1.0 - gain
            e[C] *= 1.0 - gain


@kernel()
def _spread(e: Any, w: float, d: Drift) -> None:
    """Let the variances of an estimate grow over a way w."""
    whole, then = e[D], e[D] + w
    cubes = (then * then * then - whole * whole * whole) * d.curl * d.curl
    heading = d.turn * d.turn * w + d.curl * d.curl * w * (whole + then)
    before = e[C]
    e[C] += e[P] * w + 0.5 * d.turn * d.turn * w * w
    e[C] += 0.5 * cubes - d.curl * d.curl * whole * whole * w
    e[P] += heading
    e[V] += d.walk * d.walk * w + d.scale * d.scale * w * (whole + then) + (before + e[C]) * w
    e[VZ] += d.rise * d.rise * w
    e[D] += w


@kernel(inline=True)
def wrap(a: float) -> float:
    """The angle in (-pi, pi]."""
    return math.atan2(math.sin(a), math.cos(a))
