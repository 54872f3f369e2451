"""What a rover sees of the ground, place by place and beam by beam."""

from __future__ import annotations

import math

import numpy as np

from tests.naive import noise, ridges, settle
from tests.naive.elevation import ground_at


def patch(z, cell, pose, places, eyes, luck):
    """Heights of places over the ground under the rover; NaN where nothing is seen."""
    (key, step), out = luck, []
    base = ground_at(z, cell, pose[0], pose[1])
    eye = np.array([pose[0], pose[1], base + eyes["mast"]])
    turn = complex(math.cos(pose[2]), math.sin(pose[2]))
    for m, place in enumerate(places):
        way = turn * complex(*place)
        x, y = pose[0] + way.real, pose[1] + way.imag
        target = np.array([x, y, ground_at(z, cell, x, y)])
        lost = noise.share(key, step, 4 * m) < eyes["lose"]
        if lost or not math.isfinite(target[2] - base):
            out.append(math.nan)
            continue
        far = math.dist(eye, target)
        t = ridges.first_rise(eye, target, z, cell)
        free = t is None or (1 - t) * far <= eyes["slack"]
        error = eyes["noise"] * far**2 * noise.deviate(key, step, 4 * m + 1)
        out.append(target[2] - base + error if free else math.nan)
    return out


def down(z, cell, pose, attitude, mounts, beam):
    """How far it is along beams that look ahead and down from a body that stands so."""
    spin = settle.rotation(attitude[1], attitude[2], pose[2])
    foot = np.array([pose[0], pose[1], ground_at(z, cell, pose[0], pose[1])])
    angles, reach = beam
    out = []
    for mount, angle in zip(mounts, angles, strict=True):
        way = spin @ np.array([math.cos(angle), 0.0, -math.sin(angle)])
        eye = foot + spin @ np.array(mount)
        t = ridges.first_rise(eye, eye + reach * way, z, cell)
        out.append(reach if t is None else reach * t)
    return out


def infrared(distances, key, step, curve):
    """What a triangulating sensor makes of distances: volts, counts, a table."""
    rows, out, top = [(float(d), float(v)) for d, v in curve.rows], [], len(curve.counts) - 1
    for b, d in enumerate(distances):
        volts = noise.volts(d, rows)
        volts *= 1.0 + curve.noise * noise.deviate(key, step, 4 * b + 2)
        count = math.floor(volts / curve.volt * top + 0.5)
        out.append(float(curve.counts[min(max(count, 0), top)]))
    return out
