"""What infra-red sensors that look down add to a map of heights: ground that the eyes do not see.

Symbols as in `kernels.elevation`; r a reading [m], d the beam's direction.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ._jit import kernel
from .elevation import GATE, Fusion, at_cell
from .patches import turned


class Down(NamedTuple):
    """Sensors that look ahead and down.

    Attributes:
        mounts: Forward, left, and above the ground under the rover's middle (b, 3) [m].
        angle: Below the body's level (b,) [rad].
        reach: Who reads this far saw no ground [m].
        doubt: Readings, rising, and their standard deviations (t, 2) [m].
        tilt: Standard deviation of the body's tilt as the rover knows it [rad].
        step: Lowest drop that matters [m].
        slope: Tangent of the steepest slope that does not.
    """

    mounts: Any
    angle: Any
    reach: float
    doubt: Any
    tilt: float
    step: float
    slope: float


@kernel()
def take_drops(
    layers: Any, centre: Any, stand: Any, tilt: Any, readings: Any, d: Down, f: Fusion
) -> None:
    """Take readings of sensors that look down into the maps, where the eyes know nothing.

    The end of a beam, m + r d, is a height z of ground, with the variance

        v = least + (doubt(r) d_z)^2 + (r tilt)^2,

    and at most z where the beam reads its reach. Going back from it, the last cell under the beam
    that is known has height h and lies w away. If h - z > max(step, slope w) + sure sqrt(v), there
    is a drop in between, and every unknown cell there gets z and v: it may begin right after what
    is known. Otherwise the end's own cell does, if it is unknown and the beam has an end.

    Args:
        layers: Heights [m], variances [m^2] and tops [m] (n, s, s) each, changed.
        centre: Cell of each rover (n, 2).
        stand: Where the rovers think they are, and the height of the ground there (n, 4).
        tilt: Pitch and roll as the rovers know them (n, 2) [rad].
        readings: (n, b) [m]; NaN tells nothing.
        d: The sensors.
        f: How heights are taken in.
    """
    for k in range(stand.shape[0]):
        lean = (0.0, tilt[k, 0], tilt[k, 1])
        for b in range(d.mounts.shape[0]):
            r = readings[k, b]
            if r != r:
                continue
            way = turned(math.cos(d.angle[b]), 0.0, -math.sin(d.angle[b]), stand[k], lean)
            x, y, z = turned(d.mounts[b, 0], d.mounts[b, 1], d.mounts[b, 2], stand[k], lean)
            end = (stand[k, 0] + x + r * way[0], stand[k, 1] + y + r * way[1])
            low = stand[k, 3] + z + r * way[2]
            v = f.least + (_doubt(r, d.doubt) * way[2]) ** 2 + (r * d.tilt) ** 2
            back = _last_known(layers[0], k, centre, (end, way, r), (low, v), f)
            if back > 0:
                _fall(layers, k, centre, (end, way, back), (low, v), d, f)
            if r < d.reach:
                _learn(layers, k, centre, end, (low, v), f)


@kernel()
def _last_known(height: Any, k: int, centre: Any, beam: Any, found: Any, f: Fusion) -> int:
    """Half cells back along a beam to the last known cell before its end, -1 where there is none.

    -1 too where the end's own cell is known and says the same.
    """
    end, way, r = beam
    s, across = height.shape[1], math.hypot(way[0], way[1])
    last = at_cell(end[0], end[1], k, centre, s, f.cell)
    if last[0] >= 0 and abs(np.float64(height[k, last[0], last[1]]) - found[0]) <= GATE * math.sqrt(
        found[1]
    ):
        return -1
    for m in range(1, int(r * across / (0.5 * f.cell)) + 1):
        back = 0.5 * f.cell * m / across
        x, y = end[0] - back * way[0], end[1] - back * way[1]
        i, j = at_cell(x, y, k, centre, s, f.cell)
        if i >= 0 and (i, j) != last and not np.isnan(height[k, i, j]):
            return m
    return -1


@kernel()
def _fall(layers: Any, k: int, centre: Any, beam: Any, found: Any, d: Down, f: Fusion) -> None:
    """Where ground falls off between a known cell and a beam's end, the cells between are low."""
    end, way, back = beam
    part = 0.5 * f.cell / math.hypot(way[0], way[1])
    t = part * back
    i, j = at_cell(end[0] - t * way[0], end[1] - t * way[1], k, centre, layers[0].shape[1], f.cell)
    drop, apart = np.float64(layers[0][k, i, j]) - found[0], 0.5 * f.cell * back
    if drop > max(d.step, d.slope * apart) + f.sure * math.sqrt(found[1]):
        for m in range(back):
            t = part * m
            _learn(layers, k, centre, (end[0] - t * way[0], end[1] - t * way[1]), found, f)


@kernel()
def _doubt(r: float, table: Any) -> float:
    """Standard deviation of a reading, between the rows of a table [m]."""
    last = table.shape[0] - 1
    for i in range(1, last + 1):
        if r < table[i, 0]:
            share = max(0.0, (r - table[i - 1, 0]) / (table[i, 0] - table[i - 1, 0]))
            return table[i - 1, 1] + share * (table[i, 1] - table[i - 1, 1])
    return table[last, 1]


@kernel()
def _learn(layers: Any, k: int, centre: Any, place: Any, found: Any, f: Fusion) -> None:
    """A height and its variance in a cell that is unknown."""
    height, variance, top = layers
    i, j = at_cell(place[0], place[1], k, centre, height.shape[1], f.cell)
    if i >= 0 and np.isnan(height[k, i, j]):
        height[k, i, j], variance[k, i, j] = found[0], found[1]
        top[k, i, j] = found[0] - f.sure * math.sqrt(found[1])
