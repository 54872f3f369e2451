"""What a grid of heights does from cell to cell.

Symbols: z height [m], c cell [m], p = dz/dx, q = dz/dy [1], r reach [cells].
A missing height is NaN and makes every sum it enters NaN. All inputs are C-ordered and read-only.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._jit import kernel

F32: TypeAlias = NDArray[np.float32]
F64: TypeAlias = NDArray[np.float64]

_TWO = np.float64(2.0)  # times a short float it gives a long one, compiled or not


@kernel()
def horn(z: F32, c: float, p: F32, q: F32) -> None:
    """Write Horn's (1981) weighted differences of `z` (h, w) to `p`, `q` (h-2, w-2)."""
    h, w = p.shape
    for i in range(h):
        for j in range(w):
            west = _TWO * z[i + 1, j] + z[i, j] + z[i + 2, j]
            east = _TWO * z[i + 1, j + 2] + z[i, j + 2] + z[i + 2, j + 2]
            south = _TWO * z[i, j + 1] + z[i, j] + z[i, j + 2]
            north = _TWO * z[i + 2, j + 1] + z[i + 2, j] + z[i + 2, j + 2]
            nothing = 0.0 * z[i + 1, j + 1]  # NaN where the middle height is missing
            p[i, j] = (east - west) / (8.0 * c) + nothing
            q[i, j] = (north - south) / (8.0 * c) + nothing


@kernel()
def plane(z: F32, c: float, r: int, out: F32) -> None:
    """Fit planes to (2r+1)^2 cells of `z` (h, w): p, q and rms [m] to `out` (3, h, w).

    Only windows wholly on the grid: `r` cells along each edge are left as they are. With
    u, v = -r..r counted from the middle, the normal equations of z = a + p u c + q v c are
    diagonal: p = sum(u z) / (n s c), q = sum(v z) / (n s c), where n = 2r+1 and s = sum(u^2); what
    is left is sum(z^2) - (sum z)^2 / n^2 - (p^2 + q^2) n s c^2, and rms the root of its mean. Sums
    run on from window to window within tiles, in which heights count from one of their own: so
    they stay exact to micrometres.
    """
    h, w = z.shape
    room = np.empty((12, _TILE + 2 * r))
    for i in range(r, h - r, _TILE):
        for j in range(r, w - r, _TILE):
            end = min(i + _TILE, h - r)
            _plane_tile(z, (c, r), (i, end, j, min(j + _TILE, w - r)), room, out)


_TILE = 256


@kernel()
def _plane_tile(
    z: F32, cr: tuple[float, int], tile: tuple[int, int, int, int], room: F64, out: F32
) -> None:
    """`plane` on one tile; `room` (12, w + 2r) begins with sums of z, v z, z^2 and what is missing.

    Each loop has few arrays, because a compiler checks them against each other before it uses
    vectors, and gives up where they are many.
    """
    c, r = cr
    south, north, west, east = tile
    n, wide = 2 * r + 1, east - west + 2 * r
    zero = _level(z, tile)
    room[:4] = 0.0
    total, lever, square, missing = room[0, :wide], room[1, :wide], room[2, :wide], room[3, :wide]
    gone, lost, here, came = room[4, :wide], room[5, :wide], room[6, :wide], room[7, :wide]
    for v in range(n):
        _taken(z[south - r + v, west - r : east + r], zero, here, came)
        for j in range(wide):
            total[j] += here[j]
            lever[j] += (v - r) * here[j]
        _add(square, missing, here, came)
    for i in range(south, north):
        _plane_row(room, (r, east - west, c), out, i, west)
        if i == north - 1:
            break
        _taken(z[i - r, west - r : east + r], zero, gone, lost)
        _taken(z[i + r + 1, west - r : east + r], zero, here, came)
        for j in range(wide):
            lever[j] += r * (gone[j] + here[j]) - (total[j] - gone[j])
        for j in range(wide):
            total[j] += here[j] - gone[j]
        for j in range(wide):
            square[j] += here[j] * here[j] - gone[j] * gone[j]
        for j in range(wide):
            missing[j] += came[j] - lost[j]


@kernel()
def _taken(row: F32, zero: float, value: F64, lost: F64) -> None:
    """Heights of a row over `zero`, and 1 where one is missing, which counts as 0."""
    for j in range(len(row)):
        nothing = row[j] != row[j]
        value[j] = 0.0 if nothing else np.float64(row[j]) - zero
        lost[j] = 1.0 if nothing else 0.0


@kernel()
def _add(square: F64, missing: F64, value: F64, lost: F64) -> None:
    for j in range(len(square)):
        square[j] += value[j] * value[j]
        missing[j] += lost[j]


@kernel()
def _level(z: F32, tile: tuple[int, int, int, int]) -> float:
    """A height out of the tile, or 0 where all on its diagonal are missing."""
    south, north, west, east = tile
    for i in range(south, north):
        here = np.float64(z[i, west + (i - south) % (east - west)])
        if here == here:
            return here
    return 0.0


@kernel()
def _plane_row(room: F64, rwc: tuple[int, int, float], out: F32, i: int, west: int) -> None:
    """One row of windows from the sums down the columns; sums along the row go to `room` 8-11."""
    r, w, c = rwc
    n = 2 * r + 1
    along, across, rest, lost = room[8, :w], room[9, :w], room[10, :w], room[11, :w]
    sums = room[4, :w]
    _windows(room[0], n, sums)
    _windows(room[1], n, across)
    _windows(room[2], n, rest)
    _windows(room[3], n, lost)
    _moments(room[0], r, sums, along)
    inertia = n * (r * (r + 1) * n / 3.0)
    per, cells, share = 1.0 / (inertia * c), 1.0 / (n * n), 1.0 / inertia
    for j in range(w):
        rest[j] -= sums[j] * sums[j] * cells + (along[j] ** 2 + across[j] ** 2) * share
    for j in range(w):
        lost[j] = np.nan if lost[j] > 0.5 else 0.0
    p, q, rms = out[0, i, west : west + w], out[1, i, west : west + w], out[2, i, west : west + w]
    for j in range(w):
        p[j] = along[j] * per + lost[j]
    for j in range(w):
        q[j] = across[j] * per + lost[j]
    for j in range(w):
        left = rest[j] * cells
        rms[j] = np.sqrt(left if left > 0.0 else 0.0) + lost[j]


_SHORT = 9


@kernel()
def _windows(values: F64, n: int, out: F64) -> None:
    """Sums of n numbers running along a row: short ones afresh, long ones from the one before."""
    w = len(out)
    if n <= _SHORT:
        for j in range(w):
            out[j] = values[j]
        for u in range(1, n):
            for j in range(w):
                out[j] += values[j + u]
        return
    total = 0.0
    for u in range(n):
        total += values[u]
    out[0] = total
    for j in range(1, w):
        total += values[j + n - 1] - values[j - 1]
        out[j] = total


@kernel()
def _moments(values: F64, r: int, sums: F64, out: F64) -> None:
    """Sums of u values[u], u = -r..r, running along a row beside the sums of the values."""
    w, n = len(out), 2 * r + 1
    if n <= _SHORT:
        for j in range(w):
            out[j] = -r * values[j]
        for u in range(1, n):
            for j in range(w):
                out[j] += (u - r) * values[j + u]
        return
    total = 0.0
    for u in range(n):
        total += (u - r) * values[u]
    out[0] = total
    for j in range(1, w):
        gone, here = values[j - 1], values[j + n - 1]
        total += r * (gone + here) - (sums[j - 1] - gone)
        out[j] = total


@kernel()
def steepness(p: F32, q: F32, out: F32) -> None:
    """Write the angle of the gradient, arctan(sqrt(p^2 + q^2)) [rad], to `out`; all (h, w)."""
    for i in range(p.shape[0]):
        for j in range(p.shape[1]):
            a, b = np.float64(p[i, j]), np.float64(q[i, j])
            out[i, j] = arctan(np.sqrt(a * a + b * b))


@kernel(inline=True)
def arctan(x: float) -> float:
    """Arc tangent of x >= 0, without branches, so that a loop over it runs in vectors.

    Range reduction and rational approximation of S. Moshier's Cephes library (atan.c); error below
    2e-16 relative. NaN stays NaN.
    """
    low, high = x < 0.41421356237309503, x > 2.414213562373095
    base = 0.0 if low else (1.5707963267948966 if high else 0.7853981633974483)
    t = (x if low else (-1.0 if high else x - 1.0)) / (1.0 if low else (x if high else x + 1.0))
    s = t * t
    top = -8.750608600031904e-1 * s - 1.615753718733365e1
    top = (top * s - 7.500855792314705e1) * s - 1.2288666844901361e2
    top = (top * s - 6.485021904942025e1) * s
    low_part = (s + 2.485846490142306e1) * s + 1.650270098316988e2
    low_part = (low_part * s + 4.328810604912903e2) * s + 4.853903996359137e2
    return base + (t + t * (top / (low_part * s + 1.945506571482614e2)))


@kernel()
def ledge(z: F32, r: int, rise: float, out: F32) -> None:
    """Write the largest |dz| to posts 1..r cells away, in eight directions, to `out` (h, w).

    Only differences above `rise` [m per cell of distance] count; 0 where there is none, NaN where
    `z` is.
    """
    h, w = z.shape
    for i in range(h):
        for j in range(w):
            out[i, j] = np.float32(0.0) * z[i, j]  # NaN where the height is missing
    for i in range(h):
        for k in range(1, min(r, max(h, w)) + 1):
            _ledges(z[i, k:], z[i, : w - k], k * rise, out[i, k:], out[i, : w - k])
            if i + k >= h:
                continue
            _ledges(z[i + k], z[i], k * rise, out[i + k], out[i])
            far = k * rise * np.sqrt(2.0)
            _ledges(z[i + k, k:], z[i, : w - k], far, out[i + k, k:], out[i, : w - k])
            _ledges(z[i + k, : w - k], z[i, k:], far, out[i + k, : w - k], out[i, k:])


@kernel()
def _ledges(z: F32, other: F32, least: float, out: F32, mirror: F32) -> None:
    """Raise both ends of every difference above `least` to it."""
    for j in range(len(z)):
        dz = np.float32(abs(z[j] - other[j]))
        counts = np.float64(dz) > least
        out[j] = dz if counts and dz > out[j] else out[j]
        mirror[j] = dz if counts and dz > mirror[j] else mirror[j]
