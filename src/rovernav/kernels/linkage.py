"""Bounds of joints, attitude and belly from bounds of the heights of a rover's wheels.

Symbols as in `settle`; an interval is a pair. A `box` (BOX, 2) holds intervals that hold the
attitude and joints of every round of `settle`, in the order of the constants below.
Derivation: docs/derivations.md.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from . import settle as s
from ._jit import kernel
from .intervals import (
    Span,
    arcsines,
    cosines,
    least,
    most,
    over,
    plus,
    scaled,
    sines,
    times,
    turned,
)
from .settle import AVERAGING, RIGID, ROCKER_BOGIE

F64: TypeAlias = NDArray[np.float64]

BOX = 5
PITCH, ROLL, ROCKER, LEFT, RIGHT = range(BOX)
_UNLEVEL = 0.3
"""Sine of the sideways angle between body and plane beyond which nothing is tried."""


@kernel()
def wheel_boxes(chassis: F64, box: F64, at: F64) -> None:
    """Where the wheels can be, seen from above in the heading's axes: `at` (6, 4) x and y."""
    xp, zp = chassis[s.X_PIVOT], chassis[s.Z_PIVOT]
    pitch, roll = (box[PITCH, 0], box[PITCH, 1]), (box[ROLL, 0], box[ROLL, 1])
    cp, sp, cr, sr = cosines(pitch), sines(pitch), cosines(roll), sines(roll)
    for side in range(2):
        turn = (box[ROCKER, 0], box[ROCKER, 1])
        if side == 1:
            turn = (-turn[1], -turn[0])
        cos, sin = cosines(turn), sines(turn)
        hang = (box[LEFT + side, 0], box[LEFT + side, 1])
        cos_b, sin_b = cosines(hang), sines(hang)
        y = 0.5 * chassis[s.TRACK] if side == 0 else -0.5 * chassis[s.TRACK]
        for k in range(3):
            from_x, from_z = chassis[s.X_ONE + k] - xp, -zp
            if chassis[s.KIND] == ROCKER_BOGIE and k > 0:
                from_x, from_z = chassis[s.X_BOGIE] - xp, chassis[s.Z_BOGIE] - zp
            u0, u1, v0, v1 = turned((from_x, from_x), (from_z, from_z), cos, sin)
            x, z = (xp + u0, xp + u1), (zp + v0, zp + v1)
            if chassis[s.KIND] == ROCKER_BOGIE and k > 0:
                dx, dz = chassis[s.X_ONE + k] - chassis[s.X_BOGIE], -chassis[s.Z_BOGIE]
                u0, u1, v0, v1 = turned((dx, dx), (dz, dz), cos_b, sin_b)
                x, z = (x[0] + u0, x[1] + u1), (z[0] + v0, z[1] + v1)
            down = plus(scaled(y, sr), times(cr, z))
            ahead, back = times(cp, x), times(sp, down)
            at[3 * side + k, 0], at[3 * side + k, 1] = ahead[0] - back[1], ahead[1] - back[0]
            level, over = scaled(y, cr), times(sr, z)
            at[3 * side + k, 2], at[3 * side + k, 3] = level[0] - over[1], level[1] - over[0]


@kernel(inline=True)
def _angle(rise: Span, g: Span, long: float) -> Span:
    """Sines of the angle of an arm for the rise between its ends, divided by g times its length."""
    return over(rise, (long * g[0], long * g[1]))


@kernel()
def _side(chassis: F64, h: F64, first: int, g: Span, out: F64) -> bool:
    """Bounds of one side from its wheels' heights; False where a wheel may be out of reach.

    Writes to `out` (6, 2): a, b, H, g cos a, g cos b, H of the joint of the bogie; a and b forward
    to the wheel on the rocker.
    """
    face = chassis[s.FACE]
    one = (h[first, 0], h[first, 1])
    mid = (h[first + 1, 0], h[first + 1, 1])
    end = (h[first + 2, 0], h[first + 2, 1])
    xp, zp = face * chassis[s.X_PIVOT], chassis[s.Z_PIVOT]
    x_one, x_end = face * chassis[s.X_ONE], face * chassis[s.X_END]
    if chassis[s.KIND] == AVERAGING:
        sin = _angle((one[0] - end[1], one[1] - end[0]), g, x_one - x_end)
        if sin[0] < -0.99 or sin[1] > 0.99:
            return False
        a, share = arcsines(sin), (xp - x_end) / (x_one - x_end)
        gc = times(g, cosines(a))
        pivot = plus(plus(scaled(share, one), scaled(1.0 - share, end)), scaled(zp, gc))
        out[0, 0], out[0, 1], out[2, 0], out[2, 1] = a[0], a[1], pivot[0], pivot[1]
        out[3, 0], out[3, 1], out[1, 0], out[1, 1] = gc[0], gc[1], 0.0, 0.0
        return True
    xb, zb, x_mid = face * chassis[s.X_BOGIE], chassis[s.Z_BOGIE], face * chassis[s.X_MID]
    sin = _angle((mid[0] - end[1], mid[1] - end[0]), g, x_mid - x_end)
    if sin[0] < -0.99 or sin[1] > 0.99:
        return False
    b, share = arcsines(sin), (xb - x_end) / (x_mid - x_end)
    gc_b = times(g, cosines(b))
    joint = plus(plus(scaled(share, mid), scaled(1.0 - share, end)), scaled(zb, gc_b))
    arm = x_one - xb
    sin = _angle((one[0] - joint[1], one[1] - joint[0]), g, np.sqrt(arm * arm + zb * zb))
    if sin[0] < -0.99 or sin[1] > 0.99:
        return False
    a, tip = arcsines(sin), np.arctan2(zb, arm)
    a = (a[0] + tip, a[1] + tip)
    if a[0] < -1.4 or a[1] > 1.4:
        return False
    gc = times(g, cosines(a))
    lever = (xp - xb) / arm
    pivot = plus(scaled(1.0 - lever, joint), scaled(lever, one))
    pivot = plus(pivot, scaled(lever * zb + zp - zb, gc))
    for k in range(2):
        out[0, k], out[1, k], out[2, k], out[3, k] = a[k], b[k], pivot[k], gc[k]
        out[4, k], out[5, k] = gc_b[k], joint[k]
    return True


@kernel()
def _lowest_side(chassis: F64, h: F64, first: int, weight: float, x: float, side: F64) -> float:
    """Least of weight H + (x - pivot) g sin(a) / 2 over one side's wheel heights [m].

    Written as a sum over the wheels: what one wheel adds to H it may take from sin(a).
    """
    face = chassis[s.FACE]
    xp, zp = face * chassis[s.X_PIVOT], chassis[s.Z_PIVOT]
    x_one, x_end = face * chassis[s.X_ONE], face * chassis[s.X_END]
    one, end = (h[first, 0], h[first, 1]), (h[first + 2, 0], h[first + 2, 1])
    gc = (side[3, 0], side[3, 1])
    if chassis[s.KIND] == AVERAGING:
        share, k = (xp - x_end) / (x_one - x_end), 0.5 * (x - xp) / (x_one - x_end)
        low = scaled(weight * share + k, one)[0] + scaled(weight * (1.0 - share) - k, end)[0]
        return low + scaled(weight * zp, gc)[0]
    xb, zb, x_mid = face * chassis[s.X_BOGIE], chassis[s.Z_BOGIE], face * chassis[s.X_MID]
    mid, gc_b = (h[first + 1, 0], h[first + 1, 1]), (side[4, 0], side[4, 1])
    share, arm = (xb - x_end) / (x_mid - x_end), x_one - xb
    lever, k = (xp - xb) / arm, 0.5 * (x - xp) / arm
    joint = weight * (1.0 - lever) - k
    low = scaled(weight * lever + k, one)[0]
    low += scaled(joint * share, mid)[0] + scaled(joint * (1.0 - share), end)[0]
    low += scaled(joint * zb, gc_b)[0]
    return low + scaled(weight * (lever * zb + zp - zb) + k * zb, gc)[0]


@kernel()
def relative(chassis: F64, h: F64, sides: F64, box: F64) -> tuple[float, ...]:
    """Bounds of the body against the plane from bounds of wheel heights `h` (6, 2).

    Writes the joints' rows of `box` and all of `sides` (2, 6, 2). Returns the ends of A and B of
    the body against the plane, of g cos(mean a), the largest rocker angle, then 1 if in reach.
    """
    track = chassis[s.TRACK]
    if chassis[s.KIND] == RIGID:
        base = chassis[s.X_ONE] - chassis[s.X_END]
        left = (h[0, 0] - h[2, 1]) / base, (h[0, 1] - h[2, 0]) / base
        right = (h[3, 0] - h[5, 1]) / base, (h[3, 1] - h[5, 0]) / base
        if chassis[s.FRONT_HEAVY] > 0.0:
            a = min(left[0], right[0]), min(left[1], right[1])
            b = (h[0, 0] - h[3, 1]) / track, (h[0, 1] - h[3, 0]) / track
        else:
            a = max(left[0], right[0]), max(left[1], right[1])
            b = (h[2, 0] - h[5, 1]) / track, (h[2, 1] - h[5, 0]) / track
        ok = 1.0 if most(a) < _UNLEVEL and most(b) < _UNLEVEL else 0.0
        return a[0], a[1], b[0], b[1], 0.0, 0.0, 0.0, ok
    g, b = (np.sqrt(1.0 - _UNLEVEL * _UNLEVEL), 1.0), (0.0, 0.0)
    for _ in range(2):
        for side in range(2):
            if not _side(chassis, h, 3 * side, g, sides[side]):
                return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        b = (sides[0, 2, 0] - sides[1, 2, 1]) / track, (sides[0, 2, 1] - sides[1, 2, 0]) / track
        if most(b) > _UNLEVEL:
            return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        g = np.sqrt(1.0 - most(b) ** 2), np.sqrt(1.0 - least(b) ** 2)
    face = chassis[s.FACE]
    left, right = (sides[0, 0, 0], sides[0, 0, 1]), (sides[1, 0, 0], sides[1, 0, 1])
    mean = scaled(0.5 * face, plus(left, right))
    rocker = scaled(0.5 * face, (left[0] - right[1], left[1] - right[0]))
    box[ROCKER, 0], box[ROCKER, 1] = rocker
    if chassis[s.KIND] == ROCKER_BOGIE:
        for side in range(2):
            b_side = scaled(face, (sides[side, 1, 0], sides[side, 1, 1]))
            box[LEFT + side, 0], box[LEFT + side, 1] = b_side[0] - mean[1], b_side[1] - mean[0]
    a, up = times(g, sines(mean)), times(g, cosines(mean))
    return a[0], a[1], b[0], b[1], up[0], up[1], most(rocker), 1.0


@kernel()
def _lowest_board(chassis: F64, h: F64, x: float, y: float) -> float:
    """Least height over the plane of a rigid body's point (x, y) [m].

    The board lies on one axle and the side wheel that the slope of the other side leaves it: of
    two planes the higher between the axles, the lower beyond the one that carries.
    """
    front = chassis[s.FRONT_HEAVY] > 0.0
    k, other = (0, 2) if front else (2, 0)
    near = chassis[s.X_ONE] if front else chassis[s.X_END]
    base = chassis[s.X_ONE] - chassis[s.X_END]
    tip = (near - x) / base if front else (x - near) / base
    best = np.inf if tip < 0.0 else -np.inf
    for side in range(2):
        low = scaled(tip, (h[3 * side + other, 0], h[3 * side + other, 1]))[0]
        for which in range(2):
            weight = 0.5 + y / chassis[s.TRACK] * (1.0 - 2.0 * which)
            weight -= tip if which == side else 0.0
            low += scaled(weight, (h[3 * which + k, 0], h[3 * which + k, 1]))[0]
        best = min(best, low) if tip < 0.0 else max(best, low)
    return best


@kernel()
def lowest_body(chassis: F64, h: F64, sides: F64, at: Span, rel: tuple[float, ...]) -> float:
    """Least height over the plane of the body's point `at`, level with its axles [m]."""
    x, y = at
    if chassis[s.KIND] == RIGID:
        return _lowest_board(chassis, h, x, y)
    face, share = chassis[s.FACE], y / chassis[s.TRACK]
    low = _lowest_side(chassis, h, 0, 0.5 + share, face * x, sides[0])
    low += _lowest_side(chassis, h, 3, 0.5 - share, face * x, sides[1])
    steep = max(most((sides[0, 0, 0], sides[0, 0, 1])), most((sides[1, 0, 0], sides[1, 0, 1])))
    # The mean of two sines is the sine of the mean times the cosine of half their difference.
    low -= abs(x - chassis[s.X_PIVOT]) * (1.0 / np.cos(rel[6]) - 1.0) * np.sin(min(steep, 1.5))
    return low + scaled(-chassis[s.Z_PIVOT], (rel[4], rel[5]))[0]


@kernel()
def absolute(a: Span, b: Span, along: Span, across: Span, n: float) -> tuple[float, ...]:
    """Ends of pitch and roll for a body at A, B to a plane of such gradients in its heading."""
    long = np.sqrt(1.0 + least(along) ** 2), np.sqrt(1.0 + most(along) ** 2)
    lean = arcsines(over(scaled(n, a), long))
    pitch = plus((np.arctan(along[0]), np.arctan(along[1])), lean)
    k = times(long, cosines(lean))
    tip = over(across, k)
    wide = np.sqrt(k[0] ** 2 + least(across) ** 2), np.sqrt(k[1] ** 2 + most(across) ** 2)
    lean = arcsines(over(scaled(n, b), wide))
    roll = plus((np.arctan(tip[0]), np.arctan(tip[1])), lean)
    return pitch[0], pitch[1], roll[0], roll[1]
