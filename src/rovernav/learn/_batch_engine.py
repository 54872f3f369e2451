"""The compiled side of mini-batch training: weights, patterns and buffers of one run."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, final

import numpy as np

from ..core import Executor, Float, PatternError, Serial, SettingError, Threads, read_only
from ..kernels import batch, descent
from ..kernels.backprop import shuffle
from ..kernels.team import Team
from ..nets import LOSSES, Network
from ._batch_settings import OPTIMIZERS, BatchSettings
from ._crew import Crew
from ._patterns import Patterns
from ._shards import Remote

SLICE = 150_000_000
"""Weights times patterns of a worker between two looks at Ctrl-C: 10 to 50 ms."""
_CALL = 1000
"""What a pattern costs beside its weights, in weights."""


@final
class Engine:
    """What a training run needs, made once: patterns in the network's precision, and buffers.

    Args:
        network: Fixes topology, activations and precision.
        patterns: What to learn; must fit the network.
        settings: Loss, optimizer, rates, order, shards.
        workers: Threads that share the work, or who computes the shards elsewhere.

    Raises:
        SettingError: The validation share leaves nothing to learn or to measure; no workers.
        PatternError: A number is too large for the network's precision.
    """

    def __init__(
        self,
        network: Network,
        patterns: Patterns,
        settings: BatchSettings,
        workers: int | Executor = 1,
    ) -> None:
        dtype = network.parameters.dtype
        self.learnt = settings.learnt(len(patterns.x))
        self._settings = settings
        self._rows = min(settings.batch, self.learnt)
        self._crew = Crew(_threads(workers, settings))
        self._table, self._held = _tables(patterns, self.learnt, dtype)
        panel = min(self._rows, batch.PANEL)
        self._plan = batch.make_plan(network.layer_rows, panel, dtype.itemsize)
        self._scratch = [
            batch.make_scratch(self._plan, panel, dtype) for _ in range(self._crew.workers)
        ]
        self._state = descent.make_state(self._plan, settings.shards, dtype)
        self._kept = [np.zeros_like(part) for part in self._parts()]
        self._flat: Float = np.empty(len(network.parameters), dtype)
        batches = SLICE * self._crew.workers // ((len(self._flat) + _CALL) * self._rows)
        self._slice = max(1, batches) * self._rows
        self._remote = None
        if not isinstance(workers, int | Serial | Threads):
            seed = settings.seed if settings.order == "shuffled" else -1
            scalars = self._scalars(0, 0)
            self._remote = Remote(workers, network.layer_rows, self._table, scalars, seed)

    def close(self) -> None:
        """End the threads, if there are any."""
        self._crew.close()

    def updates_of(self, patterns: int) -> int:
        """Updates that so many patterns of an epoch take."""
        return -(-patterns // self._rows)

    @property
    def epochs(self) -> int:
        """Epochs in a slice: at least 1."""
        return max(1, self._slice // self.learnt)

    def load(self, parameters: Float, moments: Float) -> None:
        """Take over weights (P,) and moments (2, P)."""
        for flat, w in zip((parameters, *moments), self._parts(), strict=True):
            self._flat[:] = flat
            batch.pack(self._plan, self._flat, w)

    def parameters(self) -> Float:
        """A copy of the weights (P,) as they are now."""
        return self._unpacked(self._state.w)

    def moments(self) -> Float:
        """A copy of the moments (2, P) as they are now."""
        return np.stack([self._unpacked(part) for part in (self._state.m, self._state.v)])

    def keep(self) -> None:
        """Remember weights and moments for `restore`."""
        for kept, now in zip(self._kept, self._parts(), strict=True):
            np.copyto(kept, now)

    def restore(self) -> None:
        """Go back to what `keep` remembered."""
        for kept, now in zip(self._kept, self._parts(), strict=True):
            np.copyto(now, kept)

    def finite(self) -> bool:
        """Whether every weight and moment is a finite number."""
        return all(bool(np.isfinite(part).all()) for part in self._parts())

    def epoch(self, number: int, updates: int) -> Iterator[tuple[int, float]]:
        """Train for one epoch, a slice at a time.

        Args:
            number: Number of the epoch; the first is 0.
            updates: Updates done before it.

        Yields:
            After each slice, the patterns learnt in this epoch and the sum of their losses.
        """
        s = self._settings
        if s.order == "shuffled":
            shuffle(self._table.order, s.seed, number)
        total = 0.0
        for first in range(0, self.learnt, self._slice):
            stretch = descent.Stretch(first, min(first + self._slice, self.learnt))
            total += self._descend(number, updates + first // self._rows, stretch)
            yield stretch.last, total

    def loss(self) -> float:
        """Mean loss of the patterns that are learnt, with the weights as they are now."""
        return self._mean_loss(self._table)

    def held_loss(self) -> float:
        """Mean loss of the patterns that are held out; NaN without any."""
        return self._mean_loss(self._held) if len(self._held.order) else float("nan")

    def _descend(self, epoch: int, step: int, stretch: descent.Stretch) -> float:
        scalars = self._scalars(epoch, step)
        if self._remote is not None:
            return self._remote.descend(self._state, scalars, epoch, stretch)

        def work(team: Team) -> float:
            return descent.descend(
                self._plan, self._state, self._table, self._scratch[team.me],
                scalars, stretch, team,
            )  # fmt: skip

        return self._crew.run(work)

    def _mean_loss(self, table: descent.Table) -> float:
        """A sum over batches, each a sum over its rows, in their order."""
        count, scalars, total = len(table.order), self._scalars(0, 0), 0.0
        for first in range(0, count, self._slice):
            last = min(first + self._slice, count)
            losses = np.zeros(self.updates_of(last - first))

            def work(team: Team, first: int = first, last: int = last, out: Any = losses) -> float:
                begin, end = (len(out) * (team.me + k) // team.workers for k in (0, 1))
                stretch = descent.Stretch(
                    first + begin * self._rows, min(first + end * self._rows, last)
                )
                descent.losses_of(
                    self._plan, self._state.w, table, self._scratch[team.me],
                    scalars, stretch, out[begin:end],
                )  # fmt: skip
                return 0.0

            self._crew.run(work)
            part = 0.0
            for loss in losses.tolist():
                part += loss
            total += part
        return total / count

    def _scalars(self, epoch: int, step: int) -> descent.Descent:
        s = self._settings
        return descent.Descent(
            loss=LOSSES[s.loss],
            optimizer=OPTIMIZERS[s.optimizer],
            eta=s.eta_at(epoch),
            momentum=float(s.momentum),
            batch=self._rows,
            shards=s.shards,
            step=step,
        )

    def _parts(self) -> tuple[Any, Any, Any]:
        return self._state.w, self._state.m, self._state.v

    def _unpacked(self, w: Any) -> Float:
        batch.unpack(self._plan, w, self._flat)
        return self._flat.copy()


def _threads(workers: int | Executor, settings: BatchSettings) -> int:
    """Threads that find something to do: there are no more parts than shards."""
    if isinstance(workers, Serial | Threads):
        workers = workers.workers
    if not isinstance(workers, int):
        return 1
    if workers < 1:
        raise SettingError(f"workers must be 1 or more, got {workers}")
    return min(workers, settings.shards)


def _tables(patterns: Patterns, learnt: int, dtype: Any) -> tuple[descent.Table, descent.Table]:
    """The rows that are learnt and those that are held out, in the network's precision."""
    x, y = (np.empty(numbers.shape, dtype) for numbers in (patterns.x, patterns.y))
    if not all(
        descent.narrow(numbers.reshape(-1), table.reshape(-1))
        for numbers, table in ((patterns.x, x), (patterns.y, y))
    ):
        raise PatternError(
            f"a pattern is too large for a {dtype} network; scale it, or use a float64 network"
        )
    x, y = read_only(x), read_only(y)  # so are those of other processes: kernels compile once
    return (
        descent.Table(x[:learnt], y[:learnt], np.arange(learnt)),
        descent.Table(x[learnt:], y[learnt:], np.arange(len(x) - learnt)),
    )
