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
    shipped_patterns,
    step_patterns,
    train,
)
from ..nets import Network
from ._attempt import Attempt
from ._curve import Point, TracePane
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
        self._said = self._kept = ""
        self._run = Attempt(self._setup.initial(), self._setup.weights, table)
        self._before: tuple[Point, ...] = ()

    def state(self) -> State:
        """What there is to see now."""
        with self._lock:
            return State(
                setup=self._setup,
                training=self._run.now,
                running=self._running,
                curve=self._run.curve.points,
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
        return self._run.now.network

    def driver(self) -> Network:
        """The network as it is now, with a card: codec, names, how it was trained."""
        with self._lock:
            return describe(self._run.now, self._setup.table, self._setup.settings)

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
                self._end_elsewhere(old.settings, new.settings)
            self._touch()

    def set_weights(self, weights: F64) -> None:
        """Change all weights by hand: a new run begins with them.

        Raises:
            InputError: Not as many finite numbers as there are weights.
        """
        with self._lock:
            if not np.isfinite(weights).all():
                raise SettingError("every weight must be a finite number")
            given = self._run.now.network.with_parameters(np.array(weights, dtype=np.float64))
            self.change(weights="given", given=given)

    def preset(self, choices: Mapping[str, Any]) -> None:
        """Set up what a lesson wants: table, hidden, activations, weights, speed and settings.

        Raises:
            InputError: A name there is not, or a value that is not allowed; nothing has changed.
        """
        wanted = dict(choices)
        speed = _speed(wanted.pop("speed", self.speed))
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
        self._pace.choose(_speed(speed))

    def trace(self, on: bool) -> None:
        """Write down every weight as it changes, or no longer; it makes training slower."""
        with self._lock:
            if on != self.tracing:
                self._trace = TracePane() if on else None
                if self._running:  # a new thread, with or without recorder
                    self._halt()
                    self.start()
                self._touch()

    def start(self) -> None:
        """Train in the background until it ends or is paused; a running one goes on."""
        with self._lock:
            if self._running or not self._may_go_on():
                return
            self._running = True
            self._generation += 1
            self._pace.begin(self._run.now.epoch)
            threading.Thread(
                target=self._work, args=(self._generation,), daemon=True, name="training"
            ).start()
            self._touch()

    def pause(self) -> None:
        """Stop where it is; to be gone on with later to the same bits."""
        with self._lock:
            self._halt()
            self._touch()

    def step_pattern(self) -> None:
        """Present the next pattern and change the weights once."""
        self._step(step_patterns)

    def step_epoch(self) -> None:
        """Present all patterns once, or those that are left of an epoch that was begun."""
        self._step(advance)

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
            if self._run.now.pattern:
                raise SettingError("finish the epoch first, with a step of one epoch")
            if not self._run.now.updates:
                raise SettingError("there is nothing to keep before the first epoch")
            kept = self._run.snapshot(self._setup)
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
        if len(self._run.curve.points) > 1:
            self._before = self._run.curve.points
        self._run = Attempt(network, weights, self._setup.table)
        self._said = self._kept = ""
        if self._trace is not None:
            self._trace = TracePane()

    def _branch(self) -> None:
        """Go on from the present weights as a run of its own."""
        running = self._running
        self._halt()
        if self._run.now.updates:
            self._begin(self._run.now.network, "given")
        else:
            self._begin(self._run.initial, self._run.weights)
        if running:
            self.start()

    def _halt(self) -> None:
        """What the thread is doing now no longer counts."""
        self._running = False
        self._generation += 1
        self._pace.hurry()

    def _end_elsewhere(self, old: OnlineSettings, new: OnlineSettings) -> None:
        if (old.tolerance, old.epochs) == (new.tolerance, new.epochs):
            return
        self._run.soften(old, new)
        if self._running:  # the thread holds the old settings
            self._halt()
            self.start()

    def _may_go_on(self) -> bool:
        """Whether there is a way on; one that diverged has none."""
        if self._run.now.stop is StopReason.DIVERGED:
            self._said = "It diverged: choose a smaller eta or momentum, then reset."
            self._touch()
            return False
        self._run.go_on()
        self._said = ""
        return True

    def _step(self, step: Callable[..., Training]) -> None:
        with self._lock:
            self._halt()
            if not self._may_go_on():
                return
            recorder = self._record if self.tracing else None
            table, settings = self._setup.table, self._setup.settings
            self._commit(step(self._run.now, table, settings, 1, recorder=recorder))
            self._run.look(table)
            kept = self._run.snapshot(self._setup) if self._run.ended else None
            self._touch()
        if kept is not None:
            self._finish(kept)

    def _work(self, generation: int) -> None:
        """The thread: the same loop as everywhere, watched and paced."""
        with self._lock:
            attempt, setup = self._run, self._setup
            begun, traced = attempt.now, self.tracing
        waiting: list[tuple[int, np.ndarray, F64]] = []
        began = time.perf_counter()

        def on_event(event: Progress) -> bool:
            with self._lock:
                if generation != self._generation:
                    return False
                attempt.curve.add(event)
                self._touch()
            return self._pace.wait(event, lambda: generation == self._generation)

        def on_step(training: Training) -> None:
            with self._lock:
                if generation == self._generation:
                    for part in waiting:
                        self._record(*part)
                    self._commit(training)
            waiting.clear()

        try:
            ended = train(
                begun, setup.table, setup.settings, on_event=on_event, on_step=on_step,
                recorder=(lambda *part: waiting.append(part)) if traced else None,
            )  # fmt: skip
            said = ""
        except (RovernavError, MemoryError) as error:
            ended, said = None, str(error) or "not enough memory"
        with self._lock:
            attempt.seconds += time.perf_counter() - began
            if generation != self._generation:
                return
            self._running = False
            self._said = said
            if ended is not None:
                self._commit(ended)
            kept = attempt.snapshot(setup) if attempt.ended else None
            self._touch()
        if kept is not None:
            self._finish(kept)

    def _finish(self, kept: Kept) -> None:
        """Keep the finished run, once."""
        with self._lock:
            if self._run.kept_at == kept.training.updates:
                return
            self._run.kept_at = kept.training.updates
        try:
            name, said = keep_training(self._keep, kept), ""
        except RovernavError as error:  # a full disk loses the record, not the training
            name, said = "", f"Not kept: {error}"
        with self._lock:
            self._kept, self._said = name, said or self._said
            self._touch()

    def _commit(self, training: Training) -> None:
        self._run.commit(training)
        if training.stop is StopReason.DIVERGED:
            self._said = "It diverged: a weight became infinite. The last good network is kept."

    def _record(self, epoch: int, patterns: np.ndarray, weights: F64) -> None:
        if self._trace is not None:
            self._trace.add(epoch, patterns, weights, len(self._setup.table.x))

    def _touch(self) -> None:
        self._version += 1


def _speed(name: Any) -> str:
    """Raise `SettingError` unless it is one of `SPEEDS`."""
    if name not in SPEEDS:
        raise SettingError(f"unknown speed {name!r}; {suggest(str(name), SPEEDS)}")
    return name


def warm_up() -> None:
    """Compile, or load, the kernels of the first click."""
    network, table, settings = paper_training()
    begun = Training.fresh(network)
    step_patterns(begun, table, settings)
    train(begun, table, dataclasses.replace(settings, epochs=2), on_event=lambda event: None)
