"""What all peers train: the paper's four patterns, the same start, and the error to end with."""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np

X = np.array([[0, 0], [0, 1], [1, 0], [1, 1]], dtype=np.float64)
Y = np.array([[1, 1], [1, 1], [1, 0], [1, -1]], dtype=np.float64)
ETA, MOMENTUM = 0.25, 0.9
PATTERNS = len(X)


def start() -> Any:
    """The 17 weights to begin with: unit by unit, incoming weights first, bias last."""
    return np.random.default_rng(1).uniform(-0.5, 0.5, 17)


def matrices(w: Any) -> tuple[Any, Any]:
    """Copies of the hidden (3, 3) and the output (2, 4) weights, bias column last."""
    return w[:9].reshape(3, 3).copy(), w[9:].reshape(2, 4).copy()


def parts(w: Any) -> tuple[Any, Any, Any, Any]:
    """Copies of w1 (3, 2), b1 (3,), w2 (2, 3), b2 (2,)."""
    hidden, out = matrices(w)
    return hidden[:, :2].copy(), hidden[:, 2].copy(), out[:, :3].copy(), out[:, 3].copy()


def rmse(w1: Any, b1: Any, w2: Any, b2: Any) -> float:
    """Root of the mean squared error over all patterns and outputs."""
    hidden = 1.0 / (1.0 + np.exp(-(X @ np.asarray(w1).T + np.asarray(b1))))
    outputs = hidden @ np.asarray(w2).T + np.asarray(b2)
    return float(np.sqrt(np.mean((outputs - Y) ** 2)))


def flat_rmse(w: Any) -> float:
    """`rmse` of 17 weights in one array."""
    return rmse(*parts(np.asarray(w)))


@functools.cache
def expected(rule: str, epochs: int) -> float:
    """The error that exact arithmetic ends with: the workload in plain Python, as a reference."""
    hidden, out = (m.tolist() for m in matrices(start()))
    changes = [[0.0] * 3 for _ in hidden], [[0.0] * 4 for _ in out]
    table = [([*x, 1.0], y) for x, y in zip(X.tolist(), Y.tolist(), strict=True)]
    for _ in range(epochs):
        for x, y in table:
            h = [1.0 / (1.0 + math.exp(-_dot(row, x))) for row in hidden] + [1.0]
            d = [want - _dot(row, h) for row, want in zip(out, y, strict=True)]
            old = [row[:] for row in out]
            _change(out, changes[1], d, h)
            above = out if rule == "paper" else old
            back = [sum(e * row[j] for e, row in zip(d, above, strict=True)) for j in range(3)]
            _change(hidden, changes[0], [e * o * (1.0 - o) for e, o in zip(back, h)], x)  # noqa: B905
    return flat_rmse(np.array([w for row in hidden + out for w in row]))


def _dot(a: list[float], b: list[float]) -> float:
    return sum(p * q for p, q in zip(a, b, strict=True))


def _change(w: list[Any], v: list[Any], d: list[float], source: list[float]) -> None:
    for row, last, e in zip(w, v, d, strict=True):
        for i, o in enumerate(source):
            last[i] = MOMENTUM * last[i] + ETA * e * o
            row[i] += last[i]
