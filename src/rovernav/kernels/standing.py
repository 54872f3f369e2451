"""What is under a settled body: the room below its belly, steps under its wheels; many poses.

Symbols as in `settle`.
"""

from __future__ import annotations

import numpy as np

from ._jit import kernel
from .settle import (
    BELLY,
    BELLY_FRONT,
    BELLY_HALF,
    BELLY_REAR,
    CLEARANCE,
    CODE,
    F32,
    F64,
    KIND,
    NO_GROUND,
    ROCKER_BOGIE,
    ROUNDS,
    STEP,
    TRACK,
    X_ONE,
    Turn,
    Z,
    settle_one,
    verdict,
)
from .surface import height_at
from .team import prefetch


@kernel(bare=True)
def fetch_ground(maps: tuple[F32, F32, F32, F32], c: float, chassis: F64, pose: F64) -> None:
    """Ask for what settling a rover at `pose` will read, nearly; nothing is changed.

    `maps` are those of `settle`, in its order. Thousands of rovers stand at as many places of maps
    that no near cache holds.
    """
    wheel, gradient, ground, step = maps
    rows, columns = wheel.shape
    u, v = pose[0] / c - 0.5, pose[1] / c - 0.5
    if not (0.0 <= u < columns and 0.0 <= v < rows):
        return
    cos, sin, half = np.cos(pose[2]) / c, np.sin(pose[2]) / c, 0.5 * chassis[TRACK]
    middle, six = int(v) * columns + int(u), chassis[KIND] == ROCKER_BOGIE
    for k in range(2):
        prefetch(gradient, k * rows * columns + middle)
        prefetch(gradient, k * rows * columns + middle + columns)
    for k in range(3):
        if k == 1 and not six:
            continue
        x = chassis[X_ONE + k]
        for side in range(2):
            y = half if side == 0 else -half
            place = int(v + sin * x + cos * y) * columns + int(u + cos * x - sin * y)
            prefetch(wheel, place)
            prefetch(wheel, place + columns)
            prefetch(step, place)
            prefetch(step, place + columns)
    rear, front, wide = chassis[BELLY_REAR], chassis[BELLY_FRONT], chassis[BELLY_HALF]
    x, long = 0.5 * (front + rear), 0.5 * (front - rear)
    across, tall = abs(cos) * long + abs(sin) * wide, abs(sin) * long + abs(cos) * wide
    u, v = u + cos * x, v + sin * x
    for i in range(int(v - tall), int(v + tall) + 2):
        prefetch(ground, i * columns + int(u - across))
        prefetch(ground, i * columns + int(u))
        prefetch(ground, i * columns + int(u + across) + 1)


@kernel(inline=True)
def _part(low: float, high: float, at: float, one_over: float, span: float) -> tuple[float, float]:
    """The part of [low, high] where |at + x / one_over| <= span; low above high where none."""
    if abs(one_over) > 1e9:
        return (low, high) if abs(at) <= span else (1.0, 0.0)
    a, b = (-span - at) * one_over, (span - at) * one_over
    return max(low, min(a, b)), min(high, max(a, b))


@kernel(inline=True)
def _lowest(row: F32, first: int, end: int, high: float, rise: float) -> float:
    """Least of high + rise j - row[j] from `first` to before `end`; NaN if one is.

    Four sums and least numbers side by side, so that none waits for the one before.
    """
    a = b = c = d = np.inf
    total, other = 0.0, 0.0
    for j in range(first, end - 3, 4):
        one, two = high + rise * j - row[j], high + rise * (j + 1) - row[j + 1]
        three, four = high + rise * (j + 2) - row[j + 2], high + rise * (j + 3) - row[j + 3]
        a, b, c, d = min(a, one), min(b, two), min(c, three), min(d, four)
        total += one + two
        other += three + four
    for j in range(end - max(0, end - first) % 4, end):
        gap = high + rise * j - row[j]
        a = min(a, gap)
        total += gap
    total += other
    return min(min(a, b), min(c, d)) if total == total else np.nan


@kernel(bare=True)
def clearance_of(
    ground: F32, c: float, chassis: F64, pose: F64, turns: tuple[Turn, Turn, Turn], level: float
) -> float:
    """Least distance of the belly from the ground [m], square to the belly; NaN without data.

    Over every post under the belly's rectangle and nine points of a lattice across it. `turns` are
    heading, pitch and roll as `settle_one` returns them, `level` is the height of the axles.
    """
    (sin, cos), (sp, cp), (sr, cr) = turns
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
        gap = level + sp * bx + cp * (sr * by + cr * up) - height_at(ground, c, px, py)
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
    for i in range(max(0, int(south / c - 0.5)), min(rows, int(north / c + 0.5) + 1)):
        py = (i + 0.5) * c - pose[1]
        by = (cos * py + sr * up) * flat
        bx = (sin * py + sp * (sr * by + cr * up)) * steep
        low, high = west - pose[0], east - pose[0]
        low, high = _part(low, high, bx - middle, one_bx, long)
        low, high = _part(low, high, by, one_by, half)
        first = max(0, int(np.ceil((low + pose[0]) * per - 0.5)))
        last = min(columns - 1, int(np.floor((high + pose[0]) * per - 0.5)))
        high = level + sp * bx + cp * (sr * by + cr * up) + up_x * (0.5 * c - pose[0])
        low = _lowest(ground[i], first, last + 1, high, up_x * c)
        if low != low:
            return np.nan
        least = min(least, low)
    return least * cp * cr


@kernel(bare=True)
def step_under(
    step: F32, c: float, chassis: F64, pose: F64, at: F64, turns: tuple[Turn, Turn, Turn]
) -> float:
    """Highest step at the four posts around each wheel [m]; NaN without data.

    `at` and `turns` are what `settle_one` left and returned.
    """
    (sin, cos), (sp, cp), (sr, cr) = turns
    rows, columns = step.shape
    six, highest = chassis[KIND] == ROCKER_BOGIE, 0.0
    for k in range(6):
        if not six and (k == 1 or k == 4):
            continue
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
        if n + 1 < len(poses):
            fetch_ground((wheel, gradient, ground, step), c, chassis, poses[n + 1])
        turns = settle_one(wheel, gradient, c, chassis, poses[n], room, row)
        if row[CODE] == NO_GROUND:
            row[:] = np.nan
            row[ROUNDS], row[CODE] = 0.0, NO_GROUND
            continue
        row[CLEARANCE] = clearance_of(ground, c, chassis, poses[n], turns, row[Z])
        row[STEP] = step_under(step, c, chassis, poses[n], room[0], turns)
        row[CODE] = verdict(chassis, row)
