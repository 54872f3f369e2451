"""Cost to go: the eikonal equation |grad u| = f by fast sweeping (Zhao 2005, Math. Comp. 74).

Symbols: u cost to go, f cost per cell (inf where blocked), a and b the smaller neighbours of a cell
along the rows and along the columns. Lengths are in cells.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ._jit import kernel


@kernel()
def sweep(f: Any, u: Any, tolerance: float, most: int) -> int:
    """Lower `u` (h, w) to the solution whose seeds it holds.

    Args:
        f: Cost per cell (h, w), > 0; inf where blocked.
        u: Seeds with their costs, inf elsewhere; changed to the cost to go.
        tolerance: Stop once a round of four sweeps lowers no cell by more.
        most: Rounds at most.

    Returns:
        Rounds done.
    """
    h, w = u.shape
    for done in range(most):
        change = 0.0
        for corner in range(4):
            for step_i in range(h):
                i = step_i if corner < 2 else h - 1 - step_i
                for step_j in range(w):
                    j = step_j if corner % 2 == 0 else w - 1 - step_j
                    if f[i, j] < np.inf:
                        new = _cell(f[i, j], u, i, j)
                        if new < u[i, j]:
                            old = u[i, j]
                            change = max(change, old - new if old < np.inf else np.inf)
                            u[i, j] = new
        if change <= tolerance:
            return done + 1
    return most


@kernel(inline=True)
def _cell(f: float, u: Any, i: int, j: int) -> float:
    """Godunov's upwind value of one cell."""
    h, w = u.shape
    a = min(u[i - 1, j] if i > 0 else np.inf, u[i + 1, j] if i < h - 1 else np.inf)
    b = min(u[i, j - 1] if j > 0 else np.inf, u[i, j + 1] if j < w - 1 else np.inf)
    if abs(a - b) >= f or a == np.inf or b == np.inf:
        return min(a, b) + f
    return 0.5 * (a + b + np.sqrt(2.0 * f * f - (a - b) * (a - b)))
