"""Craters dug into a grid. Symbols: x, y middle, R radius [cells], D diameter [m], K wear [1]."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._jit import kernel

F64: TypeAlias = NDArray[np.float64]


@kernel()
def dig_craters(craters: F64, table: F64, finest: float, out: F64) -> None:
    """Add the profiles of `craters` (n, 5), each x, y, R, D and wear w, to `out` (h, w) [m].

    ``table[a, b]`` is the height over the old ground as a share of D, at the wear w = a and at
    b * `finest` radii from the middle; between its entries it is interpolated, and beyond it is 0.
    """
    h, w = out.shape
    ages, places = table.shape
    reach = (places - 1) * finest
    for n in range(len(craters)):
        x, y, r, d, wear = craters[n]
        a = min(int(wear), ages - 2)
        s = wear - a
        for i in range(max(0, int(np.floor(y - r * reach))), min(h, int(y + r * reach) + 2)):
            for j in range(max(0, int(np.floor(x - r * reach))), min(w, int(x + r * reach) + 2)):
                far = np.hypot(i + 0.5 - y, j + 0.5 - x) / (r * finest)
                b = int(far)
                if b >= places - 1:
                    continue
                t = far - b
                new = (1.0 - t) * table[a, b] + t * table[a, b + 1]
                old = (1.0 - t) * table[a + 1, b] + t * table[a + 1, b + 1]
                out[i, j] += d * ((1.0 - s) * new + s * old)


@kernel()
def sink_pits(pits: F64, out: F64) -> None:
    """Lower `out` (h, w) by `pits` (n, 5): x, y, R [cells], depth [m], width of the wall [cells].

    The floor is level; the wall is a smooth step that ends at the radius. Where pits overlap the
    deeper one counts, so that order does not matter: `out` holds depths, 0 or below.
    """
    h, w = out.shape
    for n in range(len(pits)):
        x, y, r, depth, wall = pits[n]
        for i in range(max(0, int(np.floor(y - r))), min(h, int(y + r) + 2)):
            for j in range(max(0, int(np.floor(x - r))), min(w, int(x + r) + 2)):
                s = (r - np.hypot(i + 0.5 - y, j + 0.5 - x)) / wall
                if s > 0.0:
                    s = min(s, 1.0)
                    out[i, j] = min(out[i, j], -depth * s * s * (3.0 - 2.0 * s))
