"""Resampling, made ground and refined ground in plain Python."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

WORD = 2**64


def between(z: Any, r: float, c: float) -> float:
    """Bilinear between posts; NaN where the nearest post is missing or too far."""
    h, w = len(z), len(z[0])
    if not (-0.5 - 1e-6 <= r <= h - 0.5 + 1e-6 and -0.5 - 1e-6 <= c <= w - 0.5 + 1e-6):
        return math.nan
    r, c = min(max(r, 0.0), h - 1.0), min(max(c, 0.0), w - 1.0)
    if math.isnan(z[math.floor(r + 0.5)][math.floor(c + 0.5)]):
        return math.nan
    near = [
        ((1 - abs(r - i)) * (1 - abs(c - j)), z[i][j])
        for i in range(h)
        for j in range(w)
        if abs(r - i) < 1 and abs(c - j) < 1 and not math.isnan(z[i][j])
    ]
    return sum(share * height for share, height in near) / sum(share for share, _ in near)


def resampled(z: Any, at: Any, shape: tuple[int, int], steps: tuple[int, int]) -> Any:
    out = np.full(shape, math.nan)
    for i in range(shape[0]):
        for j in range(shape[1]):
            got: list[float] = []
            for a in range(steps[0]):
                for b in range(steps[1]):
                    y = i + (a + 0.5) / steps[0] - 0.5
                    x = j + (b + 0.5) / steps[1] - 0.5
                    got.append(
                        between(z, at[0] + at[1] * y + at[2] * x, at[3] + at[4] * y + at[5] * x)
                    )
            known = [height for height in got if not math.isnan(height)]
            if 2 * len(known) >= len(got):
                out[i, j] = sum(known) / len(known)
    return out


def block_means(z: Any, n: int) -> Any:
    h, w = z.shape
    out = np.full((-(-h // n), -(-w // n)), math.nan)
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            block = z[i * n : i * n + n, j * n : j * n + n]
            known = block[~np.isnan(block)]
            if 2 * known.size >= n * n:
                out[i, j] = known.mean()
    return out


def mixed(word: int) -> int:
    word = (word + 0x9E3779B97F4A7C15) % WORD
    word = (word ^ (word >> 30)) * 0xBF58476D1CE4E5B9 % WORD
    word = (word ^ (word >> 27)) * 0x94D049BB133111EB % WORD
    return word ^ (word >> 31)


def deviate(key: int, i: int, j: int) -> float:
    word = mixed(mixed(key ^ (i % WORD)) ^ (j % WORD))
    parts = [(word >> (16 * n)) & 0xFFFF for n in range(4)]
    return (sum(parts) - 131070) * math.sqrt(3.0) / 65536.0


def b3(t: float) -> float:
    """The cubic B-spline."""
    t = abs(t)
    if t < 1.0:
        return 2.0 / 3.0 - t * t + t**3 / 2.0
    return max(0.0, 2.0 - t) ** 3 / 6.0


def waves(key: int, row: int, column: int, shape: tuple[int, int], pace: float) -> Any:
    shift = [(mixed(key ^ m) >> 31) / 2.0**33 for m in (0xBF58476D1CE4E5B9, 0x94D049BB133111EB)]
    out = np.zeros(shape)
    for i in range(shape[0]):
        for j in range(shape[1]):
            y, x = (row + i + 0.5) * pace + shift[0], (column + j + 0.5) * pace + shift[1]
            out[i, j] = sum(
                b3(y - m) * b3(x - n) * deviate(key, m, n)
                for m in range(math.floor(y) - 2, math.floor(y) + 4)
                for n in range(math.floor(x) - 2, math.floor(x) + 4)
            )
    return out


def cratered(craters: Any, profile: Any, reach: float, shape: tuple[int, int]) -> Any:
    """Sum of D profile(r, wear) over all craters within `reach` radii."""
    out = np.zeros(shape)
    for x, y, radius, diameter, wear in craters:
        for i in range(shape[0]):
            for j in range(shape[1]):
                r = math.hypot(i + 0.5 - y, j + 0.5 - x) / radius
                if r < reach:
                    out[i, j] += diameter * profile(r, wear)
    return out


def sunk(pits: Any, shape: tuple[int, int]) -> Any:
    out = np.zeros(shape)
    for x, y, radius, depth, wall in pits:
        for i in range(shape[0]):
            for j in range(shape[1]):
                s = (radius - math.hypot(i + 0.5 - y, j + 0.5 - x)) / wall
                if s > 0:
                    s = min(s, 1.0)
                    out[i, j] = min(out[i, j], -depth * (3 * s**2 - 2 * s**3))
    return out
