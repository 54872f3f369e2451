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

Turn: TypeAlias = tuple[float, float]
"""Sine and cosine of an angle."""
Arms: TypeAlias = tuple[float, float, float, float, float, float, float, float]
Side: TypeAlias = tuple[float, float, float, float, float, float]

_MOST, _EASY, _CLOSE = 60, 12, 1e-7
_REACH, _TINY = 0.999999, 1e-30


@kernel()
def wheel_places(
    chassis: F64, rocker: float, bogie_left: float, bogie_right: float, at: F64
) -> None:
    """Write where the wheels are in body axes to `at` (6, 3), left side first.

    On each side come the wheel on the rocker, the middle wheel and the end of the bogie; four
    wheels are the first and third of each side.
    """
    left, right = (
        (np.sin(bogie_left), np.cos(bogie_left)),
        (np.sin(bogie_right), np.cos(bogie_right)),
    )
    _place_wheels(chassis, (np.sin(rocker), np.cos(rocker)), left, right, at)


@kernel(inline=True)
def _place_wheels(chassis: F64, rocker: Turn, left: Turn, right: Turn, at: F64) -> None:
    """`wheel_places` from sines and cosines of the joints."""
    xp, zp = chassis[X_PIVOT], chassis[Z_PIVOT]
    half, cos = 0.5 * chassis[TRACK], rocker[1]
    six = chassis[KIND] == ROCKER_BOGIE
    for side in range(2):
        sin = rocker[0] if side == 0 else -rocker[0]
        y = half if side == 0 else -half
        dx, dz = chassis[X_ONE] - xp, -zp
        x, z = xp + dx * cos - dz * sin, zp + dx * sin + dz * cos
        at[3 * side, 0], at[3 * side, 1], at[3 * side, 2] = x, y, z
        if not six:
            at[3 * side + 1, 0], at[3 * side + 1, 1], at[3 * side + 1, 2] = x, y, z
            dx = chassis[X_END] - xp
            at[3 * side + 2, 0], at[3 * side + 2, 1] = xp + dx * cos - dz * sin, y
            at[3 * side + 2, 2] = zp + dx * sin + dz * cos
            continue
        dx, dz = chassis[X_BOGIE] - xp, chassis[Z_BOGIE] - zp
        xb, zb = xp + dx * cos - dz * sin, zp + dx * sin + dz * cos
        sin_b, cos_b = left if side == 0 else right
        for k in range(1, 3):
            dx, dz = chassis[X_ONE + k] - chassis[X_BOGIE], -chassis[Z_BOGIE]
            at[3 * side + k, 0], at[3 * side + k, 1] = xb + dx * cos_b - dz * sin_b, y
            at[3 * side + k, 2] = zb + dx * sin_b + dz * cos_b


@kernel(inline=True)
def _held(sine: float) -> float:
    """The sine of an arm's angle, held within what an arm can do."""
    return min(max(sine, -_REACH), _REACH)


@kernel(inline=True)
def _arms(chassis: F64) -> Arms:
    """What `_side` needs of a chassis, forward being towards the wheel on the rocker.

    Of a rocker-bogie one over the bogie's length, share of the middle wheel in the joint's height,
    place of the joint; one over the rocker's arm, its cosine and sine; from joint to pivot. Of four
    wheels one over their distance, share of the first in the pivot's height, height of the pivot.
    """
    face = chassis[FACE]
    xp, zp = face * chassis[X_PIVOT], chassis[Z_PIVOT]
    x_one, x_end = face * chassis[X_ONE], face * chassis[X_END]
    if chassis[KIND] != ROCKER_BOGIE:
        per = 1.0 / (x_one - x_end)
        return per, (xp - x_end) * per, zp, 0.0, 1.0, 0.0, 0.0, 0.0
    xb, zb, x_mid = face * chassis[X_BOGIE], chassis[Z_BOGIE], face * chassis[X_MID]
    per, arm = 1.0 / (x_mid - x_end), x_one - xb
    rocker = 1.0 / np.sqrt(arm * arm + zb * zb)
    return per, (xb - x_end) * per, zb, rocker, arm * rocker, zb * rocker, xp - xb, zp - zb


@kernel(inline=True)
def _rest(rise: float, square: float) -> tuple[float, float]:
    """Both g sin and g cos of an arm from g sin and g^2; held within what an arm can do."""
    if rise * rise > _REACH * _REACH * square:
        rise = np.sign(rise) * _REACH * np.sqrt(square)
    return rise, np.sqrt(square - rise * rise)


@kernel(inline=True)
def _side(six: bool, arms: Arms, h: F64, first: int, square: float) -> Side:
    """Each g sin and g cos of a and of b, pivot height H [m] of the side of wheels `first` on.

    `square` is g^2. With g times the sines, which are rises over lengths, and g times the cosines
    there is nothing to divide. a and b are mirrored where FACE is -1. The last number is the square
    of the largest g sin of an arm.
    """
    per, share, high, rocker, along, up, ahead, above = arms
    one, end = h[first], h[first + 2]
    if not six:
        sin, cos = _rest((one - end) * per, square)
        return sin, cos, sin, cos, share * one + (1.0 - share) * end + high * cos, sin * sin
    mid = h[first + 1]
    sin_b, cos_b = _rest((mid - end) * per, square)
    joint = share * mid + (1.0 - share) * end + high * cos_b
    sin_u, cos_u = _rest((one - joint) * rocker, square)
    sin, cos = sin_u * along + cos_u * up, cos_u * along - sin_u * up
    return sin, cos, sin_b, cos_b, joint + ahead * sin + above * cos, max(sin_b**2, sin_u**2)


@kernel(inline=True)
def _rigid(chassis: F64, h: F64) -> tuple[float, float, float]:
    """A, B and z of four wheels on one board: the higher diagonal, then the heavier end."""
    base = chassis[X_ONE] - chassis[X_END]
    left, right = (h[0] - h[2]) / base, (h[3] - h[5]) / base
    if chassis[FRONT_HEAVY] > 0.0:
        a, x = min(left, right), chassis[X_ONE]
        return a, (h[0] - h[3]) / chassis[TRACK], 0.5 * (h[0] + h[3]) - x * a
    a, x = max(left, right), chassis[X_END]
    return a, (h[2] - h[5]) / chassis[TRACK], 0.5 * (h[2] + h[5]) - x * a


@kernel(inline=True)
def _attitude(
    chassis: F64, arms: Arms, h: F64, across: float
) -> tuple[float, float, float, Turn, Turn, Turn, bool]:
    """A, B, z, rocker, left and right bogie for wheel heights (6,), and whether all reach so far.

    Exact: the wheels of a body with those numbers are as high as `h`. `across` is a guess of B.
    """
    if chassis[KIND] == RIGID:
        up_x, up_y, z = _rigid(chassis, h)
        steep, level = up_x * up_x + up_y * up_y, (0.0, 1.0)
        if steep >= _REACH:
            shrink = np.sqrt(_REACH / steep)
            up_x, up_y = up_x * shrink, up_y * shrink
        return up_x, up_y, z, level, level, level, steep < _REACH
    six, per, face = chassis[KIND] == ROCKER_BOGIE, 1.0 / chassis[TRACK], chassis[FACE]
    left = right = (0.0, 1.0, 0.0, 1.0, 0.0, 0.0)
    square, change = 1.0, 0.0
    for _ in range(41):
        square = 1.0 - across * across
        left, right = _side(six, arms, h, 0, square), _side(six, arms, h, 3, square)
        before, was = across, change
        across = _held((left[4] - right[4]) * per)
        change = across - before
        if abs(change) < 1e-13:
            break
        # What is left shrinks by about the same share each time: Aitken's sum of the rest.
        if abs(change) < 0.5 * abs(was):
            across, change = across + change * change / (was - change), 0.0
    reach = max(left[5], right[5], across * across * square) < _REACH * _REACH * square
    # Vectors of one length add up to one in the direction of their mean, as long as twice the
    # cosine of half of what they differ.
    g = np.sqrt(square)
    along, up = left[1] + right[1], face * (left[0] + right[0])
    twice = max(np.sqrt(along * along + up * up), _TINY)
    sin, cos = up / twice, along / twice
    z = 0.5 * (left[4] + right[4]) - g * (chassis[X_PIVOT] * sin + chassis[Z_PIVOT] * cos)
    one = 1.0 / g
    differ = face * (left[0] * right[1] - left[1] * right[0])
    rocker = (differ / twice * one, 0.5 * twice * one)
    if not six:
        return g * sin, across, z, rocker, (0.0, 1.0), (0.0, 1.0), reach
    mean = (sin * one, cos * one)
    bogie_left = _less((face * left[2], left[3]), mean)
    return g * sin, across, z, rocker, bogie_left, _less((face * right[2], right[3]), mean), reach


@kernel(inline=True)
def _less(angle: Turn, other: Turn) -> Turn:
    """An angle less another, as sine and cosine."""
    return angle[0] * other[1] - angle[1] * other[0], angle[1] * other[1] + angle[0] * other[0]


@kernel(inline=True)
def _pitch_and_roll(a: float, b: float, p: float, q: float, n: float) -> tuple[Turn, Turn]:
    """Pitch and roll of a body at A, B to a plane that rises by p ahead and q to the left.

    With m = sqrt(1 + p^2), sin(pitch - arctan p) = n A / m; the rest is written without its cosine.
    """
    square, left = 1.0 + p * p, 1.0 - a * a
    level = np.sqrt(max(square - (n * a) * (n * a), 0.0))
    up = np.sqrt(max(left - b * b, 0.0))
    per, each = 1.0 / square, 1.0 / (n * max(left, _TINY))
    pitch = (p * level + n * a) * per, (level - p * n * a) * per
    return pitch, ((q * up + level * b) * each, (level * up - q * b) * each)


@kernel(inline=True)
def _gap(a: Turn, b: Turn) -> float:
    """The square of the distance of two points on the unit circle."""
    return (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1])


@kernel(inline=True)
def _between(a: Turn, b: Turn) -> Turn:
    """Half the way between two angles."""
    sin, cos = a[0] + b[0], a[1] + b[1]
    long = max(np.sqrt(sin * sin + cos * cos), _TINY)
    return sin / long, cos / long


@kernel(inline=True)
def _angle(turn: Turn) -> float:
    return np.arctan2(turn[0], turn[1])


@kernel(bare=True)
def settle_one(
    wheel: F32, gradient: F32, c: float, chassis: F64, pose: F64, room: tuple[F64, F64], out: F64
) -> tuple[Turn, Turn, Turn]:
    """Write the attitude of one rover to `out` (SETTLED,); returns its heading, pitch and roll.

    Where the wheels touch depends on the attitude, and the attitude on where they touch: found by
    turns, beginning with a body flush with the plane of the ground about it. From round 12 on a
    step goes half the way only. `room` is for (6, 3) and (6,); where the settled wheels are in body
    axes stays in the first. Angles are kept as sines and cosines, so that no round needs any
    function but the square root.
    """
    at, h = room
    sin, cos = np.sin(pose[2]), np.cos(pose[2])
    east, north = (
        height_at(gradient[0], c, pose[0], pose[1]),
        height_at(gradient[1], c, pose[0], pose[1]),
    )
    if not (east == east and north == north):
        east = north = 0.0
    p, q = east * cos + north * sin, north * cos - east * sin
    n, arms, six = np.sqrt(1.0 + p * p + q * q), _arms(chassis), chassis[KIND] == ROCKER_BOGIE
    pitch, roll = _pitch_and_roll(0.0, 0.0, p, q, n)
    rocker = bogie_left = bogie_right = (0.0, 1.0)
    per, across, z, reach, error, rounds = 1.0 / n, 0.0, np.nan, True, np.inf, 0
    while rounds < _MOST and error > _CLOSE * _CLOSE:
        _place_wheels(chassis, rocker, bogie_left, bogie_right, at)
        for k in range(6):
            if not six and (k == 1 or k == 4):
                continue
            x = pitch[1] * at[k, 0] - pitch[0] * (roll[0] * at[k, 1] + roll[1] * at[k, 2])
            y = roll[1] * at[k, 1] - roll[0] * at[k, 2]
            up = height_at(wheel, c, pose[0] + cos * x - sin * y, pose[1] + sin * x + cos * y)
            h[k] = (up - p * x - q * y) * per
        up_x, across, z, on, left, right, reach = _attitude(chassis, arms, h, across)
        if z != z:
            break
        nose, side = _pitch_and_roll(up_x, across, p, q, n)
        error = max(_gap(nose, pitch), _gap(side, roll), _gap(on, rocker))
        error = max(error, _gap(left, bogie_left), _gap(right, bogie_right))
        rounds += 1
        if rounds > _EASY and error > _CLOSE * _CLOSE and rounds < _MOST:
            nose, side, on = _between(nose, pitch), _between(side, roll), _between(on, rocker)
            left, right = _between(left, bogie_left), _between(right, bogie_right)
        pitch, roll, rocker, bogie_left, bogie_right = nose, side, on, left, right
    _place_wheels(chassis, rocker, bogie_left, bogie_right, at)
    out[Z], out[PITCH], out[ROLL], out[ROCKER] = z * n, _angle(pitch), _angle(roll), _angle(rocker)
    out[TILT] = np.arccos(min(1.0, pitch[1] * roll[1]))
    out[BOGIE_LEFT], out[BOGIE_RIGHT] = _angle(bogie_left), _angle(bogie_right)
    out[ERROR], out[ROUNDS] = 2.0 * np.arcsin(min(1.0, 0.5 * np.sqrt(error))), rounds
    out[CODE] = NO_GROUND if z != z else (SAFE if reach else STRETCHED)
    return (sin, cos), pitch, roll


@kernel(bare=True)
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
