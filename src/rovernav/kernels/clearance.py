"""What can be said of a rover's body without settling it: bounds that hold for a box of poses.

In the manner of K. Otsu and others, Fast approximate clearance evaluation for rovers with
articulated suspension systems, J. Field Robotics (2020): from the lowest and highest that each
wheel can stand come bounds of joints, attitude and clearance. Ours, written from the abstract's
idea, differs in what it subtracts first and in what it proves; docs/derivations.md has both.

Symbols: P, Q gradient of a plane near the ground to the east and north, N = sqrt(1 + P^2 + Q^2);
others as in `settle`. Heights are counted from the plane and divided by N, so that the plane's
normal stands in for the vertical.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from . import settle as s
from ._jit import kernel
from .intervals import (
    cosines,
    highest_step,
    least,
    most,
    on_the_map,
    over,
    plus,
    range_over,
    scaled,
    sines,
    times,
    turned,
)
from .linkage import BOX, LEFT, PITCH, ROLL, absolute, lowest_body, relative, wheel_boxes
from .settle import ROCKER_BOGIE
from .surface import height_at

F32: TypeAlias = NDArray[np.float32]
F64: TypeAlias = NDArray[np.float64]


PLANE = 11
_X, _Y, _LEVEL, _P, _Q, _N, _SPREAD, _ALONG, _, _ACROSS, _ = range(PLANE)
"""The plane that is counted from: a point, gradient, N, how far the gradient that `settle` takes
may be from it, and the ends of the gradient along and across all headings in doubt."""

BOUND = 11
TILT, PITCH_LOW, PITCH_HIGH, ROLL_LOW, ROLL_HIGH, ROCKER, BOGIE = range(7)
CLEARANCE, STEP, ROUNDS, CODE = range(7, BOUND)
"""Columns of what `bound` writes: the most of tilt, joint angles and step, the least clearance."""

_COLUMN = (s.PITCH, s.ROLL, s.ROCKER, s.BOGIE_LEFT, s.BOGIE_RIGHT)
_MOST, _WIDER, _TINY = 6, 0.15, 1e-6


@kernel()
def _clearance(
    ground: F32, c: float, chassis: F64, box: F64, pose: F64, doubt: F64, plane: F64, lows: F64
) -> float:
    """Least clearance of the belly [m]; `lows` (4, 3) has its lowest over the plane at its knots.

    The belly is cut into 3 x 2 tiles: the highest ground below a tile meets the lowest that tile.
    """
    rear, front, half = chassis[s.BELLY_REAR], chassis[s.BELLY_FRONT], chassis[s.BELLY_HALF]
    up, flat = chassis[s.BELLY], (plane[_X], plane[_Y], plane[_LEVEL], plane[_P], plane[_Q])
    pitch, roll = (box[PITCH, 0], box[PITCH, 1]), (box[ROLL, 0], box[ROLL, 1])
    cp, sp, cr, sr = cosines(pitch), sines(pitch), cosines(roll), sines(roll)
    long, wide, gap = (front - rear) / 3.0, half, np.inf
    for i in range(3):
        x = rear + i * long, rear + (i + 1) * long
        for j in range(2):
            y = -half + j * wide, -half + (j + 1) * wide
            down = plus(times(sr, y), scaled(up, cr))
            ahead, back = times(cp, x), times(sp, down)
            level, over_it = times(cr, y), scaled(up, sr)
            area = on_the_map(
                (ahead[0] - back[1], ahead[1] - back[0]),
                (level[0] - over_it[1], level[1] - over_it[0]),
                pose, doubt,
            )  # fmt: skip
            top = range_over(ground, c, area, flat)[1]
            if top != top:
                return np.nan
            low = min(min(lows[i, j], lows[i, j + 1]), min(lows[i + 1, j], lows[i + 1, j + 1]))
            gap = min(gap, low - top)
    return gap * (cp[0] * cr[0] if gap > 0.0 else 1.0) - _TINY


@kernel()
def _plane_under(wheel: F32, gradient: F32, c: float, pose: F64, doubt: F64, plane: F64) -> bool:
    """Write the plane that the bound counts from to `plane` (PLANE,); False off known ground."""
    x, y = pose[0], pose[1]
    plane[_X], plane[_Y] = x, y
    plane[_LEVEL] = height_at(wheel, c, x, y)
    area = (x - doubt[0], x + doubt[0], y - doubt[0], y + doubt[0])
    zero = (0.0, 0.0, 0.0, 0.0, 0.0)
    cos, sin, spread = np.cos(pose[2]), np.sin(pose[2]), 0.0
    for k in range(2):
        plane[_P + k] = height_at(gradient[k], c, x, y)
        low, high = range_over(gradient[k], c, area, zero)
        if low != low:
            return False
        spread += max(high - plane[_P + k], plane[_P + k] - low) ** 2
    plane[_SPREAD], plane[_N] = np.sqrt(spread), np.sqrt(1.0 + plane[_P] ** 2 + plane[_Q] ** 2)
    along, across = plane[_P] * cos + plane[_Q] * sin, plane[_Q] * cos - plane[_P] * sin
    turn = (-doubt[1], doubt[1])
    a0, a1, b0, b1 = turned((along, along), (-across, -across), cosines(turn), sines(turn))
    plane[_ALONG], plane[_ALONG + 1], plane[_ACROSS], plane[_ACROSS + 1] = a0, a1, -b1, -b0
    return plane[_LEVEL] == plane[_LEVEL]


@kernel()
def _first_box(plane: F64, settled: F64, box: F64) -> None:
    """A box that holds the middle's settled body and all that settling may begin with."""
    a = plane[_ALONG] - plane[_SPREAD], plane[_ALONG + 1] + plane[_SPREAD]
    b = plane[_ACROSS] - plane[_SPREAD], plane[_ACROSS + 1] + plane[_SPREAD]
    long = np.sqrt(1.0 + least(a) ** 2), np.sqrt(1.0 + most(a) ** 2)
    tip = over(b, long)
    for k in range(BOX):
        box[k, 0] = box[k, 1] = 0.0
    box[PITCH, 0], box[PITCH, 1] = np.arctan(a[0]), np.arctan(a[1])
    box[ROLL, 0], box[ROLL, 1] = np.arctan(tip[0]), np.arctan(tip[1])
    for k in range(BOX):
        middle = settled[_COLUMN[k]]
        box[k, 0], box[k, 1] = min(box[k, 0], middle) - 1e-6, max(box[k, 1], middle) + 1e-6


@kernel()
def _wheel_ranges(wheel: F32, c: float, pose: F64, doubt: F64, plane: F64, at: F64, h: F64) -> bool:
    """Bounds `h` (6, 2) of wheel heights over the plane; False where ground is unknown.

    A round of `settle` takes its heights where the wheels stood in the round before, over a plane
    of its own. By the difference of the planes' gradients, times the way that a wheel can move
    within its box `at` (6, 4), the heights that its body then has may differ from the ground's.
    """
    n, flat = plane[_N], (plane[_X], plane[_Y], plane[_LEVEL], plane[_P], plane[_Q])
    for k in range(6):
        x, y = (at[k, 0], at[k, 1]), (at[k, 2], at[k, 3])
        low, high = range_over(wheel, c, on_the_map(x, y, pose, doubt), flat)
        if low != low:
            return False
        slack = plane[_SPREAD] * np.sqrt((x[1] - x[0]) ** 2 + (y[1] - y[0]) ** 2)
        h[k, 0], h[k, 1] = (low - slack) / n - _TINY, (high + slack) / n + _TINY
    return True


@kernel()
def _grown(box: F64, new: F64) -> bool:
    """Whether `new` lies within `box`; otherwise `box` grows beyond both."""
    inside = True
    for k in range(BOX):
        if new[k, 0] < box[k, 0] or new[k, 1] > box[k, 1]:
            inside = False
    if not inside:
        for k in range(BOX):
            more = _WIDER * (new[k, 1] - new[k, 0]) + 1e-4
            box[k, 0] = min(box[k, 0], new[k, 0] - more)
            box[k, 1] = max(box[k, 1], new[k, 1] + more)
    return inside


@kernel()
def _judged(chassis: F64, out: F64) -> float:
    """The first limit that bounds of joints and attitude break."""
    pitch = max(abs(out[PITCH_LOW]), abs(out[PITCH_HIGH]))
    roll = max(abs(out[ROLL_LOW]), abs(out[ROLL_HIGH]))
    if out[TILT] > chassis[s.MAX_TILT] or pitch > chassis[s.MAX_PITCH]:
        return s.TILTED
    if roll > chassis[s.MAX_ROLL]:
        return s.TILTED
    if out[ROCKER] > chassis[s.MAX_ROCKER] or out[BOGIE] > chassis[s.MAX_BOGIE]:
        return s.STRETCHED
    return s.SAFE


@kernel()
def _body(chassis: F64, plane: F64, h: F64, sides: F64, new: F64, out: F64) -> tuple[float, ...]:
    """Bounds of joints and attitude from those of wheel heights, to `new` (BOX, 2) and `out`."""
    rel = relative(chassis, h, sides, new)
    if rel[7] == 0.0:
        return rel
    n = plane[_N]
    along, across = (plane[_ALONG], plane[_ALONG + 1]), (plane[_ACROSS], plane[_ACROSS + 1])
    a, b = (rel[0], rel[1]), (rel[2], rel[3])
    pitch0, pitch1, roll0, roll1 = absolute(a, b, along, across, n)
    new[PITCH, 0], new[PITCH, 1], new[ROLL, 0], new[ROLL, 1] = pitch0, pitch1, roll0, roll1
    out[PITCH_LOW], out[PITCH_HIGH], out[ROLL_LOW], out[ROLL_HIGH] = pitch0, pitch1, roll0, roll1
    steep = np.arcsin(min(1.0, np.sqrt(most(a) ** 2 + most(b) ** 2))) + np.arccos(1.0 / n)
    corner = np.cos(most((pitch0, pitch1))) * np.cos(most((roll0, roll1)))
    out[TILT] = min(steep, np.arccos(corner))
    out[ROCKER], out[BOGIE] = rel[6], 0.0
    if chassis[s.KIND] == ROCKER_BOGIE:
        for k in range(LEFT, BOX):
            out[BOGIE] = max(out[BOGIE], most((new[k, 0], new[k, 1])))
    return rel


@kernel()
def _bound_one(
    maps: tuple[F32, F32, F32, F32, float],
    chassis: F64,
    pose: F64,
    doubt: F64,
    room: tuple[F64, ...],
    settled: F64,
    out: F64,
) -> None:
    """Bounds for one pose, whose middle has `settled`; writes `out` (BOUND,)."""
    wheel, gradient, _, _, c = maps
    at, h, sides, box, new, _, plane = room
    out[:] = np.nan
    out[ROUNDS] = 0.0
    out[CODE] = settled[s.CODE] if settled[s.CODE] != s.SAFE else s.UNPROVEN
    if out[CODE] != s.UNPROVEN or settled[s.ERROR] > _TINY:
        return
    if not _plane_under(wheel, gradient, c, pose, doubt, plane):
        out[CODE] = s.NO_GROUND
        return
    _first_box(plane, settled, box)
    rel = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    proven = False
    while not proven and out[ROUNDS] < _MOST:
        out[ROUNDS] += 1.0
        new[:] = 0.0
        wheel_boxes(chassis, box, at)
        if not _wheel_ranges(wheel, c, pose, doubt, plane, at, h):
            out[CODE] = s.NO_GROUND
            return
        rel = _body(chassis, plane, h, sides, new, out)
        code = _judged(chassis, out) if rel[7] > 0.0 else s.STRETCHED
        if code != s.SAFE:  # a larger box only makes it worse
            out[CODE] = code
            return
        proven = _grown(box, new)
    if proven:
        _under(maps, chassis, pose, doubt, room, rel, out)


@kernel()
def _under(
    maps: tuple[F32, F32, F32, F32, float],
    chassis: F64,
    pose: F64,
    doubt: F64,
    room: tuple[F64, ...],
    rel: tuple[float, ...],
    out: F64,
) -> None:
    """Bounds of belly and steps, and the verdict, once the attitude's are proven."""
    _, _, ground, step, c = maps
    at, h, sides, _, new, lows, plane = room
    n = plane[_N]
    a, b = most((rel[0], rel[1])), most((rel[2], rel[3]))
    upright = np.sqrt(max(0.0, 1.0 - a * a - b * b)), 1.0
    rear, front, half = chassis[s.BELLY_REAR], chassis[s.BELLY_FRONT], chassis[s.BELLY_HALF]
    for i in range(4):
        for j in range(3):
            knot = rear + (front - rear) * i / 3.0, half * (j - 1.0)
            low = lowest_body(chassis, h, sides, knot, rel)
            lows[i, j] = n * (low + scaled(chassis[s.BELLY], upright)[0])
    out[CLEARANCE] = _clearance(ground, c, chassis, new, pose, doubt, plane, lows)
    out[STEP] = 0.0
    for k in range(6):
        area = on_the_map((at[k, 0], at[k, 1]), (at[k, 2], at[k, 3]), pose, doubt)
        highest = highest_step(step, c, area)
        out[STEP] = highest if highest != highest else max(out[STEP], highest)
        if highest != highest:
            break
    if out[CLEARANCE] != out[CLEARANCE] or out[STEP] != out[STEP]:
        out[CODE] = s.NO_GROUND
    elif out[CLEARANCE] < chassis[s.LEAST_CLEARANCE]:
        out[CODE] = s.GROUNDED
    else:
        out[CODE] = s.STEPPED if out[STEP] > chassis[s.MAX_STEP] else s.SAFE


@kernel()
def bound(
    wheel: F32, gradient: F32, ground: F32, step: F32, c: float, chassis: F64, poses: F64, out: F64
) -> None:
    """Bounds for boxes of poses (n, 5); writes `out` (n, BOUND).

    After x, y and heading of its middle a row has half the side of the square in which the rover's
    middle lies [m], its sides along the grid's, and half the range of its heading [rad]. Others as
    in `settle`.
    """
    maps = (wheel, gradient, ground, step, c)
    room = (
        np.empty((6, 4)), np.empty((6, 2)), np.empty((2, 6, 2)), np.empty((BOX, 2)),
        np.empty((BOX, 2)), np.empty((4, 3)), np.empty(PLANE),
    )  # fmt: skip
    spare, settled = (np.empty((6, 3)), np.empty(6)), np.empty(s.SETTLED)
    for n in range(len(poses)):
        settled[s.CLEARANCE], settled[s.STEP] = 1e9, 0.0
        s.settle_one(wheel, gradient, c, chassis, poses[n], spare, settled)
        if settled[s.CODE] == s.SAFE:
            settled[s.CODE] = s.verdict(chassis, settled)
        _bound_one(maps, chassis, poses[n], poses[n, 3:], room, settled, out[n])
