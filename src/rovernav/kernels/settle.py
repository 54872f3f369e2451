"""A rover's body set onto the ground: wheel by wheel, joint by joint.

Symbols: z height [m], c cell [m], r wheel radius [m], t track [m]; p, q gradient of a plane near
the ground, along and across the heading, n = sqrt(1 + p^2 + q^2); h distance of a wheel's centre
from the plane [m]; pitch (nose up) and roll (left side up) [rad]; a angle of a side's rocker and b
of its bogie against the plane [rad], H distance of a side's pivot from it [m]; (A, B, G) the
plane's normal in the rover's own axes; g = sqrt(1 - B^2).
Body axes: x forward, y left, z up, from the rover's middle at the height of its axles.

A chassis is an array (CHASSIS,) of the numbers that the constants below name. Bogies hold the two
rear wheels of a side, or, where FACE is -1, the two front ones. Derivation: docs/derivations.md.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._jit import kernel
from .surface import height_at

F32: TypeAlias = NDArray[np.float32]
F64: TypeAlias = NDArray[np.float64]

KIND, RADIUS, TRACK, X_ONE, X_MID, X_END, X_PIVOT, Z_PIVOT, X_BOGIE, Z_BOGIE = range(10)
FACE, BELLY, BELLY_REAR, BELLY_FRONT, BELLY_HALF, FRONT_HEAVY = range(10, 16)
MAX_TILT, MAX_PITCH, MAX_ROLL, MAX_ROCKER, MAX_BOGIE, MAX_STEP, LEAST_CLEARANCE = range(16, 23)
CHASSIS = 23
RIGID, AVERAGING, ROCKER_BOGIE = 0.0, 1.0, 2.0

SETTLED = 12
Z, PITCH, ROLL, TILT, ROCKER, BOGIE_LEFT, BOGIE_RIGHT, CLEARANCE, STEP, ERROR, ROUNDS, CODE = range(
    SETTLED
)
"""Columns of what `settle` writes; heights [m], angles [rad]."""
SAFE, NO_GROUND, TILTED, STRETCHED, GROUNDED, STEPPED, UNPROVEN = range(7)
"""Codes: no data under it, too much tilt, joints beyond their limits, belly too near, too high a
step under a wheel, and (the bound only) nothing could be shown."""

_MOST, _EASY, _CLOSE = 60, 12, 1e-7
_REACH = 0.999999


@kernel()
def wheel_places(
    chassis: F64, rocker: float, bogie_left: float, bogie_right: float, at: F64
) -> None:
    """Write where the wheels are in body axes to `at` (6, 3), left side first.

    On each side come the wheel on the rocker, the middle wheel and the end of the bogie; four
    wheels are the first and third of each side.
    """
    for side in range(2):
        turn = rocker if side == 0 else -rocker
        cos, sin = np.cos(turn), np.sin(turn)
        xp, zp = chassis[X_PIVOT], chassis[Z_PIVOT]
        y = 0.5 * chassis[TRACK] if side == 0 else -0.5 * chassis[TRACK]
        for k in range(3):
            at[3 * side + k, 1] = y
        dx, dz = chassis[X_ONE] - xp, -zp
        at[3 * side, 0], at[3 * side, 2] = xp + dx * cos - dz * sin, zp + dx * sin + dz * cos
        if chassis[KIND] != ROCKER_BOGIE:
            dx = chassis[X_END] - xp
            at[3 * side + 2, 0] = xp + dx * cos - dz * sin
            at[3 * side + 2, 2] = zp + dx * sin + dz * cos
            at[3 * side + 1, 0], at[3 * side + 1, 2] = at[3 * side, 0], at[3 * side, 2]
            continue
        dx, dz = chassis[X_BOGIE] - xp, chassis[Z_BOGIE] - zp
        xb, zb = xp + dx * cos - dz * sin, zp + dx * sin + dz * cos
        turn = bogie_left if side == 0 else bogie_right
        cos, sin = np.cos(turn), np.sin(turn)
        for k in range(1, 3):
            dx, dz = chassis[X_ONE + k] - chassis[X_BOGIE], -chassis[Z_BOGIE]
            at[3 * side + k, 0] = xb + dx * cos - dz * sin
            at[3 * side + k, 2] = zb + dx * sin + dz * cos


@kernel(inline=True)
def _rise(high: float, low: float, long: float) -> float:
    """Sine of an arm's angle from the heights of its ends, held within what an arm can do."""
    return min(max((high - low) / long, -_REACH), _REACH)


@kernel(inline=True)
def _side(chassis: F64, h: F64, first: int, g: float) -> tuple[float, ...]:
    """Sine and cosine of a, sine of b, pivot height H [m] of the side of wheels `first` and on.

    Forward is towards the wheel on the rocker: a and b are mirrored where FACE is -1.
    """
    face = chassis[FACE]
    one, mid, end = h[first], h[first + 1], h[first + 2]
    xp, zp = face * chassis[X_PIVOT], chassis[Z_PIVOT]
    x_one, x_end = face * chassis[X_ONE], face * chassis[X_END]
    if chassis[KIND] == AVERAGING:
        sin = _rise(one, end, g * (x_one - x_end))
        cos, share = np.sqrt(1.0 - sin * sin), (xp - x_end) / (x_one - x_end)
        return sin, cos, sin, share * one + (1.0 - share) * end + g * zp * cos
    xb, zb, x_mid = face * chassis[X_BOGIE], chassis[Z_BOGIE], face * chassis[X_MID]
    sin_b = _rise(mid, end, g * (x_mid - x_end))
    share = (xb - x_end) / (x_mid - x_end)
    joint = share * mid + (1.0 - share) * end + g * zb * np.sqrt(1.0 - sin_b * sin_b)
    arm = x_one - xb
    long = np.sqrt(arm * arm + zb * zb)
    sin_u = _rise(one, joint, g * long)
    cos_u = np.sqrt(1.0 - sin_u * sin_u)
    sin, cos = (sin_u * arm + cos_u * zb) / long, (cos_u * arm - sin_u * zb) / long
    return sin, cos, sin_b, joint + g * ((xp - xb) * sin + (zp - zb) * cos)


@kernel(inline=True)
def _out_of_reach(chassis: F64, h: F64, first: int, g: float) -> bool:
    """Whether an arm of the side is too short for the heights of its wheels."""
    sin, cos, sin_b, _ = _side(chassis, h, first, g)
    if chassis[KIND] == AVERAGING:
        return abs(sin) >= _REACH
    arm, zb = chassis[FACE] * (chassis[X_ONE] - chassis[X_BOGIE]), chassis[Z_BOGIE]
    sin_u = (sin * arm - cos * zb) / np.sqrt(arm * arm + zb * zb)
    return abs(sin_b) >= _REACH or abs(sin_u) >= _REACH - 1e-9


@kernel()
def _rigid(chassis: F64, h: F64) -> tuple[float, ...]:
    """A, B and z of four wheels on one board: the higher diagonal, then the heavier end."""
    base = chassis[X_ONE] - chassis[X_END]
    left, right = (h[0] - h[2]) / base, (h[3] - h[5]) / base
    if chassis[FRONT_HEAVY] > 0.0:
        a, x = min(left, right), chassis[X_ONE]
        return a, (h[0] - h[3]) / chassis[TRACK], 0.5 * (h[0] + h[3]) - x * a
    a, x = max(left, right), chassis[X_END]
    return a, (h[2] - h[5]) / chassis[TRACK], 0.5 * (h[2] + h[5]) - x * a


@kernel()
def attitude(chassis: F64, h: F64, across: float) -> tuple[float, ...]:
    """A, B, z, rocker, left and right bogie for wheel heights (6,); then 1 if all reach so far.

    Exact: the wheels of a body with those numbers are as high as `h`. `across` is a guess of B.
    """
    if chassis[KIND] == RIGID:
        up_x, up_y, z = _rigid(chassis, h)
        reach = 1.0 if up_x * up_x + up_y * up_y < _REACH else 0.0
        if reach == 0.0:
            shrink = np.sqrt(_REACH / (up_x * up_x + up_y * up_y))
            up_x, up_y = up_x * shrink, up_y * shrink
        return up_x, up_y, z, 0.0, 0.0, 0.0, reach
    g = np.sqrt(1.0 - across * across)
    sin_l, cos_l, bogie_l, left = _side(chassis, h, 0, g)
    sin_r, cos_r, bogie_r, right = _side(chassis, h, 3, g)
    for _ in range(40):
        before, across = across, _rise(left, right, chassis[TRACK])
        if abs(across - before) < 1e-13:
            break
        g = np.sqrt(1.0 - across * across)
        sin_l, cos_l, bogie_l, left = _side(chassis, h, 0, g)
        sin_r, cos_r, bogie_r, right = _side(chassis, h, 3, g)
    lost = _out_of_reach(chassis, h, 0, g) or _out_of_reach(chassis, h, 3, g)
    reach = 0.0 if lost or abs(across) >= _REACH else 1.0
    face = chassis[FACE]
    a_left, a_right = face * np.arctan2(sin_l, cos_l), face * np.arctan2(sin_r, cos_r)
    mean = 0.5 * (a_left + a_right)
    up_x, up = g * np.sin(mean), g * np.cos(mean)
    z = 0.5 * (left + right) - chassis[X_PIVOT] * up_x - chassis[Z_PIVOT] * up
    bogie_left = bogie_right = 0.0
    if chassis[KIND] == ROCKER_BOGIE:
        bogie_left = face * np.arcsin(bogie_l) - mean
        bogie_right = face * np.arcsin(bogie_r) - mean
    return up_x, across, z, 0.5 * (a_left - a_right), bogie_left, bogie_right, reach


@kernel(inline=True)
def pitch_and_roll(a: float, b: float, p: float, q: float) -> tuple[float, float]:
    """Pitch and roll [rad] of a body at A, B to a plane that rises by p ahead and q to the left."""
    n = np.sqrt(1.0 + p * p + q * q)
    long = np.sqrt(1.0 + p * p)
    lean = np.arcsin(min(max(n * a / long, -1.0), 1.0))
    k = long * np.cos(lean)
    tip = np.arcsin(min(max(n * b / np.sqrt(k * k + q * q), -1.0), 1.0))
    return np.arctan(p) + lean, np.arctan2(q, k) + tip


@kernel()
def settle_one(
    wheel: F32, gradient: F32, c: float, chassis: F64, pose: F64, room: tuple[F64, F64], out: F64
) -> None:
    """Write the attitude of one rover to `out` (SETTLED,); `room` is for (6, 3) and (6,).

    Where the wheels touch depends on the attitude, and the attitude on where they touch: found by
    turns, beginning with a body flush with the plane of the ground about it. From round 12 on a
    step goes half the way only.
    """
    at, h = room
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    east, north = (
        height_at(gradient[0], c, pose[0], pose[1]),
        height_at(gradient[1], c, pose[0], pose[1]),
    )
    if not (east == east and north == north):
        east = north = 0.0
    p, q = east * cos + north * sin, north * cos - east * sin
    n = np.sqrt(1.0 + p * p + q * q)
    pitch, roll = pitch_and_roll(0.0, 0.0, p, q)
    rocker = bogie_left = bogie_right = across = 0.0
    z, reach, error, rounds = np.nan, 1.0, np.inf, 0
    while rounds < _MOST and error > _CLOSE:
        wheel_places(chassis, rocker, bogie_left, bogie_right, at)
        cp, sp, cr, sr = np.cos(pitch), np.sin(pitch), np.cos(roll), np.sin(roll)
        for k in range(6):
            x = cp * at[k, 0] - sp * (sr * at[k, 1] + cr * at[k, 2])
            y = cr * at[k, 1] - sr * at[k, 2]
            up = height_at(wheel, c, pose[0] + cos * x - sin * y, pose[1] + sin * x + cos * y)
            h[k] = (up - p * x - q * y) / n
        now = attitude(chassis, h, across)
        across, z, reach = now[1], now[2], now[6]
        if z != z:
            break
        new_pitch, new_roll = pitch_and_roll(now[0], now[1], p, q)
        error = max(abs(new_pitch - pitch), abs(new_roll - roll), abs(now[3] - rocker))
        error = max(error, abs(now[4] - bogie_left), abs(now[5] - bogie_right))
        share = 1.0 if rounds < _EASY or error <= _CLOSE or rounds == _MOST - 1 else 0.5
        pitch, roll = pitch + share * (new_pitch - pitch), roll + share * (new_roll - roll)
        rocker = rocker + share * (now[3] - rocker)
        bogie_left = bogie_left + share * (now[4] - bogie_left)
        bogie_right = bogie_right + share * (now[5] - bogie_right)
        rounds += 1
    out[Z], out[PITCH], out[ROLL], out[ROCKER] = z * n, pitch, roll, rocker
    out[TILT] = np.arccos(min(1.0, np.cos(pitch) * np.cos(roll)))
    out[BOGIE_LEFT], out[BOGIE_RIGHT] = bogie_left, bogie_right
    out[ERROR], out[ROUNDS] = error, rounds
    out[CODE] = NO_GROUND if z != z else (SAFE if reach > 0.0 else STRETCHED)


@kernel(inline=True)
def _part(low: float, high: float, at: float, one_over: float, span: float) -> tuple[float, float]:
    """The part of [low, high] where |at + x / one_over| <= span; low above high where none."""
    if abs(one_over) > 1e9:
        return (low, high) if abs(at) <= span else (1.0, 0.0)
    a, b = (-span - at) * one_over, (span - at) * one_over
    return max(low, min(a, b)), min(high, max(a, b))


@kernel()
def clearance_of(ground: F32, c: float, chassis: F64, pose: F64, out: F64) -> float:
    """Least distance of the belly from the ground [m], square to the belly; NaN without data.

    Over every post under the belly's rectangle and nine points of a lattice across it.
    """
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    cp, sp, cr, sr = np.cos(out[PITCH]), np.sin(out[PITCH]), np.cos(out[ROLL]), np.sin(out[ROLL])
    rear, front, half = chassis[BELLY_REAR], chassis[BELLY_FRONT], chassis[BELLY_HALF]
    up = chassis[BELLY]
    least = np.inf
    west = east = pose[0]
    south = north = pose[1]
    for n in range(9):
        bx = 0.5 * (rear + front) + 0.5 * (front - rear) * (n // 3 - 1)
        by = half * (n % 3 - 1)
        x, y = cp * bx - sp * (sr * by + cr * up), cr * by - sr * up
        px, py = pose[0] + cos * x - sin * y, pose[1] + sin * x + cos * y
        west, east, south, north = min(west, px), max(east, px), min(south, py), max(north, py)
        gap = out[Z] + sp * bx + cp * (sr * by + cr * up) - height_at(ground, c, px, py)
        least = min(least, gap) if gap == gap else np.nan
        if gap != gap:
            return np.nan
    # Belly coordinates and the belly's height are linear along a row of posts, at x = pose + px:
    # by = (cos py - sin px + sr up) / cr and bx = (cos px + sin py + sp (sr by + cr up)) / cp.
    rows, columns = ground.shape
    flat, steep, per = 1.0 / cr, 1.0 / cp, 1.0 / c
    by_x = -sin * flat
    bx_x = (cos + sp * sr * by_x) * steep
    up_x = sp * bx_x + cp * sr * by_x
    one_by = 1.0 / by_x if abs(by_x) > 1e-12 else 1e12
    one_bx = 1.0 / bx_x if abs(bx_x) > 1e-12 else 1e12
    middle, long = 0.5 * (rear + front), 0.5 * (front - rear)
    total = 0.0
    for i in range(max(0, int(south / c - 0.5)), min(rows, int(north / c + 0.5) + 1)):
        py = (i + 0.5) * c - pose[1]
        by = (cos * py + sr * up) * flat
        bx = (sin * py + sp * (sr * by + cr * up)) * steep
        low, high = west - pose[0], east - pose[0]
        low, high = _part(low, high, bx - middle, one_bx, long)
        low, high = _part(low, high, by, one_by, half)
        first = max(0, int(np.ceil((low + pose[0]) * per - 0.5)))
        last = min(columns - 1, int(np.floor((high + pose[0]) * per - 0.5)))
        level = out[Z] + sp * bx + cp * (sr * by + cr * up) + up_x * (0.5 * c - pose[0])
        for j in range(first, last + 1):
            gap = level + up_x * c * j - ground[i, j]
            total += gap
            least = min(least, gap)
    if total != total:
        return np.nan
    return least * cp * cr


@kernel()
def step_under(step: F32, c: float, chassis: F64, pose: F64, at: F64, out: F64) -> float:
    """Highest step at the four posts around each wheel [m]; NaN without data."""
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    cp, sp, cr, sr = np.cos(out[PITCH]), np.sin(out[PITCH]), np.cos(out[ROLL]), np.sin(out[ROLL])
    rows, columns = step.shape
    wheel_places(chassis, out[ROCKER], out[BOGIE_LEFT], out[BOGIE_RIGHT], at)
    highest = 0.0
    for k in range(6):
        x = cp * at[k, 0] - sp * (sr * at[k, 1] + cr * at[k, 2])
        y = cr * at[k, 1] - sr * at[k, 2]
        j = int(np.floor((pose[0] + cos * x - sin * y) / c - 0.5))
        i = int(np.floor((pose[1] + sin * x + cos * y) / c - 0.5))
        for di in range(2):
            for dj in range(2):
                value = step[min(max(i + di, 0), rows - 1), min(max(j + dj, 0), columns - 1)]
                if value != value:
                    return np.nan
                highest = max(highest, value)
    return highest


@kernel()
def verdict(chassis: F64, out: F64) -> float:
    """The code of a settled body: the first of its limits that it breaks."""
    if out[CODE] == NO_GROUND or out[CLEARANCE] != out[CLEARANCE] or out[STEP] != out[STEP]:
        return NO_GROUND
    tilted = out[TILT] > chassis[MAX_TILT] or abs(out[PITCH]) > chassis[MAX_PITCH]
    if tilted or abs(out[ROLL]) > chassis[MAX_ROLL]:
        return TILTED
    bogie = max(abs(out[BOGIE_LEFT]), abs(out[BOGIE_RIGHT]))
    stretched = out[CODE] == STRETCHED or bogie > chassis[MAX_BOGIE]
    if stretched or abs(out[ROCKER]) > chassis[MAX_ROCKER]:
        return STRETCHED
    if out[CLEARANCE] < chassis[LEAST_CLEARANCE]:
        return GROUNDED
    return STEPPED if out[STEP] > chassis[MAX_STEP] else SAFE


@kernel()
def settle(
    wheel: F32, gradient: F32, ground: F32, step: F32, c: float, chassis: F64, poses: F64, out: F64
) -> None:
    """Settle a rover at each of `poses` (n, 3) [m, m, rad]; writes `out` (n, SETTLED).

    `wheel` (h, w) is what `wheel_centres` wrote, `gradient` (2, h, w) the ground's slope to the
    east and north over about a rover's length, `step` (h, w) the ledges within a wheel.
    """
    room = (np.empty((6, 3)), np.empty(6))
    for n in range(len(poses)):
        row = out[n]
        settle_one(wheel, gradient, c, chassis, poses[n], room, row)
        if row[CODE] == NO_GROUND:
            row[:] = np.nan
            row[ROUNDS], row[CODE] = 0.0, NO_GROUND
            continue
        row[CLEARANCE] = clearance_of(ground, c, chassis, poses[n], row)
        row[STEP] = step_under(step, c, chassis, poses[n], room[0], row)
        row[CODE] = verdict(chassis, row)
