"""The compiled side of mini-batch training: weights, patterns and buffers of one run."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, final

import numpy as np

from ..core import Float, PatternError
from ..kernels import batch, descent
from ..kernels.backprop import shuffle
from ..nets import LOSSES, Network
from ._batch_settings import OPTIMIZERS, BatchSettings
from ._patterns import Patterns

SLICE = 150_000_000
"""Weights times patterns between two looks at Ctrl-C: 10 to 50 ms."""
_CALL = 1000
"""What a pattern costs beside its weights, in weights."""


@final
class Engine:
    """What a training run needs, made once: patterns in the network's precision, and buffers.

    Args:
        network: Fixes topology, activations and precision.
        patterns: What to learn; must fit the network.
        settings: Loss, optimizer, rates, order.

    Raises:
        SettingError: The validation share leaves nothing to learn or to measure.
        PatternError: A number is too large for the network's precision.
    """

    def __init__(self, network: Network, patterns: Patterns, settings: BatchSettings) -> None:
        dtype = network.parameters.dtype
        self.learnt = settings.learnt(len(patterns.x))
        self._settings = settings
        self._rows = min(settings.batch, self.learnt)
        self._table, self._held = _tables(patterns, self.learnt, dtype)
        self._plan = batch.make_plan(network.layer_rows, self._rows, dtype.itemsize)
        self._scratch = batch.make_scratch(self._plan, self._rows, dtype)
        self._state, self._kept = (
            descent.State(*(batch.make_weights(self._plan, dtype) for _ in range(4)))
            for _ in range(2)
        )
        self._flat: Float = np.empty(len(network.parameters), dtype)
        batches = SLICE // ((len(self._flat) + _CALL) * self._rows)
        self._slice = max(1, batches) * self._rows

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
        for kept, now in zip(self._kept, self._state, strict=True):
            np.copyto(kept, now)

    def restore(self) -> None:
        """Go back to what `keep` remembered."""
        for kept, now in zip(self._kept, self._state, strict=True):
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
            last = min(first + self._slice, self.learnt)
            total += descent.descend(
                self._plan, self._state, self._table, self._scratch,
                self._scalars(number, updates + first // self._rows), first, last,
            )  # fmt: skip
            yield last, total

    def loss(self) -> float:
        """Mean loss of the patterns that are learnt, with the weights as they are now."""
        return self._mean_loss(self._table)

    def held_loss(self) -> float:
        """Mean loss of the patterns that are held out; NaN without any."""
        return self._mean_loss(self._held) if len(self._held.order) else float("nan")

    def _mean_loss(self, table: descent.Table) -> float:
        count, total = len(table.order), 0.0
        for first in range(0, count, self._slice):
            total += descent.losses_of(
                self._plan, self._state.w, table, self._scratch,
                self._scalars(0, 0), first, min(first + self._slice, count),
            )  # fmt: skip
        return total / count

    def _scalars(self, epoch: int, step: int) -> descent.Descent:
        s = self._settings
        return descent.Descent(
            loss=LOSSES[s.loss],
            optimizer=OPTIMIZERS[s.optimizer],
            eta=s.eta_at(epoch),
            momentum=float(s.momentum),
            batch=self._rows,
            step=step,
        )

    def _parts(self) -> tuple[Any, Any, Any]:
        return self._state.w, self._state.m, self._state.v

    def _unpacked(self, w: Any) -> Float:
        batch.unpack(self._plan, w, self._flat)
        return self._flat.copy()


def _tables(patterns: Patterns, learnt: int, dtype: Any) -> tuple[descent.Table, descent.Table]:
    """The rows that are learnt and those that are held out, in the network's precision."""
    with np.errstate(over="ignore"):
        x, y = (np.array(numbers, dtype=dtype, order="C") for numbers in (patterns.x, patterns.y))
    if not (np.isfinite(x).all() and np.isfinite(y).all()):
        raise PatternError(
            f"a pattern is too large for a {dtype} network; scale it, or use a float64 network"
        )
    return (
        descent.Table(x[:learnt], y[:learnt], np.arange(learnt)),
        descent.Table(x[learnt:], y[learnt:], np.arange(len(x) - learnt)),
    )
