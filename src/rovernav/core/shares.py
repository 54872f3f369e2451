"""Shares of trials, and how sure they are."""

from __future__ import annotations

import math


def wilson(successes: int, trials: int, *, z: float = 1.959964) -> tuple[float, float]:
    """95 % confidence interval of a share (Wilson 1927, JASA 22)."""
    share = successes / trials
    middle = share + z * z / (2 * trials)
    half = z * math.sqrt(share * (1 - share) / trials + z * z / (4 * trials * trials))
    scale = 1 + z * z / trials
    return max(0.0, (middle - half) / scale), min(1.0, (middle + half) / scale)
