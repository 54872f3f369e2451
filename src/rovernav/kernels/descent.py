"""Gradient descent over a table of patterns, batch by batch.

Symbols: w weights, g = dL/dw, eta learning rate, mu momentum, m last change or first moment,
v second moment, t number of the step (1 is the first).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from . import batch
from ._jit import kernel

SGD, ADAM = 0, 1
BETA1, BETA2, EPSILON = 0.9, 0.999, 1e-8
"""Adam's constants (Kingma and Ba 2015, section 2)."""


class State(NamedTuple):
    """Padded weights and what belongs to each of them, all (S,).

    Attributes:
        w: Weights.
        g: Gradient.
        m: Last change (SGD) or first moment (Adam).
        v: Second moment (Adam).
    """

    w: Any
    g: Any
    m: Any
    v: Any


class Table(NamedTuple):
    """What is learnt.

    Attributes:
        x: Inputs (p, i).
        y: Targets (p, o).
        order: Rows in the order in which they are shown (p,).
    """

    x: Any
    y: Any
    order: Any


class Descent(NamedTuple):
    """Scalars of a stretch of steps.

    Attributes:
        loss: Code of the loss.
        optimizer: SGD or ADAM.
        eta: Learning rate.
        momentum: Share of the last change that is repeated (SGD).
        batch: Rows per step; the last step of an epoch may have fewer.
        step: Steps done before.
    """

    loss: int
    optimizer: int
    eta: float
    momentum: float
    batch: int
    step: int


@kernel()
def descend(
    plan: Any, state: State, table: Table, scratch: Any, s: Descent, first: int, last: int
) -> float:
    """Learn the rows ``order[first:last]``, a step per batch.

    Args:
        plan: Layout, from `batch.make_plan`.
        state: Changed.
        table: Patterns.
        scratch: Buffers for a batch.
        s: Rates and codes.
        first: Where to begin in the order; a multiple of the batch.
        last: Where to end.

    Returns:
        The sum of the rows' losses, each before its own step.
    """
    total = 0.0
    step = s.step
    for at in range(first, last, s.batch):
        rows = min(s.batch, last - at)
        _show(plan, table, at, rows, scratch)
        total += batch.gradient(plan, state.w, state.g, scratch, s.loss, rows)
        step += 1
        if s.optimizer == SGD:
            momentum_step(state.w, state.m, state.g, s.eta, s.momentum)
        else:
            adam_step(state, s.eta, step)
    return total


@kernel()
def losses_of(
    plan: Any, w: Any, table: Table, scratch: Any, s: Descent, first: int, last: int
) -> float:
    """The sum of the losses of the rows ``order[first:last]``; arguments as of `descend`."""
    total = 0.0
    for at in range(first, last, s.batch):
        rows = min(s.batch, last - at)
        _show(plan, table, at, rows, scratch)
        batch.forward(plan, w, scratch.o, rows)
        total += batch.score(plan, scratch, s.loss, rows)
    return total


@kernel()
def _show(plan: Any, table: Table, at: int, rows: int, scratch: Any) -> None:
    """Copy the rows ``order[at : at + rows]`` to where the batch is computed."""
    wide = plan[0, batch.BELOW_WIDE]
    for row in range(rows):
        p = table.order[at + row]
        x, place = table.x[p], scratch.o[row * wide : (row + 1) * wide]
        for i in range(x.size):
            place[i] = x[i]
        for k in range(table.y.shape[1]):
            scratch.y[row, k] = table.y[p, k]


@kernel()
def momentum_step(w: Any, m: Any, g: Any, eta: float, momentum: float) -> None:
    """Gradient descent with momentum: m = mu m - eta g; w += m."""
    rate, mu = w.dtype.type(eta), w.dtype.type(momentum)
    for k in range(w.size):
        m[k] = mu * m[k] - rate * g[k]
        w[k] += m[k]


@kernel()
def adam_step(state: State, eta: float, t: int) -> None:
    """Step number t of Adam (Kingma and Ba 2015, algorithm 1)."""
    w, g, m, v = state
    kind = w.dtype.type
    rate = kind(eta / (1.0 - BETA1**t))
    spread = kind(1.0 / (1.0 - BETA2**t))
    beta1, beta2, epsilon = kind(BETA1), kind(BETA2), kind(EPSILON)
    rest1, rest2 = kind(1.0 - BETA1), kind(1.0 - BETA2)
    for k in range(w.size):
        m[k] = beta1 * m[k] + rest1 * g[k]
        v[k] = beta2 * v[k] + rest2 * (g[k] * g[k])
        w[k] -= rate * m[k] / (np.sqrt(v[k] * spread) + epsilon)
