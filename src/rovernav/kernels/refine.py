"""A finer grid under a coarse one, whose means over coarse cells stay what they are.

Symbols: z coarse heights [m], n fine cells along a coarse one, u, v place within a coarse cell, 0
to 1. All arrays are C-ordered; a missing coarse height is NaN in `known`, and filled in `z`.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from ._jit import kernel

F64: TypeAlias = NDArray[np.float64]


@kernel()
def smooth(z: F64, n: int, margin: int, out: F64) -> None:
    """Write a smooth surface through `z` to `out`, each coarse cell as n x n fine ones.

    ``z[margin, margin]`` is the coarse cell under ``out[0, 0]``; the margin is at least 3. Cubic
    convolution (R. G. Keys, IEEE Trans. ASSP 29, 1981) through z minus a 24th of its second
    differences, so that means over coarse cells come out nearly right (to fourth order).
    """
    h, w = out.shape
    rows, columns = z.shape
    sharp = z.copy()
    for i in range(1, rows - 1):
        for j in range(1, columns - 1):
            bend = z[i - 1, j] + z[i + 1, j] + z[i, j - 1] + z[i, j + 1] - 4.0 * z[i, j]
            sharp[i, j] = z[i, j] - bend / 24.0
    for i in range(h):
        y = (i + 0.5) / n - 0.5 + margin
        below = int(np.floor(y))
        v = y - below
        for j in range(w):
            x = (j + 0.5) / n - 0.5 + margin
            left = int(np.floor(x))
            u = x - left
            total = 0.0
            for a in range(4):
                line = 0.0
                for b in range(4):
                    line += cubic(u, b) * sharp[below - 1 + a, left - 1 + b]
                total += cubic(v, a) * line
            out[i, j] = total


@kernel()
def cubic(u: float, n: int) -> float:
    """Weight of post n = 0 ... 3 at a place u between posts 1 and 2 (Keys, a = -1/2)."""
    if n == 0:
        return ((-0.5 * u + 1.0) * u - 0.5) * u
    if n == 1:
        return (1.5 * u - 2.5) * u * u + 1.0
    if n == 2:
        return ((-1.5 * u + 2.0) * u + 0.5) * u
    return (0.5 * u - 0.5) * u * u


@kernel()
def keep_means(known: F64, n: int, bump: F64, out: F64) -> None:
    """Shift `out` so that its mean over each n x n block is the coarse height in `known` (r, c).

    What a block is off by is taken away in the shape of `bump` (n,) along both sides, whose mean
    is 1 and which is small at the ends, so that no steps arise between blocks. NaN in, NaN out.
    """
    for r in range(known.shape[0]):
        for c in range(known.shape[1]):
            total = 0.0
            for i in range(n):
                for j in range(n):
                    total += out[r * n + i, c * n + j] - known[r, c]
            off = total / (n * n)
            for i in range(n):
                for j in range(n):
                    out[r * n + i, c * n + j] -= off * bump[i] * bump[j]
