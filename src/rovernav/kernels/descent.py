"""Gradient descent over a table of patterns, batch by batch, by one worker or several.

Symbols: w weights, g = dL/dw, eta learning rate, mu momentum, m last change or first moment,
v second moment, t number of the step (1 is the first).

The rows of a batch of n are split into `shards`: shard k has the rows from n k / shards (rounded
down) to n (k + 1) / shards. Each has a gradient of its own, summed over its rows in their order;
a weight's g is the sum over the shards in theirs. Who computes which shard is not part of this,
so the weights depend on the shards, never on the workers.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from . import batch
from ._jit import kernel
from .product import VECTOR
from .team import Team, meet, prefetch

SGD, ADAM = 0, 1
BETA1, BETA2, EPSILON = 0.9, 0.999, 1e-8
"""Adam's constants (Kingma and Ba 2015, section 2)."""


class State(NamedTuple):
    """Padded weights and what belongs to each of them: (S,), whole vectors.

    Attributes:
        w: Weights.
        g: Gradient of each shard, one after the other (shards S,).
        m: Last change (SGD) or first moment (Adam).
        v: Second moment (Adam).
        losses: Sum of the losses of each shard (shards,), float64.
    """

    w: Any
    g: Any
    m: Any
    v: Any
    losses: Any


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
        shards: Parts of a batch that are summed by themselves.
        step: Steps done before.
    """

    loss: int
    optimizer: int
    eta: float
    momentum: float
    batch: int
    shards: int
    step: int


class Stretch(NamedTuple):
    """Neighbours: rows of a table's order, or shards.

    Attributes:
        first: Where they begin.
        last: Where they end.
    """

    first: int
    last: int


def make_state(plan: Any, shards: int, dtype: Any) -> State:
    """Zeros for a network's weights and all that belongs to them."""
    w, m, v = (batch.make_weights(plan, dtype) for _ in range(3))
    g = batch.aligned(shards * w.size, dtype)
    return State(w=w, g=g, m=m, v=v, losses=np.zeros(shards))


@kernel()
def descend(
    plan: Any, state: State, table: Table, scratch: Any, s: Descent, stretch: Stretch, team: Team
) -> float:
    """Learn the rows of a stretch, a step per batch.

    Every worker of a team calls it with the same state and its own scratch. Between two meetings
    each writes only what is its own: before the first the gradients of its shards, before the
    second its part of the weights; what it reads then nobody writes.

    Args:
        plan: Layout, from `batch.make_plan`.
        state: Changed.
        table: Patterns.
        scratch: Buffers of this worker.
        s: Rates and codes.
        stretch: Rows to learn; begins at a multiple of the batch.
        team: Who this worker is.

    Returns:
        The sum of the rows' losses, each before its own step.
    """
    total, step = 0.0, s.step
    mine = Stretch(s.shards * team.me // team.workers, s.shards * (team.me + 1) // team.workers)
    for at in range(stretch.first, stretch.last, s.batch):
        rows = Stretch(at, min(at + s.batch, stretch.last))
        gradients(plan, state, table, scratch, s, rows, mine)
        if not meet(team):
            return total
        part = state.losses[0]
        for shard in range(1, s.shards):
            part += state.losses[shard]
        total += part
        step += 1
        update(state, s, step, team)
        if not meet(team):
            return total
    return total


@kernel()
def gradients(
    plan: Any, state: State, table: Table, scratch: Any, s: Descent, rows: Stretch, mine: Stretch
) -> None:
    """Fill gradient and loss of the shards ``mine.first`` to ``mine.last`` of the batch `rows`."""
    count = rows.last - rows.first
    begin = rows.first + count * mine.first // s.shards
    for shard in range(mine.first, mine.last):
        g = state.g[shard * state.w.size : (shard + 1) * state.w.size]
        first = rows.first + count * shard // s.shards
        last = rows.first + count * (shard + 1) // s.shards
        total, on = 0.0, 0
        for panel in range(first, last, batch.PANEL):
            height = min(batch.PANEL, last - panel)
            _show(plan, table, panel, height, scratch)
            goes_on = panel + height < last or shard + 1 < mine.last
            _ask(table, panel + height if goes_on else begin + s.batch, height)
            part = batch.Part(s.loss, 1.0 / count, on, total)
            total = batch.gradient(plan, state.w, g, scratch, part, height)
            on = 1
        if first == last:  # fewer rows than shards
            g[:] = 0
        state.losses[shard] = total


@kernel()
def update(state: State, s: Descent, step: int, team: Team) -> None:
    """Sum the shards' gradients of this worker's weights, and take the step with them."""
    size = state.w.size
    lanes = VECTOR // state.w.itemsize
    first = size // lanes * team.me // team.workers * lanes
    last = size // lanes * (team.me + 1) // team.workers * lanes
    w, g = state.w[first:last], state.g[first:last]
    m, v = state.m[first:last], state.v[first:last]
    for shard in range(1, s.shards):
        other = state.g[shard * size + first : shard * size + last]
        for k in range(g.size):
            g[k] += other[k]
    if s.optimizer == SGD:
        momentum_step(w, m, g, s.eta, s.momentum)
    else:
        adam_step(w, g, m, v, s.eta, step)


@kernel()
def losses_of(
    plan: Any, w: Any, table: Table, scratch: Any, s: Descent, stretch: Stretch, out: Any
) -> None:
    """Write the sum of the losses of each batch of a stretch to `out` (batches,)."""
    for at in range(stretch.first, stretch.last, s.batch):
        last, total = min(at + s.batch, stretch.last), 0.0
        for panel in range(at, last, batch.PANEL):
            height = min(batch.PANEL, last - panel)
            _show(plan, table, panel, height, scratch)
            batch.forward(plan, w, scratch.o, height)
            part = batch.Part(s.loss, 1.0 / (last - at), 0, total)
            total = batch.score(plan, scratch, part, height)
        out[(at - stretch.first) // s.batch] = total


@kernel()
def narrow(a: Any, b: Any) -> bool:
    """Copy the numbers of `a` (n,) to `b` (n,) in its precision; False if one is not finite."""
    limit = np.finfo(b.dtype).max
    strange = 0
    for k in range(a.size):
        number = b.dtype.type(a[k])
        b[k] = number
        strange |= not abs(number) <= limit
    return not strange


@kernel()
def _show(plan: Any, table: Table, at: int, rows: int, scratch: Any) -> None:
    """Copy the rows ``order[at : at + rows]`` to where a panel is computed."""
    wide = plan[0, batch.BELOW_WIDE]
    for row in range(rows):
        p = table.order[at + row]
        x, place = table.x[p], scratch.o[row * wide : (row + 1) * wide]
        for i in range(x.size):
            place[i] = x[i]
        for k in range(table.y.shape[1]):
            scratch.y[row, k] = table.y[p, k]


@kernel()
def _ask(table: Table, at: int, rows: int) -> None:
    """Ask the memory for the rows ``order[at : at + rows]``, to come while others are computed.

    In a shuffled order every row is somewhere else, and each would be waited for.
    """
    inputs, outputs = table.x.shape[1], table.y.shape[1]
    lanes = VECTOR // table.x.itemsize
    for row in range(at, min(at + rows, table.order.size)):
        p = table.order[row]
        for i in range(0, inputs, lanes):
            prefetch(table.x, p * inputs + i)
        for i in range(0, outputs, lanes):
            prefetch(table.y, p * outputs + i)


@kernel()
def momentum_step(w: Any, m: Any, g: Any, eta: float, momentum: float) -> None:
    """Gradient descent with momentum: m = mu m - eta g; w += m."""
    rate, mu = w.dtype.type(eta), w.dtype.type(momentum)
    for k in range(w.size):
        m[k] = mu * m[k] - rate * g[k]
        w[k] += m[k]


@kernel()
def adam_step(w: Any, g: Any, m: Any, v: Any, eta: float, t: int) -> None:
    """Step number t of Adam (Kingma and Ba 2015, algorithm 1)."""
    kind = w.dtype.type
    rate = kind(eta / (1.0 - BETA1**t))
    spread = kind(1.0 / (1.0 - BETA2**t))
    beta1, beta2, epsilon = kind(BETA1), kind(BETA2), kind(EPSILON)
    rest1, rest2 = kind(1.0 - BETA1), kind(1.0 - BETA2)
    for k in range(w.size):
        m[k] = beta1 * m[k] + rest1 * g[k]
        v[k] = beta2 * v[k] + rest2 * (g[k] * g[k])
        w[k] -= rate * m[k] / (np.sqrt(v[k] * spread) + epsilon)
