"""Gradients of single shards as jobs of an executor: for processes and clusters.

Every update is a round trip: weights go out, gradients come back. That pays where a batch takes
much longer than the trip. The arithmetic is that of the threads, and so are the bits.
"""

from __future__ import annotations

import itertools
import threading
import uuid
from typing import Any, NamedTuple

import numpy as np

from ..core import Executor, Float, value
from ..kernels import batch, descent
from ..kernels.backprop import shuffle
from ..kernels.team import Team, make_board


@value
class ShardWork:
    """What every worker needs: sent once.

    Attributes:
        name: Tells this training from others.
        layers: Inputs, units, activation code of each layer.
        x: Inputs of the rows that are learnt (p, i), in the network's precision.
        y: Their targets (p, o).
        loss: Code of the loss.
        batch: Rows of a batch.
        shards: Shards of a batch.
        seed: Seed of the shuffled order; negative keeps the table's order.
    """

    name: str
    layers: tuple[tuple[int, int, int], ...]
    x: Float
    y: Float
    loss: int
    batch: int
    shards: int
    seed: int


class ShardItem(NamedTuple):
    """Which shards, of which batch, with which weights.

    Attributes:
        epoch: Number of the epoch, for its order.
        rows: First row of the batch in that order, and the row after its last.
        shards: First shard, and the one after the last.
        w: Padded weights (S,).
    """

    epoch: int
    rows: tuple[int, int]
    shards: tuple[int, int]
    w: Any


def shard_gradients(shared: ShardWork, item: ShardItem) -> tuple[Any, Any]:
    """Gradients (shards, S) and sums of losses (shards,) of some shards of one batch.

    A job for `Executor.map`: the same numbers wherever it runs.
    """
    bench: _Bench | None = getattr(_kept, "bench", None)
    if bench is None or bench.name != shared.name:
        bench = _kept.bench = _Bench(shared)
    return bench.gradients(item)


_kept = threading.local()
"""The bench of each thread's last job: buffers are made once, not for every batch."""


class _Bench:
    """Buffers of one worker for one training."""

    def __init__(self, work: ShardWork) -> None:
        self.name, self._work, self._epoch = work.name, work, -1
        dtype = work.x.dtype
        rows = min(work.batch, batch.PANEL)
        self._plan = batch.make_plan(work.layers, rows, dtype.itemsize)
        self._scratch = batch.make_scratch(self._plan, rows, dtype)
        self._state = descent.make_state(self._plan, work.shards, dtype)
        self._table = descent.Table(work.x, work.y, np.arange(len(work.x)))

    def gradients(self, item: ShardItem) -> tuple[Any, Any]:
        """What `shard_gradients` returns."""
        work, state = self._work, self._state
        if work.seed >= 0 and item.epoch != self._epoch:
            shuffle(self._table.order, work.seed, item.epoch)
            self._epoch = item.epoch
        np.copyto(state.w, item.w)
        scalars = descent.Descent(work.loss, descent.SGD, 0.0, 0.0, work.batch, work.shards, 0)
        mine = descent.Stretch(*item.shards)
        rows = descent.Stretch(*item.rows)
        descent.gradients(self._plan, state, self._table, self._scratch, scalars, rows, mine)
        first, last = mine
        g = state.g.reshape(work.shards, -1)[first:last]
        return g.copy(), state.losses[first:last].copy()


class Remote:
    """Takes the steps of a training whose shards an executor computes.

    Args:
        executor: Who runs the jobs.
        layers: Inputs, units, activation code of each layer.
        table: Rows that are learnt.
        scalars: Loss, batch and shards of the training.
        seed: Seed of the shuffled order; negative keeps the table's order.
    """

    def __init__(
        self, executor: Executor, layers: Any, table: descent.Table, scalars: descent.Descent,
        seed: int,
    ) -> None:  # fmt: skip
        self._executor = executor
        self._work = ShardWork(
            name=uuid.uuid4().hex, layers=layers, x=table.x, y=table.y, loss=scalars.loss,
            batch=scalars.batch, shards=scalars.shards, seed=seed,
        )  # fmt: skip
        self._team = Team(0, 1, make_board())

    def descend(
        self, state: descent.State, scalars: descent.Descent, epoch: int, stretch: descent.Stretch
    ) -> float:
        """What `kernels.descent.descend` does, with the gradients computed elsewhere."""
        total, step = 0.0, scalars.step
        for at in range(stretch.first, stretch.last, scalars.batch):
            self._gather(state, epoch, (at, min(at + scalars.batch, stretch.last)))
            part = float(state.losses[0])
            for loss in state.losses[1:].tolist():
                part += loss
            total += part
            step += 1
            descent.update(state, scalars, step, self._team)
        return total

    def _gather(self, state: descent.State, epoch: int, rows: tuple[int, int]) -> None:
        """Fill gradient and loss of every shard of a batch."""
        shards = self._work.shards
        parts = min(shards, self._executor.workers)
        ends = [shards * part // parts for part in range(parts + 1)]
        w = state.w.copy()
        items = [ShardItem(epoch, rows, (a, b), w) for a, b in itertools.pairwise(ends)]
        g = state.g.reshape(shards, -1)
        results = self._executor.map(shard_gradients, items, shared=self._work)
        for item, (gradients, losses) in zip(items, results, strict=True):
            first, last = item.shards
            g[first:last], state.losses[first:last] = gradients, losses
