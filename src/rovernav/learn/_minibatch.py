"""Mini-batch training of larger networks: one update for many patterns.

Every sum has a fixed order, so the weights have the same bits in every run, whatever the number
of workers. A training can be saved and resumed between epochs; an interruption within an epoch goes
back to the epoch's beginning.
"""

from __future__ import annotations

import contextlib
import dataclasses
import math
import time
from collections.abc import Callable
from typing import final

import numpy as np

from ..core import Executor, Float, ShapeError, value
from ..nets import Network, check_loss
from ._batch_engine import Engine
from ._batch_settings import BatchSettings
from ._online import check_fit
from ._patterns import Patterns
from ._progress import Listener, Progress, StopReason


@value
class BatchTraining:
    """A mini-batch training as it stands: save it, and it goes on later with the same bits.

    Attributes:
        network: The network so far, float32 or float64: the precision it is trained in.
        moments: Two numbers per weight (2, P): its last change and 0 (sgd), or Adam's moments.
        epoch: Epochs done.
        updates: Weight updates done.
        loss: Mean loss of the last epoch, each pattern's before its update; NaN before the first.
        validation: Mean loss of the rows held out, after that epoch; NaN without any.
        stop: Why it ended; None while it can go on.
    """

    network: Network
    moments: Float
    epoch: int = 0
    updates: int = 0
    loss: float = math.nan
    validation: float = math.nan
    stop: StopReason | None = None

    def _check(self) -> None:
        wanted = (2, len(self.network.parameters))
        if self.moments.shape != wanted or self.moments.dtype != self.network.parameters.dtype:
            raise ShapeError(
                f"moments must be {wanted} of {self.network.parameters.dtype}, "
                f"got {self.moments.shape} of {self.moments.dtype}"
            )

    @classmethod
    def fresh(cls, network: Network) -> BatchTraining:
        """A training that has not begun."""
        parameters = network.parameters
        return cls(network=network, moments=np.zeros((2, len(parameters)), parameters.dtype))


def advance_batches(
    training: BatchTraining,
    patterns: Patterns,
    settings: BatchSettings,
    epochs: int,
    *,
    workers: int | Executor = 1,
) -> BatchTraining:
    """Train for up to `epochs` more epochs.

    Args:
        training: Where to go on.
        patterns: What to learn.
        settings: Loss, optimizer, rates, order and when to stop.
        epochs: Epochs to do in this step.
        workers: As of `train_batches`.

    Returns:
        The training after it, with `stop` set if it ended in this step. Where loss, weight or
        moment stopped being finite, that is the last epoch before it, with `StopReason.DIVERGED`.

    Raises:
        ShapeError: Patterns and network do not fit.
        SettingError: Loss and output activation do not fit, a part of the table is empty, or
            there are no workers.
        PatternError: A pattern is too large for the network's precision.
    """
    with contextlib.closing(_engine(training, patterns, settings, workers)) as engine:
        return _advance(engine, training, settings, epochs, _Watch(None, math.nan))


def train_batches(
    training: BatchTraining | Network,
    patterns: Patterns,
    settings: BatchSettings,
    *,
    on_event: Listener | None = None,
    on_step: Callable[[BatchTraining], None] | None = None,
    workers: int | Executor = 1,
) -> BatchTraining:
    """Train until the loss is below the tolerance, the epochs are done, it diverges or Ctrl-C.

    Args:
        training: A network to begin with, or a training to go on with.
        patterns: What to learn.
        settings: Loss, optimizer, rates, order and when to stop.
        on_event: Receives a `Progress` at every epoch at first, later every two per cent; within
            a long epoch also every 10 to 50 ms, with the mean loss of that epoch so far.
        on_step: Receives the training after each step of whole epochs: checkpoints.
        workers: Threads that share out the shards of each batch, as a number or as
            `core.Threads`; or another executor that computes them. The bits are the same. Other
            executors cost a round trip per update, which pays for large batches of large networks.

    Returns:
        The ended training; its `stop` says why. Interrupted within an epoch, it stands at that
        epoch's beginning.

    Raises:
        ShapeError: Patterns and network do not fit.
        SettingError: Loss and output activation do not fit, a part of the table is empty, or
            there are no workers.
        PatternError: A pattern is too large for the network's precision.
    """
    now = BatchTraining.fresh(training) if isinstance(training, Network) else training
    with contextlib.closing(_engine(now, patterns, settings, workers)) as engine:
        if now.stop is StopReason.INTERRUPTED or _may_go_on(now, settings):
            now = _with_stop(now, None)
        watch = _Watch(on_event, math.nan)
        try:
            watch = _Watch(on_event, engine.loss() if on_event and not now.epoch else math.nan)
            while now.stop is None:
                if not watch.tell(now):
                    now = _with_stop(now, StopReason.INTERRUPTED)
                    break
                epochs = engine.epochs
                if on_event:  # each of the first 200, then every two per cent
                    epochs = min(epochs, max(1, now.epoch // 50 - 3))
                now = _advance(engine, now, settings, epochs, watch)
                if on_step:
                    on_step(now)
        except KeyboardInterrupt:
            now = _with_stop(now, StopReason.INTERRUPTED)
        watch.tell(now)
    return now


@final
class _Watch:
    """Tells a listener how a training stands, and asks whether to go on.

    Args:
        listener: Who is told, if anybody.
        first: The loss before the first epoch.
    """

    def __init__(self, listener: Listener | None, first: float) -> None:
        self._listener = listener
        self._first = first
        self._began = time.perf_counter()

    def tell(self, now: BatchTraining) -> bool:
        """Tell of whole epochs."""
        if self._listener is None:
            return True
        loss = now.loss if now.epoch else self._first
        event = self._event(now.epoch, now.updates, loss, now.network.parameters)
        return self._listener(dataclasses.replace(event, validation=now.validation)) is not False

    def tell_within(self, engine: Engine, epoch: int, updates: int, loss: float) -> bool:
        """Tell from within an epoch."""
        if self._listener is None:
            return True
        event = self._event(epoch, updates, loss, engine.parameters())
        return self._listener(event) is not False

    def _event(self, epoch: int, updates: int, loss: float, parameters: Float) -> Progress:
        return Progress(
            epoch=epoch,
            updates=updates,
            worst=math.nan,
            loss=loss,
            seconds=time.perf_counter() - self._began,
            parameters=parameters,
        )


def _engine(
    training: BatchTraining,
    patterns: Patterns,
    settings: BatchSettings,
    workers: int | Executor,
) -> Engine:
    """An engine that holds the training's weights and moments."""
    check_fit(training.network, patterns)
    check_loss(settings.loss, training.network.activations[-1])
    engine = Engine(training.network, patterns, settings, workers)
    engine.load(training.network.parameters, training.moments)
    return engine


def _advance(
    engine: Engine, training: BatchTraining, settings: BatchSettings, epochs: int, watch: _Watch
) -> BatchTraining:
    """`advance_batches`, on an engine that holds the training's weights and moments."""
    epoch, updates = training.epoch, training.updates
    loss, validation, stop = training.loss, training.validation, None
    end = min(epoch + epochs, settings.epochs)
    while epoch < end and stop is None:
        engine.keep()
        stop, mean = _one_epoch(engine, epoch, updates, watch)
        if stop is not None:
            engine.restore()
            break
        epoch, updates = epoch + 1, updates + engine.updates_of(engine.learnt)
        loss, validation = mean, engine.held_loss()
        stop = StopReason.TOLERANCE if loss < settings.tolerance else None
    if stop is None and epoch >= settings.epochs:
        stop = StopReason.EPOCHS
    return BatchTraining(
        network=training.network.with_parameters(engine.parameters()),
        moments=engine.moments(),
        epoch=epoch,
        updates=updates,
        loss=loss,
        validation=validation,
        stop=stop,
    )


def _one_epoch(
    engine: Engine, epoch: int, updates: int, watch: _Watch
) -> tuple[StopReason | None, float]:
    """Why the training ended within this epoch, if it did, and the epoch's mean loss."""
    mean = math.nan
    for learnt, total in engine.epoch(epoch, updates):
        mean = total / learnt
        if not math.isfinite(mean):
            return StopReason.DIVERGED, mean
        done = updates + engine.updates_of(learnt)
        if learnt < engine.learnt and not watch.tell_within(engine, epoch, done, mean):
            return StopReason.INTERRUPTED, mean
    return (None if engine.finite() else StopReason.DIVERGED), mean


def _may_go_on(training: BatchTraining, settings: BatchSettings) -> bool:
    """A training that did all its epochs goes on when more are asked for."""
    return training.stop is StopReason.EPOCHS and training.epoch < settings.epochs


def _with_stop(training: BatchTraining, stop: StopReason | None) -> BatchTraining:
    return dataclasses.replace(training, stop=stop)
