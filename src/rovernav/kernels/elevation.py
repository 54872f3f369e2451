"""The map that a rover makes for itself: heights, how sure it is of them, where it can go.

After P. Fankhauser, M. Bloesch and M. Hutter, Probabilistic terrain mapping for mobile robots with
uncertain localization, IEEE Robotics and Automation Letters 3 (2018): a height and a variance in
each cell, fused as by Kalman, with the pose's growing uncertainty added to what is not seen again.

A mean halves what is narrower than a cell, and a rock of one post can stop a wheel: so a cell knows
its top too, the height that some ground in it surely reaches.

Symbols: h height, v its variance, t top, c cell, s side of the map in cells. The maps roll as those
of `kernels.fan` do: world cell (i, j) lies at (i & (s - 1), j & (s - 1)).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ._jit import kernel

FREE, UNKNOWN, STEEP, LEDGE, NEAR = 0, 1, 2, 3, 4
"""Verdicts; the numbers are those of `rovernav.rover.Reason`."""
GATE = 3.0
"""Standard deviations beyond which a reading is of something else than the cell's height."""
ENOUGH = 0.6
"""A plane needs this share of the cells under a footing."""


class Fusion(NamedTuple):
    """How a patch is taken in.

    Attributes:
        cell: Cell of the map [m].
        mast: Height of the eyes [m].
        noise: Of heights, for each square metre of distance squared [1/m].
        least: Smallest variance of a reading [m^2]: ground is not level within a cell.
        sure: Standard deviations by which a reading must be higher for the top of a cell.
    """

    cell: float
    mast: float
    noise: float
    least: float
    sure: float


class Limits(NamedTuple):
    """What the rover can do, in cells of the map.

    Attributes:
        cell: [m].
        half: Half the footing [cells].
        wheel: A wheel's diameter [cells].
        slope: Tangent of the steepest slope.
        step: Highest ledge [m].
        radius: Of the circle around the rover [cells].
        sure: Standard deviations by which a ledge must be higher than the limit.
        around: Cells on each side of the rover's that are judged anew.
    """

    cell: float
    half: int
    wheel: int
    slope: float
    step: float
    radius: float
    sure: float
    around: int


@kernel()
def forget(layer: Any, centre: Any, pose: Any, c: float, fill: float) -> None:
    """Write `fill` to the cells that enter each map as its rover moves; `centre` stays as it is."""
    s = layer.shape[1]
    half, mask = s // 2, s - 1
    for k in range(pose.shape[0]):
        row, column = int(np.floor(pose[k, 1] / c)), int(np.floor(pose[k, 0] / c))
        if abs(row - centre[k, 0]) >= s or abs(column - centre[k, 1]) >= s:
            layer[k] = fill
            continue
        for i in range(centre[k, 0] + half, row + half):
            layer[k, i & mask] = fill
        for i in range(row - half, centre[k, 0] - half):
            layer[k, i & mask] = fill
        for j in range(centre[k, 1] + half, column + half):
            layer[k, :, j & mask] = fill
        for j in range(column - half, centre[k, 1] - half):
            layer[k, :, j & mask] = fill


@kernel()
def inflate(variance: Any, top: Any, slope: Any, rise: Any, aside: Any) -> None:
    """Add to each variance what the pose became less sure by: v += rise + tan(slope)^2 aside.

    Tops sink by what the standard deviation grows.

    Args:
        variance: (n, s, s) [m^2], changed; NaN stays.
        top: (n, s, s) [m], changed.
        slope: As last judged (n, s, s) [rad]; unknown counts as level.
        rise: Growth of the variance of the rover's height (n,) [m^2].
        aside: Growth of the variance of its place (n,) [m^2].
    """
    s = variance.shape[1]
    for k in range(variance.shape[0]):
        if rise[k] == 0.0 and aside[k] == 0.0:
            continue
        for i in range(s):
            for j in range(s):
                tilt = math.tan(slope[k, i, j]) if slope[k, i, j] == slope[k, i, j] else 0.0
                before = np.float64(variance[k, i, j])
                after = before + rise[k] + tilt * tilt * aside[k]
                top[k, i, j] -= math.sqrt(after) - math.sqrt(before)
                variance[k, i, j] = after


@kernel(inline=True)
def at_cell(x: float, y: float, k: int, centre: Any, s: int, c: float) -> tuple[int, int]:
    """Row and column in the arrays of the cell that holds (x, y); row -1 beyond the map."""
    row, column = int(np.floor(y / c)), int(np.floor(x / c))
    half, mask = s // 2, s - 1
    if -half <= row - centre[k, 0] < half and -half <= column - centre[k, 1] < half:
        return row & mask, column & mask
    return -1, -1


@kernel(inline=True)
def _place(k: int, m: int, pose: Any, places: Any) -> tuple[float, float]:
    c, s = math.cos(pose[k, 2]), math.sin(pose[k, 2])
    x = pose[k, 0] + c * places[m, 0] - s * places[m, 1]
    return x, pose[k, 1] + s * places[m, 0] + c * places[m, 1]


@kernel(inline=True)
def _variance(f: Fusion, forward: float, left: float, up: float) -> float:
    """Variance of one height, from where it was seen [m^2]."""
    rr = forward * forward + left * left + (f.mast - up) ** 2
    return f.least + (f.noise * rr) ** 2


@kernel()
def level(
    height: Any, variance: Any, centre: Any, stand: Any, places: Any, patch: Any, f: Fusion
) -> None:
    """The height of each rover's ground that fits its patch best to its map; 0 with no overlap.

    The mean of h - reading over the cells that both know, weighted by 1 / (v + v of the reading).

    Args:
        height: (n, s, s) [m].
        variance: (n, s, s) [m^2].
        centre: Cell of each rover (n, 2).
        stand: Where the rovers think they are, and that height (n, 4); the height is written.
        places: Forward, left of the patch's places (m, 2) [m].
        patch: Heights over the ground under the rover (n, m) [m], NaN where not seen.
        f: How a patch is taken in.
    """
    s = height.shape[1]
    for k in range(stand.shape[0]):
        total, weights = 0.0, 0.0
        for m in range(places.shape[0]):
            z = patch[k, m]
            x, y = _place(k, m, stand, places)
            i, j = at_cell(x, y, k, centre, s, f.cell)
            if z != z or i < 0 or height[k, i, j] != height[k, i, j]:
                continue
            v = variance[k, i, j] + _variance(f, places[m, 0], places[m, 1], z)
            total += (height[k, i, j] - z) / v
            weights += 1.0 / v
        stand[k, 3] = total / weights if weights > 0.0 else 0.0


@kernel()
def fuse(
    height: Any,
    variance: Any,
    top: Any,
    centre: Any,
    stand: Any,
    places: Any,
    patch: Any,
    f: Fusion,
) -> None:
    """Take the patches into the maps.

    Each seen place changes the cell under it, in the order of the places. An unknown cell becomes
    (z, v). A reading within 3 sqrt(v_cell + v) is fused: 1/v' = 1/v_cell + 1/v, h' = v' (h / v_cell
    + z / v). A higher one takes the cell: there is an edge in it, and its top counts. A lower one
    only makes the cell less sure, by its own variance. The top rises to z - sure sqrt(v).

    Args:
        height: (n, s, s) [m], changed.
        variance: (n, s, s) [m^2], changed.
        top: (n, s, s) [m], changed.
        centre: Cell of each rover (n, 2).
        stand: Where the rovers think they are, and the height of the ground there (n, 4).
        places: Forward, left of the patch's places (m, 2) [m].
        patch: Heights over the ground under the rover (n, m) [m], NaN where not seen.
        f: How a patch is taken in.
    """
    s = height.shape[1]
    for k in range(stand.shape[0]):
        for m in range(places.shape[0]):
            up = patch[k, m]
            x, y = _place(k, m, stand, places)
            i, j = at_cell(x, y, k, centre, s, f.cell)
            if up != up or i < 0:
                continue
            v, new = _variance(f, places[m, 0], places[m, 1], up), stand[k, 3] + up
            h, w = np.float64(height[k, i, j]), np.float64(variance[k, i, j])
            least = new - f.sure * math.sqrt(v)
            if h != h:
                height[k, i, j], variance[k, i, j], top[k, i, j] = new, v, least
                continue
            top[k, i, j] = max(np.float64(top[k, i, j]), least)
            if abs(new - h) <= GATE * math.sqrt(w + v):
                height[k, i, j] = (h * v + new * w) / (w + v)
                variance[k, i, j] = w * v / (w + v)
            elif new > h:
                height[k, i, j], variance[k, i, j] = new, v
            else:
                variance[k, i, j] = w + v


@kernel()
def judge(
    height: Any,
    variance: Any,
    top: Any,
    centre: Any,
    p: Limits,
    slope: Any,
    step: Any,
    reason: Any,
) -> None:
    """Where each rover could stand, by the heights it knows, in the cells around it.

    The slope of a cell is that of the plane fitted to the known cells under a footing, of which
    `ENOUGH` must be known. A ledge is the largest difference between the top of the cell and the
    height of a known one within a wheel's diameter, or the other way round, that is steeper than
    the slope limit, less `sure` times the standard deviation of that height.

    Args:
        height: (n, s, s) [m], NaN where unknown.
        variance: (n, s, s) [m^2].
        top: (n, s, s) [m].
        centre: Cell of each rover (n, 2).
        p: The limits.
        slope: (n, s, s), float32 [rad], NaN where unknown; written.
        step: (n, s, s), float32 [m], NaN where unknown; written.
        reason: (n, s, s), uint8: a verdict without nearness; written.
    """
    s = height.shape[1]
    half, mask = s // 2, s - 1
    for k in range(height.shape[0]):
        row, column = centre[k, 0], centre[k, 1]
        for i in range(row - p.around, row + p.around + 1):
            for j in range(column - p.around, column + p.around + 1):
                if not (-half <= i - row < half and -half <= j - column < half):
                    continue
                a, b = i & mask, j & mask
                tilt = _plane(height[k], i, j, (row, column), p)
                slope[k, a, b] = math.atan(tilt) if tilt == tilt else np.nan
                layers = (height[k], variance[k], top[k])
                ledge = _ledge(layers, i, j, (row, column), p)
                step[k, a, b] = ledge
                if tilt > p.slope:
                    reason[k, a, b] = STEEP
                elif ledge > p.step:
                    reason[k, a, b] = LEDGE
                else:
                    reason[k, a, b] = FREE if tilt == tilt else UNKNOWN


@kernel()
def _plane(h: Any, i: int, j: int, centre: Any, p: Limits) -> float:
    """Tangent of the slope of the plane fitted around cell (i, j); NaN where too few are known."""
    s = h.shape[0]
    half, mask = s // 2, s - 1
    n, su, sv, sz, suu, svv, suv, suz, svz = 0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for di in range(-p.half, p.half + 1):
        for dj in range(-p.half, p.half + 1):
            a, b = i + di, j + dj
            if not (-half <= a - centre[0] < half and -half <= b - centre[1] < half):
                continue
            z = np.float64(h[a & mask, b & mask])
            if z != z:
                continue
            n += 1
            su, sv, sz = su + dj, sv + di, sz + z
            suu, svv, suv = suu + dj * dj, svv + di * di, suv + di * dj
            suz, svz = suz + dj * z, svz + di * z
    if n < ENOUGH * (2 * p.half + 1) * (2 * p.half + 1):
        return np.nan
    suu, svv, suv = suu - su * su / n, svv - sv * sv / n, suv - su * sv / n
    suz, svz = suz - su * sz / n, svz - sv * sz / n
    whole = suu * svv - suv * suv
    if whole <= 1e-9:
        return np.nan
    east, north = (suz * svv - svz * suv) / whole, (svz * suu - suz * suv) / whole
    return math.sqrt(east * east + north * north) / p.cell


@kernel()
def _ledge(layers: Any, i: int, j: int, centre: Any, p: Limits) -> float:
    """The highest sure ledge around cell (i, j) [m]; NaN where it is not known."""
    h, v, t = layers
    s = h.shape[0]
    half, mask = s // 2, s - 1
    z, peak = np.float64(h[i & mask, j & mask]), np.float64(t[i & mask, j & mask])
    if z != z:
        return np.nan
    most, low = 0.0, z + p.sure * math.sqrt(np.float64(v[i & mask, j & mask]))
    for di in range(-p.wheel, p.wheel + 1):
        for dj in range(-p.wheel, p.wheel + 1):
            far = di * di + dj * dj
            a, b = i + di, j + dj
            if far == 0 or far > p.wheel * p.wheel:
                continue
            if not (-half <= a - centre[0] < half and -half <= b - centre[1] < half):
                continue
            a, b = a & mask, b & mask
            other = np.float64(h[a, b]) + p.sure * math.sqrt(np.float64(v[a, b]))
            rise = max(peak - other, np.float64(t[a, b]) - low)
            if other == other and rise > p.slope * p.cell * math.sqrt(far):
                most = max(most, rise)
    return most


@kernel()
def grow(reason: Any, marks: Any, centre: Any, radius: float, closed: bool, cells: Any) -> None:
    """Where a rover's middle must not be: hazards grown by its radius, and what beams met.

    Args:
        reason: Verdicts (n, s, s), uint8; free cells that are too near a hazard become `NEAR`.
        marks: 1 where a beam met something (n, s, s), uint8.
        centre: Cell of each rover (n, 2).
        radius: [cells].
        closed: Whether unknown ground is blocked too.
        cells: 1 where blocked (n, s, s), uint8; written.
    """
    s = reason.shape[1]
    half, mask = s // 2, s - 1
    for k in range(reason.shape[0]):
        cells[k] = marks[k]
        for m in range(s):
            for n in range(s):
                if reason[k, m, n] == NEAR:
                    reason[k, m, n] = FREE  # of an earlier step; judged anew below
                elif closed and reason[k, m, n] == UNKNOWN:
                    cells[k, m, n] = 1
        for i in range(-half, half):
            for j in range(-half, half):
                row, column = centre[k, 0] + i, centre[k, 1] + j
                verdict = reason[k, row & mask, column & mask]
                if verdict in (STEEP, LEDGE):
                    _stamp(reason[k], cells[k], centre[k], (i, j), radius)


@kernel()
def _stamp(reason: Any, cells: Any, centre: Any, at: tuple[int, int], radius: float) -> None:
    """Block the disc around a hazard at `at`, counted from the rover's cell."""
    s = reason.shape[0]
    half, mask, reach = s // 2, s - 1, int(np.floor(radius))
    for i in range(max(at[0] - reach, -half), min(at[0] + reach + 1, half)):
        for j in range(max(at[1] - reach, -half), min(at[1] + reach + 1, half)):
            if (i - at[0]) ** 2 + (j - at[1]) ** 2 <= radius * radius:
                row, column = (centre[0] + i) & mask, (centre[1] + j) & mask
                cells[row, column] = 1
                if reason[row, column] == FREE:
                    reason[row, column] = NEAR
