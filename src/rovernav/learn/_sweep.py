"""Sweeps: thousands of independent trainings at once, each with the bits that it has alone."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Generator, Iterator
from contextlib import closing
from typing import TypeAlias

import numpy as np

from ..core import Executor, Threads, value
from ._patterns import Patterns
from ._sweep_block import Brake, Rows, Shared, sweep_block, train_numbers
from ._sweep_scores import MemberScore, Scores, SettingScore
from ._sweep_settings import SweepSettings
from ._sweep_store import SweepStore


@value
class SweepProgress:
    """How far a sweep is.

    Attributes:
        members: Members that have ended, those of an earlier run included.
        of: Members in all.
        solved: Members that met the tolerance.
        rate: Members a second in this run.
        seconds: Time since this run began [s].
    """

    members: int
    of: int
    solved: int
    rate: float
    seconds: float


SweepListener: TypeAlias = Callable[[SweepProgress], bool | None]
"""Called after each block; a listener that returns False ends the sweep, which can be resumed."""


@value
class SweepResult:
    """What came out of a sweep.

    Attributes:
        members: Members that have ended; all of them, unless it was interrupted.
        finished: Whether all have.
        solved: Members that met the tolerance.
        diverged: Members of which a weight stopped being finite.
        updates: Weight updates of all these members.
        seconds: Time of this run on the clock, compiling excluded [s].
        updates_now: Weight updates of this run: without those of the runs that it resumed.
        workers: How many worked on it.
        settings: How each eta and momentum did, of which all members have ended.
        best: The member that met the tolerance in the fewest epochs, or the one with the smallest
            error where none did; None before the first.
    """

    members: int
    finished: bool
    solved: int
    diverged: int
    updates: int
    seconds: float
    updates_now: int
    workers: int
    settings: tuple[SettingScore, ...]
    best: MemberScore | None

    @property
    def ns_per_update(self) -> float:
        """Time on the clock for each weight update of this run [ns]; NaN if it did none."""
        return 1e9 * self.seconds / self.updates_now if self.updates_now else math.nan


def sweep(
    patterns: Patterns,
    settings: SweepSettings,
    *,
    executor: Executor | None = None,
    store: SweepStore | None = None,
    on_event: SweepListener | None = None,
) -> SweepResult:
    """Train every member of a sweep.

    Members come in blocks, the items of the executor. Whoever runs them, and however often the
    sweep is interrupted and resumed, each member has the bits of its training alone.

    Args:
        patterns: What all of them learn.
        settings: Which members there are.
        executor: Where blocks run; on threads, as many as there are processors, if not given.
        store: Where rows are kept, and from where it goes on; memory if not given.
        on_event: Told after each block; may end the sweep.

    Returns:
        Counts, scores and the best member. Ctrl-C returns what there is by then.

    Raises:
        ShapeError: Patterns and topology do not fit.
        FileError: The store cannot keep a block.
    """
    settings.check_fit(patterns)
    executor = Threads() if executor is None else executor
    store = SweepStore.in_memory(settings, patterns) if store is None else store
    scores = Scores(settings, len(patterns.x))
    for rows in store.rows():
        scores.add(rows)
    shared = Shared(patterns, settings, Brake())
    before, seconds = scores.updates, 0.0
    if store.members < settings.members:
        train_numbers(shared, np.empty(0, np.int64))  # compile, or load, before the clock starts
        seconds = _run(shared, executor, store, scores, on_event)
    return SweepResult(
        members=scores.members,
        finished=scores.members == settings.members,
        solved=scores.solved,
        diverged=scores.diverged,
        updates=scores.updates,
        seconds=seconds,
        updates_now=scores.updates - before,
        workers=executor.workers,
        settings=tuple(scores.settings),
        best=scores.best,
    )


def _each(results: Iterator[Rows]) -> Generator[Rows]:
    """The results of any executor, to be closed early."""
    yield from results


def _run(
    shared: Shared,
    executor: Executor,
    store: SweepStore,
    scores: Scores,
    on_event: SweepListener | None,
) -> float:
    """Do the blocks that are missing; the time that it took [s]."""
    total, start = shared.settings.members, store.members
    items = ((at, min(at + store.block, total)) for at in range(start, total, store.block))
    began = time.perf_counter()
    try:
        with closing(_each(executor.map(sweep_block, items, shared=shared))) as blocks:
            for rows in blocks:
                store.append(rows)
                scores.add(rows)
                seconds = time.perf_counter() - began
                event = SweepProgress(
                    members=scores.members,
                    of=total,
                    solved=scores.solved,
                    rate=(scores.members - start) / max(seconds, 1e-9),
                    seconds=seconds,
                )
                if on_event is not None and on_event(event) is False:
                    shared.brake.pull()
                    break
    except KeyboardInterrupt:
        pass  # what is kept is kept
    finally:
        shared.brake.pull()
    return time.perf_counter() - began
