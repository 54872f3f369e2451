"""What all peers train: a policy network's regression, in order, batch by batch."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

SIZES = (48, 64, 64, 2)
BATCH = 256
ETA, MOMENTUM = 0.05, 0.9
SCORED = 20_000
"""Rows on which the error after the epoch is taken."""


def rows(batches: int) -> int:
    """Rows of an epoch."""
    return batches * BATCH


def start() -> list[Any]:
    """w1 (48, 64), b1 (64,), w2 (64, 64), b2 (64,), w3 (64, 2), b3 (2,), float32."""
    rng, out = np.random.default_rng(3), []
    for inputs, units in itertools.pairwise(SIZES):
        out.append((rng.uniform(-1.0, 1.0, (inputs, units)) / np.sqrt(inputs)).astype(np.float32))
        out.append(np.zeros(units, np.float32))
    return out


def data(batches: int) -> tuple[Any, Any]:
    """Inputs (n, 48) and targets (n, 2), float32: a smooth function of normal noise."""
    rng = np.random.default_rng(4)
    x = rng.standard_normal((rows(batches), 48), dtype=np.float32)
    inner = rng.standard_normal((48, 32), dtype=np.float32) / 7
    outer = rng.standard_normal((32, 2), dtype=np.float32) / 5.6
    return x, np.ascontiguousarray(np.tanh(x @ inner) @ outer)


def error(weights: list[Any], x: Any, y: Any) -> float:
    """Mean squared error on the first rows."""
    w1, b1, w2, b2, w3, b3 = (np.asarray(w) for w in weights)
    hidden = np.tanh(np.tanh(x[:SCORED] @ w1 + b1) @ w2 + b2)
    return float(np.mean((hidden @ w3 + b3 - y[:SCORED]) ** 2))
