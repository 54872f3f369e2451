"""NumPy over all networks at once, the network on the last axis, in chunks that fit the cache."""

from __future__ import annotations

from typing import Any

import numpy as np
from harness.model import Result, Stopwatch, Trial

from . import task

CHUNK = 1024


def build(epochs: int) -> Trial:
    """Array arithmetic, changes in place."""

    def trial(repeats: int) -> Result:
        watch, w = Stopwatch(), task.start()
        with watch:
            for _ in range(repeats):
                w = task.start().copy()
                for at in range(0, task.NETWORKS, CHUNK):
                    w[at : at + CHUNK] = _train(epochs, w[at : at + CHUNK])
        return watch.result(repeats * epochs * task.PATTERNS * task.NETWORKS, task.flat_rmse(w))

    return trial


def _train(epochs: int, start: Any) -> Any:
    """The weights (n, 17) after training."""
    w = np.ascontiguousarray(start.T)
    v = np.zeros_like(w)
    hidden, out = w[:9].reshape(3, 3, -1), w[9:].reshape(2, 4, -1)
    vh, vo = v[:9].reshape(3, 3, -1), v[9:].reshape(2, 4, -1)
    table = list(zip(task.X, task.Y, strict=True))
    for _ in range(epochs):
        for x, y in table:
            h = 1.0 / (1.0 + np.exp(-(hidden[:, 0] * x[0] + hidden[:, 1] * x[1] + hidden[:, 2])))
            o = out[:, 0] * h[0] + out[:, 1] * h[1] + out[:, 2] * h[2] + out[:, 3]
            e = task.ETA * (y[:, None] - o)
            d = (e[0] * out[0, :3] + e[1] * out[1, :3]) * h * (1.0 - h)
            v *= task.MOMENTUM
            vo[:, :3] += e[:, None] * h
            vo[:, 3] += e
            for i in range(2):
                vh[:, i] += d * x[i]
            vh[:, 2] += d
            w += v
    return w.T
