"""The training engine of the seed paper: online back-propagation, one pattern at a time."""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from ..core import F64, SettingError, ShapeError, suggest, value
from ..kernels import backprop, frozen
from ..kernels.network import all_within
from ..nets import Network
from ._patterns import Patterns
from ._progress import Listener, Progress, StopReason

RULES = {"paper": backprop.PAPER, "textbook": backprop.TEXTBOOK}
ORDERS = ("cyclic", "shuffled")
SLICE = 500_000 * 17
"""Changes of single weights between two looks at Ctrl-C and the listener: some 50 ms."""
RECORDED = 20_000 * 17
"""The same while every weight is recorded, which also bounds the memory for it."""
FREEZE_AFTER = 1_000_000
"""Updates after which compiling a kernel for this one topology pays; its bits are the same."""


@value
class OnlineSettings:
    """Settings of online back-propagation; the paper's names.

    Attributes:
        eta: Learning rate.
        momentum: Share of a weight's last change that is repeated (the paper's alpha).
        rule: ``paper`` (hidden errors through the already updated weights, as its listing) or
            ``textbook`` (through the old ones: the exact gradient).
        tolerance: Stop before an epoch once every |error| is below this; 0 does all epochs.
        epochs: Epochs at most.
        order: ``cyclic`` (the table's order) or ``shuffled`` (anew each epoch, from `seed`).
        seed: Seed of the shuffled order.
    """

    eta: float = 0.25
    momentum: float = 0.0
    rule: str = "paper"
    tolerance: float = 0.01
    epochs: int = 5000
    order: str = "cyclic"
    seed: int = 0

    def _check(self) -> None:
        if not (math.isfinite(self.eta) and self.eta > 0):
            raise SettingError(f"eta must be a number above 0, got {self.eta!r}")
        if not 0 <= self.momentum < 1:
            raise SettingError(f"momentum must be from 0 to below 1, got {self.momentum!r}")
        if not (math.isfinite(self.tolerance) and self.tolerance >= 0):
            raise SettingError(f"tolerance must be 0 or above, got {self.tolerance!r}")
        if not 0 <= self.epochs <= 10**12:
            raise SettingError(f"epochs must be from 0 to 10^12, got {self.epochs!r}")
        if self.rule not in RULES:
            raise SettingError(f"unknown rule {self.rule!r}; {suggest(self.rule, RULES)}")
        if self.order not in ORDERS:
            raise SettingError(f"unknown order {self.order!r}; {suggest(self.order, ORDERS)}")
        if not 0 <= self.seed < 2**63:
            raise SettingError(f"seed must be from 0 to 2^63 - 1, got {self.seed!r}")


@value
class Training:
    """A training as it stands: save it, and it goes on later with the same bits.

    Attributes:
        network: The network so far.
        deltas: Last change of each weight (P,), for the momentum.
        epoch: Epochs done.
        updates: Weight updates done.
        stop: Why it ended; None while it can go on.
        pattern: Patterns of the present epoch that are done, where it stands within one.
    """

    network: Network
    deltas: F64
    epoch: int = 0
    updates: int = 0
    stop: StopReason | None = None
    pattern: int = 0

    def _check(self) -> None:
        parameters = self.network.parameters
        if parameters.dtype != np.float64:
            raise ShapeError(
                "online back-propagation works in float64; "
                f"this network is {parameters.dtype}: train it by mini-batches"
            )
        if self.deltas.shape != parameters.shape or self.deltas.dtype != np.float64:
            raise ShapeError(
                f"{len(parameters)} weights have as many last changes in float64, "
                f"got {self.deltas.dtype} of shape {self.deltas.shape}"
            )

    @classmethod
    def fresh(cls, network: Network) -> Training:
        """A training that has not begun.

        Raises:
            ShapeError: The network is not float64, the precision of online training.
        """
        return cls(network=network, deltas=np.zeros(len(network.parameters)))


Recorder: TypeAlias = Callable[[int, np.ndarray, F64], None]
"""Called with the first epoch of a slice, the pattern of each update (m,), all weights (m, P)."""


def advance(
    training: Training,
    patterns: Patterns,
    settings: OnlineSettings,
    epochs: int,
    *,
    recorder: Recorder | None = None,
) -> Training:
    """Train for up to `epochs` more epochs: the one step that `train` folds.

    Within an epoch, the first of them is the rest of that one.

    Args:
        training: Where to go on.
        patterns: What to learn; must fit the network.
        settings: Rates, rule, order and when to stop.
        epochs: Epochs to do in this step.
        recorder: If given, receives every weight after every update.

    Returns:
        The training after it, with `stop` set if it ended in this step. Where a weight stopped
        being finite, that is the last epoch before it, with `StopReason.DIVERGED`.

    Raises:
        ShapeError: Patterns and network do not fit.
    """
    check_fit(training.network, patterns)
    epochs = max(0, min(epochs, settings.epochs - training.epoch))
    if training.pattern and epochs:
        left = len(patterns.x) - training.pattern
        training = step_patterns(training, patterns, settings, left, recorder=recorder)
        epochs -= 1
        if training.stop is not None or not epochs:
            return training
    w, v = training.network.parameters.copy(), training.deltas.copy()
    record = np.empty((epochs * len(patterns.x) if recorder else 0, len(w)))
    done, solved = _kernel(training, settings, recorder is not None)(
        training.network.layers, w, v, patterns.x, patterns.y,
        _scalars(settings, training.epoch, epochs), record,
    )  # fmt: skip
    if not np.isfinite(w).all():
        return _last_good(training, patterns, settings, epochs, recorder)
    if recorder:
        rows = done * len(patterns.x)
        recorder(training.epoch, _order(patterns, settings, training.epoch, done), record[:rows])
    finished = training.epoch + done >= settings.epochs
    stop = StopReason.TOLERANCE if solved else StopReason.EPOCHS if finished else None
    return Training(
        network=training.network.with_parameters(w),
        deltas=v,
        epoch=training.epoch + done,
        updates=training.updates + done * len(patterns.x),
        stop=stop,
        pattern=training.pattern,
    )


def step_patterns(
    training: Training,
    patterns: Patterns,
    settings: OnlineSettings,
    count: int = 1,
    *,
    recorder: Recorder | None = None,
) -> Training:
    """Train on the next `count` patterns, at most to the end of the present epoch.

    Single steps and whole epochs may take turns: the weights have the same bits as without steps.
    As in `advance`, the tolerance is looked at before the first pattern of an epoch.

    Args:
        training: Where to go on.
        patterns: What to learn; must fit the network.
        settings: Rates, rule, order and when to stop.
        count: Patterns to present.
        recorder: If given, receives every weight after every update.

    Returns:
        The training after it, with `stop` set if it ended here. Where a weight stopped being
        finite, that is the training before the step, with `StopReason.DIVERGED`.

    Raises:
        ShapeError: Patterns and network do not fit, or the table has fewer patterns than were
            done of this epoch.
    """
    check_fit(training.network, patterns)
    first, size = training.pattern, len(patterns.x)
    if not 0 <= first < size:
        raise ShapeError(
            f"{first} patterns of this epoch are done, but the table has {size}; "
            "go on with the table that the epoch was begun with"
        )
    if training.epoch >= settings.epochs:
        return _with_stop(training, StopReason.EPOCHS)
    if first == 0 and _solved(training.network, patterns, settings.tolerance):
        return _with_stop(training, StopReason.TOLERANCE)
    count = max(0, min(count, size - first))
    w, v = training.network.parameters.copy(), training.deltas.copy()
    order = _order(patterns, settings, training.epoch, 1)
    scalars = _scalars(settings, training.epoch, 1)
    at_once = max(1, RECORDED // len(w))
    for at in range(first, first + count, at_once):
        record = np.empty((min(at_once, first + count - at), len(w)))
        backprop.train_part(
            training.network.layers, w, v, patterns.x, patterns.y, scalars, at, record
        )
        if not np.isfinite(w).all():
            return _with_stop(training, StopReason.DIVERGED)
        if recorder:
            recorder(training.epoch, order[at : at + len(record)], record)
    epoch, pattern = divmod(training.epoch * size + first + count, size)
    return Training(
        network=training.network.with_parameters(w),
        deltas=v,
        epoch=epoch,
        updates=training.updates + count,
        stop=StopReason.EPOCHS if epoch >= settings.epochs else None,
        pattern=pattern,
    )


def train(
    training: Training | Network,
    patterns: Patterns,
    settings: OnlineSettings,
    *,
    on_event: Listener | None = None,
    recorder: Recorder | None = None,
    on_step: Callable[[Training], None] | None = None,
) -> Training:
    """Train until the tolerance is met, the epochs are done, it diverges or Ctrl-C.

    Args:
        training: A network to begin with, or a training to go on with.
        patterns: What to learn.
        settings: Rates, rule, order and when to stop.
        on_event: Receives a `Progress` at every epoch at first, later every two per cent.
        recorder: Receives every weight after every update (slower).
        on_step: Receives the training after each slice of some 50 ms, and an interrupted one at
            its end: checkpoints.

    Returns:
        The ended training; its `stop` says why.

    Raises:
        ShapeError: Patterns and network do not fit.
    """
    now = Training.fresh(training) if isinstance(training, Network) else training
    check_fit(now.network, patterns)
    if now.stop is not StopReason.DIVERGED:  # more epochs or a smaller tolerance go on
        now = _with_stop(now, None)
    began = time.perf_counter()
    try:
        while now.stop is None:
            if on_event and on_event(progress(now, patterns, time.perf_counter() - began)) is False:
                now = _with_stop(now, StopReason.INTERRUPTED)
                break
            now = advance(
                now,
                patterns,
                settings,
                _slice(now, patterns, on_event, recorder),
                recorder=recorder,
            )
            if on_step:
                on_step(now)
    except KeyboardInterrupt:
        now = _with_stop(now, StopReason.INTERRUPTED)
    if on_step and now.stop is StopReason.INTERRUPTED:
        on_step(now)
    if on_event:
        on_event(progress(now, patterns, time.perf_counter() - began))
    return now


def progress(training: Training, patterns: Patterns, seconds: float) -> Progress:
    """The event that describes a training as it stands."""
    error = patterns.y - training.network.forward(patterns.x)
    with np.errstate(over="ignore"):  # a training that diverges has infinite loss
        loss = float(0.5 * np.mean(np.sum(error * error, axis=1)))
    return Progress(
        epoch=training.epoch,
        updates=training.updates,
        worst=float(np.max(np.abs(error))),
        loss=loss,
        seconds=seconds,
        parameters=training.network.parameters,
    )


def check_fit(network: Network, patterns: Patterns) -> None:
    """Raise `ShapeError` unless the patterns have the network's inputs and outputs."""
    wanted = (network.topology[0], network.topology[-1])
    got = (patterns.x.shape[1], patterns.y.shape[1])
    if got != wanted:
        raise ShapeError(
            f"the network has {wanted[0]} inputs and {wanted[1]} outputs, "
            f"the patterns have {got[0]} inputs and {got[1]} targets"
        )


def _slice(
    now: Training, patterns: Patterns, on_event: Listener | None, recorder: Recorder | None
) -> int:
    """Epochs until the next event: each of the first 200, then every two per cent."""
    weights = max(17, len(now.network.parameters))  # smaller ones are no faster
    most = max(1, (RECORDED if recorder else SLICE) // weights // len(patterns.x))
    return min(most, max(1, now.epoch // 50 - 3)) if on_event else most


def _kernel(
    training: Training, settings: OnlineSettings, recording: bool
) -> Callable[..., tuple[int, bool]]:
    small = len(training.network.parameters) <= frozen.MAX_WEIGHTS
    if small and not recording and training.updates >= FREEZE_AFTER:
        return frozen.frozen_train(training.network.layer_rows, RULES[settings.rule])
    return backprop.train


def _scalars(settings: OnlineSettings, epoch: int, epochs: int) -> backprop.OnlineSettings:
    return backprop.OnlineSettings(
        eta=float(settings.eta),
        momentum=float(settings.momentum),
        rule=RULES[settings.rule],
        tolerance=float(settings.tolerance),
        seed=settings.seed if settings.order == "shuffled" else -1,
        epoch=epoch,
        epochs=epochs,
    )


def _order(patterns: Patterns, settings: OnlineSettings, epoch: int, epochs: int) -> np.ndarray:
    """Which pattern each update of these epochs presented."""
    rows = np.tile(np.arange(len(patterns.x)), (epochs, 1))
    if settings.order == "shuffled":
        for number, row in enumerate(rows):
            backprop.shuffle(row, settings.seed, epoch + number)
    return rows.ravel()


def _last_good(
    training: Training,
    patterns: Patterns,
    settings: OnlineSettings,
    epochs: int,
    recorder: Recorder | None,
) -> Training:
    """The last epoch at which every weight was finite, found by halving the slice."""
    while epochs > 1:
        half = advance(training, patterns, settings, epochs // 2, recorder=recorder)
        if half.stop is StopReason.DIVERGED:
            return half
        training, epochs = half, epochs - epochs // 2
    return _with_stop(training, StopReason.DIVERGED)


def _with_stop(training: Training, stop: StopReason | None) -> Training:
    return dataclasses.replace(training, stop=stop)


def _solved(network: Network, patterns: Patterns, tolerance: float) -> bool:
    """Whether every error of every pattern is within the tolerance; 0 is never met."""
    return tolerance > 0.0 and bool(
        all_within(network.layers, network.parameters, patterns.x, patterns.y, float(tolerance))
    )
