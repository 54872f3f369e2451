"""The world and the rovers of all rows."""

from __future__ import annotations

from typing import Any

import numpy as np

SIDE, DISCS, ROVERS = 512, 1000, 4096
BEAMS, VIEW, REACH, PERIOD = 64, np.pi, 50.0, 0.2
SPEED, TURN = 1.0, 0.5
STEPS = 20


def discs(seed: int = 0) -> Any:
    """Middle x, y and radius of the obstacles (m, 3) [cells]."""
    rng = np.random.default_rng(seed)
    return np.c_[rng.uniform(0, SIDE, (DISCS, 2)), rng.uniform(1, 6, DISCS)]


def grid(seed: int = 0) -> Any:
    """Cells whose middle lies in a disc: about an eighth of them (h, w), uint8."""
    blocked = np.zeros((SIDE, SIDE), np.uint8)
    i, j = np.mgrid[0:SIDE, 0:SIDE] + 0.5
    for x, y, r in discs(seed):
        part = tuple(slice(max(0, int(v - r - 1)), int(v + r + 2)) for v in (y, x))
        blocked[part] |= (np.hypot(j[part] - x, i[part] - y) < r).astype(np.uint8)
    return blocked


def starts(blocked: Any, rovers: int, seed: int = 1) -> Any:
    """Poses on free cells, farther from the edge than a beam reaches (n, 3)."""
    rng = np.random.default_rng(seed)
    margin = int(REACH) + 10
    inner = blocked[margin:-margin, margin:-margin]
    free = np.argwhere(inner == 0)[:, ::-1] + margin + 0.5
    chosen = free[rng.integers(len(free), size=rovers)]
    return np.c_[chosen, rng.uniform(-np.pi, np.pi, rovers)]


def angles() -> Any:
    """Directions of the beams from right to left [rad]."""
    return np.linspace(-VIEW / 2, VIEW / 2, BEAMS)
