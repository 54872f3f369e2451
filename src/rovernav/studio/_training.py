"""A training under the hands of a person: it runs on a thread of its own, without any page."""

from __future__ import annotations

import dataclasses
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any, final

import numpy as np

from ..core import F64, RovernavError, SettingError, suggest
from ..learn import (
    OnlineSettings,
    Progress,
    StopReason,
    Training,
    advance,
    describe,
    paper_training,
    progress,
    shipped_patterns,
    step_patterns,
    train,
)
from ..nets import Network
from ._curve import Curve, Point, TracePane
from ._kept import Kept, keep_training
from ._pace import SPEEDS, Pace
from ._setup import Setup, changed, learns_differently, parse_hidden, starts_elsewhere
from ._state import State


@final
class TrainModel:
    """A training that can be started, paused, stepped and changed at any time.

    All methods may be called from any thread and return at once, but for the steps, which take as
    long as an epoch does.

    Args:
        keep: Receives each finished run: `Library.add`.
    """

    def __init__(self, *, keep: Callable[..., str]) -> None:
        self._keep = keep
        self._lock = threading.RLock()
        self._generation = 0
        self._version = 0
        self._running = False
        self._trace: TracePane | None = None
        self._pace = Pace(SPEEDS[1])
        network, table, settings = paper_training()
        self._setup = Setup(
            table=table,
            shipped="bassil-v1",
            hidden=network.topology[1:-1],
            activations=network.activations,
            settings=settings,
            weights="paper",
        )
        self._curve = Curve()
        self._before: tuple[Point, ...] = ()
        self._begin(self._setup.initial(), self._setup.weights)

    def state(self) -> State:
        """What there is to see now."""
        with self._lock:
            return State(
                setup=self._setup,
                training=self._now,
                running=self._running,
                curve=self._curve.points,
                before=self._before,
                trace=self._trace.lines if self._trace else (),
                said=self._said,
                version=self._version,
                rate=self._pace.rate if self._running else 0.0,
                kept=self._kept,
            )

    @property
    def version(self) -> int:
        """Rises with every change."""
        return self._version

    @property
    def running(self) -> bool:
        """Whether it is at work."""
        return self._running

    @property
    def setup(self) -> Setup:
        """What it is set up with."""
        return self._setup

    @property
    def network(self) -> Network:
        """The network as it is now."""
        return self._now.network

    def driver(self) -> Network:
        """The network as it is now, with a card: codec, names, how it was trained."""
        with self._lock:
            return describe(self._now, self._setup.table, self._setup.settings)

    @property
    def tracing(self) -> bool:
        """Whether every weight is written down as it changes."""
        return self._trace is not None

    def change(self, **changes: Any) -> None:
        """Choose something else, by the names of `Setup` and `OnlineSettings`.

        Another network begins afresh and waits. Other rates, rule, order or numbers in the table
        go on from the present weights, as a run of its own with momentum from 0. Tolerance and
        epochs change only when the present run ends.

        Raises:
            InputError: It cannot be; nothing has changed then.
        """
        with self._lock:
            old, new = self._setup, changed(self._setup, changes)
            self._setup = new
            if starts_elsewhere(old, new):
                self._halt()
                self._begin(new.initial(), new.weights)
            elif learns_differently(old, new):
                self._branch()
            else:
                self._soften(old.settings, new.settings)
            self._touch()

    def set_weight(self, index: int, weight: float) -> None:
        """Change one weight by hand.

        Raises:
            SettingError: There is no such weight, or that is no finite number.
        """
        with self._lock:
            weights = self._now.network.parameters.copy()
            if not 0 <= index < len(weights):
                raise SettingError(f"there is no weight number {index}")
            if not np.isfinite(weight):
                raise SettingError(f"a weight must be a finite number, got {weight}")
            weights[index] = weight
            self.set_weights(weights)

    def set_weights(self, weights: F64) -> None:
        """Change all weights by hand: a new run begins with them.

        Raises:
            InputError: Not as many finite numbers as there are weights.
        """
        with self._lock:
            if not np.isfinite(weights).all():
                raise SettingError("every weight must be a finite number")
            given = self._now.network.with_parameters(np.array(weights, dtype=np.float64))
            self.change(weights="given", given=given)

    def preset(self, choices: Mapping[str, Any]) -> None:
        """Set up what a lesson wants: table, hidden, activations, weights, speed and settings.

        Raises:
            InputError: A name there is not, or a value that is not allowed; nothing has changed.
        """
        wanted = dict(choices)
        speed = wanted.pop("speed", self.speed)
        if "table" in wanted and isinstance(wanted["table"], str):
            wanted.update(shipped=wanted["table"], table=shipped_patterns(wanted["table"]))
        if isinstance(wanted.get("hidden"), str):
            wanted["hidden"] = parse_hidden(wanted["hidden"])
        with self._lock:
            self.change(**wanted)
            self.choose_speed(speed)
            self.reset()

    @property
    def speed(self) -> str:
        """How fast it goes on: one of `SPEEDS`."""
        return self._pace.speed

    def choose_speed(self, speed: Any) -> None:
        """Go on faster or slower; a running training hears of it at once.

        Raises:
            SettingError: It is none of `SPEEDS`.
        """
        if speed not in SPEEDS:
            raise SettingError(f"unknown speed {speed!r}; {suggest(str(speed), SPEEDS)}")
        self._pace.choose(speed)

    def trace(self, on: bool) -> None:
        """Write down every weight as it changes, or no longer; it makes training slower."""
        with self._lock:
            if on != self.tracing:
                self._trace = TracePane() if on else None
                if self._running:  # a new thread, with or without recorder
                    self.pause()
                    self.start()
                self._touch()

    def start(self) -> None:
        """Train in the background until it ends or is paused; a running one goes on."""
        with self._lock:
            if self._running:
                return
            if self._now.stop is StopReason.DIVERGED:
                self._said = "It diverged: choose a smaller eta or momentum, then reset."
                self._touch()
                return
            self._now = dataclasses.replace(self._now, stop=None)
            self._said = ""
            self._running = True
            self._generation += 1
            self._pace.begin(self._now.epoch)
            thread = threading.Thread(
                target=self._run, args=(self._generation,), daemon=True, name="training"
            )
            thread.start()
            self._touch()

    def pause(self) -> None:
        """Stop where it is; to be gone on with later to the same bits."""
        with self._lock:
            self._halt()
            self._touch()

    def step_pattern(self) -> None:
        """Present the next pattern and change the weights once."""
        self._step(lambda now, *rest, **more: step_patterns(now, *rest, 1, **more))

    def step_epoch(self) -> None:
        """Present all patterns once, or those that are left of an epoch that was begun."""
        self._step(lambda now, *rest, **more: advance(now, *rest, 1, **more))

    def reset(self) -> None:
        """Back to the initial weights."""
        with self._lock:
            self._halt()
            self._begin(self._setup.initial(), self._setup.weights)
            self._touch()

    def keep_now(self) -> str:
        """Keep the run as it stands in the library; returns its name there.

        Raises:
            SettingError: It has not begun, or stands within an epoch.
        """
        with self._lock:
            if self._now.pattern:
                raise SettingError("finish the epoch first, with a step of one epoch")
            if not self._now.updates:
                raise SettingError("there is nothing to keep before the first epoch")
            kept = self._snapshot()
        name = keep_training(self._keep, kept)
        with self._lock:
            self._kept = name
            self._touch()
        return name

    def close(self) -> None:
        """Stop for good."""
        self.pause()

    def _begin(self, network: Network, weights: str) -> None:
        """A run from these weights; the curve of the one before stays as a shadow."""
        if len(self._curve.points) > 1:
            self._before = self._curve.points
        self._initial, self._weights = network, weights
        self._now = self._boundary = Training.fresh(network)
        self._seconds = 0.0
        self._exact = True
        self._said = self._kept = ""
        self._done = -1
        self._curve = Curve()
        if self._trace is not None:
            self._trace = TracePane()
        self._generation += 1
        self._look()

    def _branch(self) -> None:
        """Go on from the present weights as a run of its own."""
        if not self._now.updates:
            self._begin(self._setup.initial(), self._setup.weights)
            return
        running = self._running
        self._halt()
        self._begin(self._now.network, "given")
        if running:
            self.start()

    def _halt(self) -> None:
        """What the thread is doing now no longer counts."""
        self._running = False
        self._generation += 1
        self._pace.hurry()

    def _soften(self, old: OnlineSettings, new: OnlineSettings) -> None:
        """Another end: a run from the beginning might now end earlier than this one stands."""
        if (old.tolerance, old.epochs) == (new.tolerance, new.epochs):
            return
        if self._now.updates and (new.tolerance > old.tolerance or new.epochs < old.epochs):
            self._exact = False
        if self._now.stop in (StopReason.TOLERANCE, StopReason.EPOCHS):
            self._now = dataclasses.replace(self._now, stop=None)
        if self._running:  # the thread holds the old settings
            self._halt()
            self.start()

    def _step(self, step: Callable[..., Training]) -> None:
        with self._lock:
            if self._running:
                self.pause()
            if self._now.stop is StopReason.DIVERGED:
                self._said = "It diverged: choose a smaller eta or momentum, then reset."
                self._touch()
                return
            now = dataclasses.replace(self._now, stop=None)
            recorder = self._record if self.tracing else None
            after = step(now, self._setup.table, self._setup.settings, recorder=recorder)
            self._said = ""
            self._commit(after)
            self._look()
            kept = self._snapshot() if self._ended() else None
            self._touch()
        if kept is not None:
            self._finish(kept)

    def _run(self, generation: int) -> None:
        """The thread: the same loop as everywhere, watched and paced."""
        with self._lock:
            begun, setup = self._now, self._setup
            recorder = self._recorder(generation) if self.tracing else None
        began = time.perf_counter()

        def on_event(event: Progress) -> bool:
            with self._lock:
                if generation != self._generation:
                    return False
                self._curve.add(event)
                self._touch()
            return self._pace.wait(event, lambda: generation == self._generation)

        def on_step(training: Training) -> None:
            with self._lock:
                if generation == self._generation:
                    self._commit(training)

        try:
            ended = train(
                begun, setup.table, setup.settings,
                on_event=on_event, recorder=recorder, on_step=on_step,
            )  # fmt: skip
        except (RovernavError, MemoryError) as error:
            ended, said = None, str(error)
        with self._lock:
            if generation != self._generation:
                return
            self._seconds += time.perf_counter() - began
            self._running = False
            if ended is None:
                self._said = said
            else:
                self._commit(ended)
            kept = self._snapshot() if self._ended() else None
            self._touch()
        if kept is not None:
            self._finish(kept)

    def _finish(self, kept: Kept) -> None:
        """Keep the finished run, once."""
        if self._done == kept.training.updates:
            return
        self._done = kept.training.updates
        try:
            name, said = keep_training(self._keep, kept), ""
        except RovernavError as error:  # a full disk loses the record, not the training
            name, said = "", f"Not kept: {error}"
        with self._lock:
            self._kept, self._said = name, said or self._said
            self._touch()

    def _ended(self) -> bool:
        return self._now.stop is not None and self._now.updates > 0

    def _snapshot(self) -> Kept:
        return Kept(
            setup=self._setup,
            initial=self._initial,
            weights=self._weights,
            training=self._now,
            curve=self._curve.points,
            exact=self._exact,
            seconds=self._seconds,
        )

    def _commit(self, training: Training) -> None:
        """Where it stands now; a run that diverges within an epoch goes back to its beginning."""
        if training.stop is StopReason.INTERRUPTED:
            training = dataclasses.replace(training, stop=None)
        if training.stop is StopReason.DIVERGED and training.pattern:
            training = dataclasses.replace(self._boundary, stop=StopReason.DIVERGED)
        if training.stop is StopReason.DIVERGED:
            self._said = "It diverged: a weight became infinite. The last good network is kept."
        if not training.pattern:
            self._boundary = training
        self._now = training

    def _look(self) -> None:
        """A point of the curve for where it stands."""
        self._curve.add(progress(self._now, self._setup.table, 0.0))

    def _record(self, epoch: int, patterns: np.ndarray, weights: F64) -> None:
        if self._trace is not None:
            self._trace.add(epoch, patterns, weights, len(self._setup.table.x))

    def _recorder(self, generation: int) -> Callable[[int, np.ndarray, F64], None]:
        def record(epoch: int, patterns: np.ndarray, weights: F64) -> None:
            with self._lock:
                if generation == self._generation:
                    self._record(epoch, patterns, weights)

        return record

    def _touch(self) -> None:
        self._version += 1


def warm_up() -> None:
    """Compile, or load, the kernels of the first click."""
    network, table, settings = paper_training()
    begun = Training.fresh(network)
    step_patterns(begun, table, settings)
    train(begun, table, dataclasses.replace(settings, epochs=2), on_event=lambda event: None)
