"""Coarse grids out of fine ones, and back.

Symbols: c cost per cell (h, w), inf where blocked; k cells to a side of a block; blocks at the
north and east edge may be smaller.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ._jit import kernel


@kernel()
def pool(c: Any, k: int, out: Any) -> None:
    """Write the mean cost of the free cells of each block to `out`; inf where none is free."""
    h, w = c.shape
    total = np.empty(out.shape[1])
    count = np.empty(out.shape[1], np.int64)
    for block in range(out.shape[0]):
        total[:] = 0.0
        count[:] = 0
        for i in range(block * k, min(h, (block + 1) * k)):
            for j in range(w):
                here = c[i, j]
                if here < np.inf:
                    total[j // k] += here
                    count[j // k] += 1
        for j in range(out.shape[1]):
            out[block, j] = total[j] / count[j] if count[j] > 0 else np.inf


@kernel()
def unpool(c: Any, chosen: Any, k: int, ring: int, out: Any) -> None:
    """Write the costs of all cells in chosen blocks to `out`, which is inf elsewhere.

    Args:
        c: Cost per cell (h, w).
        chosen: 1 for the blocks to take.
        k: Cells to a side of a block.
        ring: Cells around the grid in `out`.
        out: A grid (h + 2 ring, w + 2 ring) of inf.
    """
    h, w = c.shape
    for block in range(chosen.shape[0]):
        for other in range(chosen.shape[1]):
            if chosen[block, other]:
                left, right = other * k, min(w, (other + 1) * k)
                for i in range(block * k, min(h, (block + 1) * k)):
                    for j in range(left, right):
                        out[i + ring, j + ring] = c[i, j]
