"""NumPy, as a careful user writes it: a pattern at a time, changes in place."""

from __future__ import annotations

from typing import Any

import numpy as np
from harness.model import Result, Stopwatch, Trial

from . import task


def build(epochs: int) -> Trial:
    """One pattern at a time, all arithmetic in arrays."""

    def trial(repeats: int) -> Result:
        watch, weights = Stopwatch(), task.parts(task.start())
        for _ in range(repeats):
            weights = task.parts(task.start())
            with watch:
                _train(epochs, *weights)
        return watch.result(repeats * epochs * task.PATTERNS, task.rmse(*weights))

    return trial


def _train(epochs: int, w1: Any, b1: Any, w2: Any, b2: Any) -> None:
    """Change the weights in place."""
    v1, c1, v2, c2 = (np.zeros_like(a) for a in (w1, b1, w2, b2))
    table = list(zip(task.X, task.Y, strict=True))
    for _ in range(epochs):
        for x, y in table:
            h = 1.0 / (1.0 + np.exp(-(w1 @ x + b1)))
            e = task.ETA * (y - (w2 @ h + b2))
            d = (e @ w2) * h * (1.0 - h)
            for w, v, change in (
                (w2, v2, e[:, None] * h),
                (b2, c2, e),
                (w1, v1, d[:, None] * x),
                (b1, c1, d),
            ):
                v *= task.MOMENTUM
                v += change
                w += v
