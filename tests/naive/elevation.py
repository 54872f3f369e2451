"""Seeing, fusing and judging ground in plain Python: cells in dictionaries, no rolling."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np

Cell = tuple[int, int]


def ground_at(z: np.ndarray, cell: float, x: float, y: float) -> float:
    """Bilinear between posts, level within half a cell of the edge, NaN beyond."""
    h, w = z.shape
    u, v = x / cell - 0.5, y / cell - 0.5
    if not (-0.5 <= u <= w - 0.5 and -0.5 <= v <= h - 0.5):
        return math.nan
    u, v = min(max(u, 0.0), w - 1.0), min(max(v, 0.0), h - 1.0)
    j, i = min(int(u), w - 2), min(int(v), h - 2)
    u, v = u - j, v - i
    near = [(1 - v) * (1 - u), (1 - v) * u, v * (1 - u), v * u]
    posts = [z[i, j], z[i, j + 1], z[i + 1, j], z[i + 1, j + 1]]
    return sum(a * float(b) for a, b in zip(near, posts, strict=True) if a)


def hidden(z: np.ndarray, cell: float, eye: Any, target: Any, slack: float) -> float:
    """How far the ground rises over the line from an eye to a target, by many samples [m].

    Samples nearer to the target than `slack` do not count.
    """
    length = math.dist(eye, target)
    worst = -math.inf
    for n in range(1, 2000):
        t = n / 2000
        if (1 - t) * length <= slack:
            break
        x, y, up = (a + t * (b - a) for a, b in zip(eye, target, strict=True))
        ground = ground_at(z, cell, x, y)
        worst = max(worst, ground - up if ground == ground else -math.inf)
    return worst


def cell_at(pose: Any, place: Any, c: float) -> Cell:
    turn = complex(math.cos(pose[2]), math.sin(pose[2])) * complex(*place)
    return math.floor((pose[1] + turn.imag) / c), math.floor((pose[0] + turn.real) / c)


def inside(cell: Cell, centre: Cell, s: int) -> bool:
    return all(-s // 2 <= a - b < s // 2 for a, b in zip(cell, centre, strict=True))


def variance_of(f: Any, place: Any, up: float) -> float:
    rr = place[0] ** 2 + place[1] ** 2 + (f.mast - up) ** 2
    return f.least + (f.noise * rr) ** 2


def fused(
    known: dict[Cell, tuple[float, ...]], pose: Any, z: float, places: Any, patch: Any, f: Any
) -> None:
    """Take a patch into {cell: (height, variance, top)}; float32 as the map is."""
    for place, up in zip(places, patch, strict=True):
        if math.isnan(up):
            continue
        at, v, new = cell_at(pose, place, f.cell), variance_of(f, place, up), z + up
        if at not in known:
            got = (new, v, -math.inf)
        else:
            h, w, top = known[at]
            if abs(new - h) <= 3.0 * math.sqrt(w + v):
                got = ((h / w + new / v) / (1 / w + 1 / v), 1 / (1 / w + 1 / v), top)
            else:
                got = (new, v, top) if new > h else (h, w + v, top)
        peak = max(got[2], new - f.sure * math.sqrt(v))
        known[at] = (float(np.float32(got[0])), float(np.float32(got[1])), float(np.float32(peak)))


def slope_at(known: dict[Cell, tuple[float, ...]], at: Cell, p: Any) -> float:
    """Slope [rad] of the plane through the known cells around, by least squares; NaN: too few."""
    span = range(-p.half, p.half + 1)
    rows = [
        (j * p.cell, i * p.cell, 1.0, known[at[0] + i, at[1] + j][0])
        for i, j in itertools.product(span, span)
        if (at[0] + i, at[1] + j) in known
    ]
    if len(rows) < 0.6 * len(span) ** 2:
        return math.nan
    table = np.array(rows)
    fit, _, rank, _ = np.linalg.lstsq(table[:, :3], table[:, 3], rcond=None)
    return math.atan(math.hypot(fit[0], fit[1])) if rank == 3 else math.nan


def ledge_at(known: dict[Cell, tuple[float, ...]], at: Cell, p: Any) -> float:
    if at not in known:
        return math.nan
    most, span = 0.0, range(-p.wheel, p.wheel + 1)
    for i, j in itertools.product(span, span):
        other = (at[0] + i, at[1] + j)
        far = math.hypot(i, j)
        if other not in known or not 0 < far <= p.wheel:
            continue
        for high, low in ((at, other), (other, at)):
            height, variance, _ = known[low]
            rise = known[high][2] - height - p.sure * math.sqrt(variance)
            if rise > p.slope * p.cell * far:
                most = max(most, rise)
    return most


def dropped(
    known: dict[Cell, tuple[float, ...]], stand: Any, lean: Any, readings: Any, d: Any, f: Any
) -> None:
    """Take what sensors that look down read into what is known."""
    for mount, angle, r in zip(d.mounts, d.angle, readings, strict=True):
        way = _leaning(stand[2], lean) @ [math.cos(angle), 0.0, -math.sin(angle)]
        eye = _leaning(stand[2], lean) @ mount + [stand[0], stand[1], stand[3]]
        end, doubt = eye + r * way, float(np.interp(r, *d.doubt.T))
        v = f.least + (doubt * way[2]) ** 2 + (r * d.tilt) ** 2
        found = (end[2], v, end[2] - f.sure * math.sqrt(v))
        across, half = math.hypot(*way[:2]), 0.5 * f.cell
        under = [
            tuple(math.floor(at / f.cell) for at in (end - m * half / across * way)[[1, 0]])
            for m in range(int(r * across / half) + 1)
        ]
        same = under[0] in known and abs(known[under[0]][0] - end[2]) <= 3.0 * math.sqrt(v)
        back = next((m for m, at in enumerate(under) if at in known and at != under[0]), 0)
        if back and not same:
            drop = known[under[back]][0] - end[2]
            if drop > max(d.step, d.slope * half * back) + f.sure * math.sqrt(v):
                for at in under[:back]:
                    known.setdefault(at, found)
        if r < d.reach:
            known.setdefault(under[0], found)


def _leaning(heading: float, lean: Any) -> np.ndarray:
    """From the body's frame to the world's: rolled, then pitched nose up, then turned."""
    (p, r), a = lean, heading
    roll = [[1, 0, 0], [0, math.cos(r), -math.sin(r)], [0, math.sin(r), math.cos(r)]]
    pitch = [[math.cos(p), 0, -math.sin(p)], [0, 1, 0], [math.sin(p), 0, math.cos(p)]]
    turn = [[math.cos(a), -math.sin(a), 0], [math.sin(a), math.cos(a), 0], [0, 0, 1]]
    return np.array(turn) @ np.array(pitch) @ np.array(roll)
