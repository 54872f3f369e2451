"""What all peers train: the paper's four patterns, from the weights that `rovernav sweep` draws."""

from __future__ import annotations

import functools
import os
from typing import Any

import numpy as np

X = np.array([[0, 0], [0, 1], [1, 0], [1, 1]], dtype=np.float64)
Y = np.array([[1, 1], [1, 1], [1, 0], [1, -1]], dtype=np.float64)
ETA, MOMENTUM = 0.25, 0.5
PATTERNS, NETWORKS = len(X), 10_240


@functools.cache
def start() -> Any:
    """First weights (n, 17): unit by unit, incoming weights first, bias last."""
    out = np.empty((NETWORKS, 17))
    for seed, row in enumerate(out):
        rng = np.random.default_rng(seed)
        row[:9] = rng.uniform(-1.0, 1.0, 9) / np.sqrt(2)
        row[9:] = rng.uniform(-1.0, 1.0, 8) / np.sqrt(3)
    return out


def parts(w: Any) -> tuple[Any, Any, Any, Any]:
    """Copies of w1 (n, 3, 2), b1 (n, 3), w2 (n, 2, 3), b2 (n, 2)."""
    hidden, out = w[:, :9].reshape(-1, 3, 3), w[:, 9:].reshape(-1, 2, 4)
    views = (hidden[:, :, :2], hidden[:, :, 2], out[:, :, :3], out[:, :, 3])
    return tuple(np.ascontiguousarray(view) for view in views)


def rmse(w1: Any, b1: Any, w2: Any, b2: Any) -> float:
    """Root of the mean squared error over all networks, patterns and outputs."""
    sums = np.einsum("nhi,pi->nph", np.asarray(w1), X) + np.asarray(b1)[:, None, :]
    hidden = 1.0 / (1.0 + np.exp(-sums))
    outputs = np.einsum("noh,nph->npo", np.asarray(w2), hidden) + np.asarray(b2)[:, None, :]
    return float(np.sqrt(np.mean((outputs - Y) ** 2)))


def flat_rmse(w: Any) -> float:
    """`rmse` of weights (n, 17)."""
    return rmse(*parts(np.asarray(w)))


def expected(_group: str, epochs: int) -> float | None:
    """The error to end with: plain C, NumPy and rovernav agree on it to 14 digits."""
    return {20: 0.213887233398849, 1000: 0.00201509711280940}.get(epochs)


def hold_to_one_core() -> None:
    """Keep this process on one core: XLA and inductor take no thread count for all they do."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
