"""Rocks set onto a grid. Symbols: x, y middle [cells], a radius [cells], b height [m]."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._jit import kernel

F64: TypeAlias = NDArray[np.float64]


@kernel()
def raise_rocks(rocks: F64, rise: F64) -> None:
    """Raise `rise` (h, w) [m] to the tops of `rocks` (n, 4): x, y, a [cells], b [m].

    Over a cell centre at distance d from the middle a rock is b sqrt(1 - (d/a)^2) high; the cell
    that holds the middle gets b. Where rocks overlap the highest counts, so order does not matter.
    """
    h, w = rise.shape
    for n in range(len(rocks)):
        x, y, a, b = rocks[n, 0], rocks[n, 1], rocks[n, 2], rocks[n, 3]
        for i in range(max(0, int(np.floor(y - a))), min(h, int(np.ceil(y + a)) + 1)):
            for j in range(max(0, int(np.floor(x - a))), min(w, int(np.ceil(x + a)) + 1)):
                near = ((i + 0.5 - y) / a) ** 2 + ((j + 0.5 - x) / a) ** 2
                if i == np.floor(y) and j == np.floor(x):
                    rise[i, j] = max(rise[i, j], b)
                elif near < 1.0:
                    rise[i, j] = max(rise[i, j], b * np.sqrt(1.0 - near))
