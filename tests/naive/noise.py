"""Sensor noise in plain Python, with whole numbers of any size."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

WORD = 2**64


def mixed(word: int) -> int:
    word = (word + 0x9E3779B97F4A7C15) % WORD
    word = (word ^ (word >> 30)) * 0xBF58476D1CE4E5B9 % WORD
    word = (word ^ (word >> 27)) * 0x94D049BB133111EB % WORD
    return word ^ (word >> 31)


def key_of(seed: int, number: int) -> int:
    return mixed(mixed(seed % WORD) ^ (number % WORD))


def word_of(key: int, i: int, j: int) -> int:
    return mixed(mixed(key ^ (i % WORD)) ^ (j % WORD))


def share(key: int, i: int, j: int) -> float:
    return (word_of(key, i, j) >> 11) / 2**53


def deviate(key: int, i: int, j: int) -> float:
    word = word_of(key, i, j)
    parts = [(word >> shift) & 0xFFFF for shift in (0, 16, 32, 48)]
    return (sum(parts) - 131070.0) * (math.sqrt(3.0) / 65536.0)


def spoilt(
    true: Sequence[float], key: int, step: int, before: Sequence[int], reach: float, p: dict
) -> tuple[list[int], list[float]]:
    """Since when each beam is lost (above 0) or astray (below 0), and what is read."""
    now: list[int] = []
    read: list[float] = []
    for b, r in enumerate(true):
        luck, was = share(key, step, 4 * b), before[b]
        if was:
            stays = luck >= (p["find"] if was > 0 else p["back"])
            since = was if stays else 0
        elif r < reach and luck < p["lose"] * r:
            since = step
        elif r < reach and luck < (p["lose"] + p["stray"]) * r:
            since = -step
        else:
            since = 0
        now.append(since)
        if since > 0 or r >= reach:
            read.append(reach)
            continue
        if since < 0:
            got = r + p["spread"] * deviate(key, -since, 4 * b + 1)
        else:
            s = p["core"] + p["relative"] * r
            got = r + s * deviate(key, step, 4 * b + 2) * deviate(key, step, 4 * b + 3)
        if p["grain"]:
            got = math.floor(got / p["grain"] + 0.5) * p["grain"]
        read.append(min(max(got, p["least"]), reach))
    return now, read


def volts(d: float, rows: Sequence[tuple[float, float]]) -> float:
    if d >= rows[-1][0]:
        return rows[-1][1] * rows[-1][0] / d
    for (d0, v0), (d1, v1) in itertools.pairwise(rows):
        if d < d1:
            return v0 + (d - d0) / (d1 - d0) * (v1 - v0)
    return rows[-1][1]
