"""The executor that spreads work over a Dask cluster.

Shared values travel as results of tasks, not as scattered data: the scheduler keeps the recipe, so
a copy that died with its worker is made again, and workers that join later fetch one from another
worker. A task names its shared values; Dask brings each to a worker once, before the first task.
"""

from __future__ import annotations

import contextlib
import itertools
import pickle
import threading
import time
import uuid
from collections import OrderedDict
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import CancelledError
from dataclasses import dataclass
from typing import Any, TypeVar, final

from ..core import WorkerError, in_order
from ..core.executors import AHEAD, is_frozen
from ._parcel import Parcel
from ._work import (
    DONE,
    FOREIGN,
    Answer,
    deliver,
    fingerprint,
    own_mark,
    pack_items,
    processor,
    run_items,
)

Item = TypeVar("Item")
Result = TypeVar("Result")
LOOK = 1.0
"""How often it looks how the cluster is, while it waits [s]."""
PATIENCE = 60.0
"""How long a cluster may be without any worker [s]."""
KEPT = 8
"""Shared values that stay on the cluster for the next map."""
GRAIN, MOST = 0.25, 1000
"""Items that take less than this share a task [s], up to so many; a task costs some 5 ms."""
PARTS = 4
"""A shared tuple of up to so many parts is sent part by part; beyond, Dask spreads tasks less."""


@final
class DaskExecutor:
    """Runs items on the workers of a Dask cluster, which is handed in and stays as it is.

    The order, the results and the errors are those of `rovernav.core.Serial`. A worker that dies
    or leaves loses nothing: its items are done again by others. A shared value is sent to each
    worker once, in later maps too if it has not changed; the parts of a shared tuple by themselves.
    Workers must have the same packages and the same rovernav as this process, else the first item
    says so. An item is pickled, so the cluster must be one that is trusted.

    Args:
        client: A ``distributed.Client``; whoever made it closes it.
        patience: How long the cluster may be without any worker before work is given up [s].

    Attributes:
        workers: Task slots of the cluster when last looked at.
        notes: What a user should know about the workers so far, in sentences.
    """

    def __init__(self, client: Any, *, patience: float = PATIENCE) -> None:
        self.workers = 1
        self.notes: list[str] = []
        self._client = client
        self._patience = patience
        self._kept: OrderedDict[str, _Kept] = OrderedDict()
        self._lock = threading.Lock()
        self._looked = -LOOK
        self._alone: float | None = None
        self._look()

    def map(
        self,
        job: Callable[[Any, Item], Result],
        items: Iterable[Item],
        *,
        shared: Any = None,
        on_done: Callable[[], object] | None = None,
    ) -> Iterator[Result]:
        """The results, in order; the first error of a job is raised in its place.

        Raises:
            WorkerError: The cluster has gone, has no workers left, has workers that do not fit, or
                an item ended one worker after another.
        """
        parcels, spread = self._send(shared)
        name = f"rovernav-{getattr(job, '__name__', 'job').strip('_')}-{uuid.uuid4().hex[:12]}"
        pace = _Pace()
        afloat: dict[int, Any] = {}

        def submit(group: tuple[int, Sequence[Item]]) -> _Promise:
            first, some = group
            future = self._submit(
                run_items, pack_items(job, some), own_mark(), spread, *parcels, key=(name, first)
            )
            afloat[first] = future
            return _Promise(future, len(some), on_done, lambda: self._took(group, afloat, pace))

        try:
            for answer in in_order(submit, pace.groups(items), self._ahead, None):
                for state, found in answer.found:
                    if state != DONE:
                        raise pickle.loads(found)
                    yield pickle.loads(found)
        finally:
            if afloat:  # an error, Ctrl-C, or nobody wants the rest
                with contextlib.suppress(Exception):
                    self._client.cancel(list(afloat.values()))

    def forget(self) -> None:
        """Take the shared values off the cluster; the next map sends them again."""
        with self._lock:
            self._kept.clear()

    def _send(self, shared: Any) -> tuple[list[Any], bool]:
        """Tasks whose results are the shared parts, and whether they are parts of a tuple."""
        if shared is None:
            return [], False
        spread = type(shared) is tuple and 1 <= len(shared) <= PARTS
        parts = shared if spread else (shared,)
        with self._lock:
            sent = [self._sent(part) for part in parts]
            while len(self._kept) > KEPT:
                self._kept.popitem(last=False)
        return sent, spread

    def _sent(self, part: Any) -> Any:
        """The task of one part; one that is on the cluster already is used again."""
        for name, kept in self._kept.items():
            if kept.part is part and kept.lives():
                self._kept.move_to_end(name)
                return kept.future
        name, parcel = Parcel.pack(part)
        kept = self._kept.get(name)
        if kept is None or not kept.lives():
            from dask.config import set as configured

            with configured({"distributed.admin.large-graph-warning-threshold": "1 PiB"}):
                future = self._submit(deliver, parcel, key=f"rovernav-shared-{name}")
            kept = _Kept(future, part if is_frozen(part) else None)
        self._kept[name] = kept
        self._kept.move_to_end(name)
        return kept.future

    def _submit(self, function: Any, *given: Any, key: Any) -> Any:
        try:
            return self._client.submit(function, *given, key=key, pure=False)
        except Exception as error:
            if self._client.status == "running":
                raise
            raise WorkerError(f"the cluster has gone: {_line(error)}") from None

    def _ahead(self) -> int:
        self._look()
        return AHEAD * max(1, self.workers)

    def _look(self) -> None:
        """Count the workers, at most once in `LOOK` seconds."""
        now = time.monotonic()
        if now < self._looked + LOOK:
            return
        self._looked = now
        if self._client.status in ("closed", "closing"):
            raise WorkerError("the connection to the cluster was closed before the work was done")
        try:
            slots = self._client.sync(self._client.scheduler.ncores, callback_timeout=5.0)
        except Exception:  # busy or away; a task's own end will tell
            return
        self.workers = sum(slots.values())
        if slots:
            self._alone = None
        elif self._alone is None:
            self._alone = now
        elif now > self._alone + self._patience:
            raise WorkerError(
                f"the cluster has had no worker for {now - self._alone:.0f} s; "
                "start workers, or run it without --cluster"
            )

    def _took(
        self, group: tuple[int, Sequence[Any]], afloat: dict[int, Any], pace: _Pace
    ) -> Answer:
        """What a worker found."""
        first, some = group
        answer: Answer = pickle.loads(self._gathered(afloat[first], first, len(some)))
        afloat.pop(first)
        if answer.found[0][0] == FOREIGN:
            raise WorkerError(_difference(answer.found[0][1]))
        if answer.processor != processor():
            note = (
                f"some workers have another processor or C library ({answer.processor}) than this "
                f"machine ({processor()}); results may differ from this machine's in their last "
                "bits"
            )
            if note not in self.notes:
                self.notes.append(note)
        pace.learn(answer.seconds / len(some))
        return answer

    def _gathered(self, future: Any, first: int, count: int) -> bytes:
        from distributed import KilledWorker

        while True:
            try:
                return future.result(timeout=LOOK)
            except TimeoutError:
                self._look()
            except KilledWorker as error:
                which = f"items {first + 1} to {first + count} were"
                which = f"item {first + 1} was" if count == 1 else which
                raise WorkerError(
                    f"{which} given up: {error.allowed_failures + 1} workers ended, one after "
                    "another, while they had it; perhaps it needs more memory than a worker has"
                ) from None
            except CancelledError as error:
                raise WorkerError(
                    f"the cluster has gone, or took the work back: {_line(error)}"
                ) from None
            except Exception as error:
                raise WorkerError(
                    f"a worker or the scheduler could not open its work ({_line(error)}); it needs "
                    "the same packages and modules as this machine"
                ) from None


@final
class _Pace:
    """How many items make a task: one where an item takes long, many where it takes no time."""

    def __init__(self) -> None:
        self._together, self._drawn = 1, 0

    def groups(self, items: Iterable[Item]) -> Iterator[tuple[int, Sequence[Item]]]:
        """The items in groups, each with the number of its first."""
        rest = iter(items)
        while some := tuple(itertools.islice(rest, self._together)):
            yield self._drawn, some
            self._drawn += len(some)

    def learn(self, seconds: float) -> None:
        """An item took so long [s]."""
        wanted = int(GRAIN / max(seconds, GRAIN / MOST))
        self._together = max(1, min(wanted, 2 * self._together))


@dataclass(frozen=True)
class _Kept:
    """A shared value on the cluster.

    Attributes:
        future: The task whose result it is; while it lives, so does the value.
        part: The value here, if it is a frozen one that needs no second look.
    """

    future: Any
    part: Any

    def lives(self) -> bool:
        return self.future.status in ("pending", "finished")


@final
class _Promise:
    """Some items on the cluster, as `in_order` waits for them."""

    def __init__(
        self,
        future: Any,
        count: int,
        on_done: Callable[[], object] | None,
        take: Callable[[], Answer],
    ) -> None:
        self._future, self._take = future, take
        self._untold, self._on_done = count, on_done
        self._lock = threading.Lock()
        if on_done is not None:
            future.add_done_callback(self._tell)

    def result(self) -> Answer:
        answer = self._take()
        self._tell(self._future)  # Dask tells in a thread of its own, perhaps later
        return answer

    def add_done_callback(self, fn: Callable[[Any], object], /) -> None:
        raise NotImplementedError  # each item is told of, not each task

    def _tell(self, future: Any) -> None:
        if future.status != "finished" or self._on_done is None:
            return
        with self._lock:
            untold, self._untold = self._untold, 0
        for _ in range(untold):
            self._on_done()


def _difference(theirs: dict[str, str]) -> str:
    """What differs between a worker and this machine, in a sentence."""
    ours = fingerprint()
    for name, version in ours.items():
        if theirs.get(name, "missing") != version:
            return (
                f"a worker has {name} {theirs.get(name, 'missing')}, this machine has {version}; "
                "results could differ, so install the same on all"
            )
    return "a worker has another rovernav than this machine; install the same on all"


def _line(error: BaseException) -> str:
    """An error in one line."""
    words = " ".join(str(error).split()) or type(error).__name__
    return words if len(words) < 200 else f"{words[:200]}..."
