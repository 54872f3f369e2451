"""NumPy with every large array made beforehand."""

from __future__ import annotations

from typing import Any

import numpy as np
from harness.model import Result, Stopwatch, Trial

from . import task


def build(batches: int) -> Trial:
    """Forward, backward and step in place; the matrix products are BLAS's."""
    x, y = task.data(batches)

    def trial(repeats: int) -> Result:
        watch, step = Stopwatch(), _Step()
        for _ in range(repeats):
            step = _Step()
            with watch:
                for at in range(0, len(x), task.BATCH):
                    step.take(x[at : at + task.BATCH], y[at : at + task.BATCH])
        return watch.result(repeats * len(x), task.error(step.w, x, y))

    return trial


class _Step:
    """Weights, their velocities and the room that a step needs."""

    def __init__(self) -> None:
        self.w = task.start()
        self.v = [np.zeros_like(w) for w in self.w]
        self.g = [np.empty_like(w) for w in self.w]
        self.h1, self.h2, self.d1, self.d2 = (
            np.empty((task.BATCH, units), np.float32) for units in (64, 64, 64, 64)
        )

    def take(self, x: Any, y: Any) -> None:
        """One step of gradient descent with momentum on one batch."""
        w1, b1, w2, b2, w3, b3 = self.w
        self._layer(x, w1, b1, self.h1)
        self._layer(self.h1, w2, b2, self.h2)
        e = self.h2 @ w3
        e += b3
        e -= y
        e /= np.float32(task.BATCH)
        self._gradient(4, self.h2, e)
        np.matmul(e, w3.T, out=self.d2)
        self._slope(self.d2, self.h2)
        self._gradient(2, self.h1, self.d2)
        np.matmul(self.d2, w2.T, out=self.d1)
        self._slope(self.d1, self.h1)
        self._gradient(0, x, self.d1)
        for w, v, g in zip(self.w, self.v, self.g, strict=True):
            v *= np.float32(task.MOMENTUM)
            v += g
            w -= np.float32(task.ETA) * v

    @staticmethod
    def _layer(x: Any, w: Any, b: Any, out: Any) -> None:
        np.matmul(x, w, out=out)
        out += b
        np.tanh(out, out=out)

    @staticmethod
    def _slope(d: Any, h: Any) -> None:
        """Multiply d by tanh's slope; the outputs h are not needed any more."""
        np.multiply(h, h, out=h)
        np.subtract(1, h, out=h)
        d *= h

    def _gradient(self, layer: int, below: Any, d: Any) -> None:
        np.matmul(below.T, d, out=self.g[layer])
        d.sum(0, out=self.g[layer + 1])
