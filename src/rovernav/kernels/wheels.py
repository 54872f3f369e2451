"""From a commanded body twist to the one that steering, motors and their lag allow.

Symbols: (u, v, w) body twist: forward [m/s], left [m/s], turn [rad/s]; t track, half of it h; d the
steering's limit; x0 the place along the body of the axle that is not steered.

A body is an array (BODY,) of the numbers that the constants below name.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._jit import kernel
from .settle import KIND as SUSPENSION
from .settle import ROCKER_BOGIE, TRACK, X_END, X_MID, X_ONE

F64: TypeAlias = NDArray[np.float64]

STEERING, SPEED, TURN_RATE, WHEEL_SPEED, ACCELERATION, TURN_ACCELERATION = range(6)
LEFT_OVER, MEAN_LEFT, AXLE, OUTER, INNER, STEER = range(6, 12)
"""LEFT_OVER: share of the gap to the target that a part's end leaves, MEAN_LEFT: on its average."""
PERIOD, PART, PARTS, GRID, TIP, STALL, PATIENT = range(12, 19)
"""Length of a step and of its parts [s], how many parts; whether grids are obstacles; tipping angle
[rad]; way after which progress is looked at [m], and the least share of it."""
FRONT, REAR, HALF_WIDTH, STRIP_IN, STRIP_OUT, LIFT, SLACK = range(19, 26)
"""Footprint, wheel strips (|y| from, to), clearance [m], and what the sweep may add [m]."""
BODY = 26
TWO_AXIS, SKID, ACKERMANN, CRAB = 0.0, 1.0, 2.0, 3.0


@kernel(inline=True)
def _held(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)


@kernel(inline=True)
def wheel_speeds(u: float, v: float, w: float, body: F64, chassis: F64) -> tuple[float, float]:
    """Mean and largest of the wheels' speeds [m/s].

    A steered wheel rolls the way it moves; a skidding one rolls forward and is dragged sideways.
    """
    half = 0.5 * chassis[TRACK]
    if body[STEERING] == TWO_AXIS or w == 0.0:
        fast = np.sqrt(u * u + v * v)
        return fast, fast
    if body[STEERING] == SKID:
        left, right = abs(u - half * w), abs(u + half * w)
        return 0.5 * (left + right), max(left, right)
    total, most, wheels = 0.0, 0.0, 0
    for axle in range(3):
        if axle == 1 and chassis[SUSPENSION] != ROCKER_BOGIE:
            continue
        x = chassis[X_ONE] if axle == 0 else (chassis[X_MID] if axle == 1 else chassis[X_END])
        across = v + w * x
        for side in range(2):
            along = u - w * (half if side == 0 else -half)
            fast = np.sqrt(along * along + across * across)
            total, most, wheels = total + fast, max(most, fast), wheels + 1
    return total / wheels, most


@kernel(inline=True)
def _crab_share(u: float, v: float, w: float, body: F64, chassis: F64) -> float:
    """The share of v and w that leaves every wheel within its steering limit."""
    steer = body[STEER]
    if steer == np.inf:
        return 1.0
    half, need = 0.5 * chassis[TRACK], 0.0
    for end in range(2):
        x = chassis[X_ONE] if end == 0 else chassis[X_END]
        need = max(need, abs(v + w * x))
    need += steer * half * abs(w)
    return 1.0 if need <= steer * abs(u) else steer * abs(u) / need


@kernel(inline=True)
def allowed(u: float, v: float, w: float, body: F64, chassis: F64) -> tuple[float, float, float]:
    """The twist nearest to the commanded one that the rover's steering and motors can do.

    Speeds are held within the rover's limits; a turn that is too tight for the steering becomes the
    tightest that it can do; a twist that would turn a wheel too fast is slowed down as a whole.
    """
    kind = body[STEERING]
    if kind == TWO_AXIS:
        return _held(u, body[SPEED]), _held(v, body[SPEED]), 0.0
    w = _held(w, body[TURN_RATE])
    if kind == CRAB:
        fast = np.sqrt(u * u + v * v)
        if fast > body[SPEED]:
            u, v = u * (body[SPEED] / fast), v * (body[SPEED] / fast)
        share = _crab_share(u, v, w, body, chassis)
        v, w = v * share, w * share
    else:
        u, v = _held(u, body[SPEED]), 0.0
    if kind == ACKERMANN:
        if abs(u) < body[OUTER] * abs(w) and abs(u) > body[INNER] * abs(w):
            w = np.sign(w) * abs(u) / body[OUTER]
        v = -w * body[AXLE]
    _, most = wheel_speeds(u, v, w, body, chassis)
    if most > body[WHEEL_SPEED]:
        slow = body[WHEEL_SPEED] / most
        u, v, w = u * slow, v * slow, w * slow
    return u, v, w


@kernel(inline=True)
def responded(old: float, target: float, limit: float, body: F64) -> tuple[float, float]:
    """A speed at the end of a part and its mean over it: first-order lag, limited acceleration.

    Without lag and limit both are the target itself.
    """
    new = target + (old - target) * body[LEFT_OVER]
    most = limit * body[PART]
    if abs(new - old) > most:
        new = old + (most if new > old else -most)
        return new, 0.5 * (old + new)
    return new, target + (old - target) * body[MEAN_LEFT]
