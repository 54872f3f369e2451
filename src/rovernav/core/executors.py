"""Where work runs: in this thread, on threads, in processes. A cluster's is in `adapters`.

A job is a function of what all items share and of one item. Whoever runs it, the same items give
the same results in the same order; only the time differs.
"""

from __future__ import annotations

import contextlib
import os
import signal
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from dataclasses import is_dataclass
from typing import TYPE_CHECKING, Any, Protocol, TypeVar, final

from .errors import SettingError, WorkerError

if TYPE_CHECKING:  # most commands need no pool, and theirs is a slow import
    from concurrent.futures import Future, ProcessPoolExecutor

Item = TypeVar("Item")
Result = TypeVar("Result")
Promised = TypeVar("Promised", covariant=True)
AHEAD = 3
"""Items in flight per worker: enough to keep all busy, few enough to bound memory."""


def cores() -> int:
    """Processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return max(1, len(os.sched_getaffinity(0)))
    return os.cpu_count() or 1


@final
class Serial:
    """Runs every item in the calling thread."""

    workers = 1

    def map(
        self,
        job: Callable[[Any, Item], Result],
        items: Iterable[Item],
        *,
        shared: Any = None,
        on_done: Callable[[], object] | None = None,
    ) -> Iterator[Result]:
        """The results, in order, each made when it is asked for."""
        for item in items:
            result = job(shared, item)
            if on_done is not None:
                on_done()
            yield result


@final
class Threads:
    """Runs items on threads of this process: for jobs that spend their time in kernels.

    Args:
        workers: How many threads; all processors that this process may use where not given.

    Raises:
        SettingError: Fewer than one worker.
    """

    def __init__(self, workers: int | None = None) -> None:
        self.workers = _checked(workers)

    def map(
        self,
        job: Callable[[Any, Item], Result],
        items: Iterable[Item],
        *,
        shared: Any = None,
        on_done: Callable[[], object] | None = None,
    ) -> Iterator[Result]:
        """The results, in order; the first error of a job is raised in its place."""
        from concurrent.futures import ThreadPoolExecutor

        wait, pool = True, ThreadPoolExecutor(self.workers, thread_name_prefix="rovernav")
        try:
            yield from in_order(
                lambda item: pool.submit(job, shared, item),
                items,
                lambda: AHEAD * self.workers,
                on_done,
            )
        except KeyboardInterrupt:
            wait = False  # whoever asked for the work can now tell its jobs to end
            raise
        finally:
            pool.shutdown(wait=wait, cancel_futures=True)


@final
class Processes:
    """Runs items in processes of this machine, which hold the shared value from their start.

    After a map whose shared value is frozen they stay for the next map with the same one.

    Args:
        workers: How many processes; all processors that this process may use where not given.

    Raises:
        SettingError: Fewer than one worker.
    """

    def __init__(self, workers: int | None = None) -> None:
        self.workers = _checked(workers)
        self._kept: tuple[Any, ProcessPoolExecutor] | None = None

    def map(
        self,
        job: Callable[[Any, Item], Result],
        items: Iterable[Item],
        *,
        shared: Any = None,
        on_done: Callable[[], object] | None = None,
    ) -> Iterator[Result]:
        """The results, in order; `job` must be importable by its name.

        Raises:
            WorkerError: A process ended by itself: killed, or out of memory.
        """
        from concurrent.futures.process import BrokenProcessPool

        whole, pool = False, self._open(shared)

        def submit(item: Item) -> Future[Result]:
            with undisturbed():  # the first item starts the processes
                return pool.submit(_held_job, job, item)

        try:
            yield from in_order(
                submit,
                items,
                lambda: AHEAD * self.workers,
                on_done,
            )
            whole = is_frozen(shared)
        except BrokenProcessPool:
            raise WorkerError(
                "a worker process ended before its work was done, perhaps for want of memory; "
                "use fewer workers"
            ) from None
        finally:
            if whole and self._kept is None:
                self._kept = shared, pool  # they end when nobody holds this executor any more
            else:
                pool.shutdown(cancel_futures=True)

    def _open(self, shared: Any) -> ProcessPoolExecutor:
        """Processes that hold the shared value; they are no longer kept."""
        import multiprocessing
        from concurrent.futures import ProcessPoolExecutor

        if self._kept is not None:
            (held, pool), self._kept = self._kept, None
            if held is shared:
                return pool
            pool.shutdown()
        return ProcessPoolExecutor(
            self.workers,
            mp_context=multiprocessing.get_context("spawn"),  # threads of ours do not survive fork
            initializer=_hold,
            initargs=(shared,),
        )


def is_frozen(shared: Any) -> bool:
    """Whether the same object will have the same content next time."""
    return is_dataclass(shared) and bool(vars(type(shared))["__dataclass_params__"].frozen)


@contextlib.contextmanager
def undisturbed() -> Generator[None]:
    """Processes started inside never hear Ctrl-C, which is this one's to answer.

    One that comes meanwhile is answered at the end.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    from multiprocessing import resource_tracker

    resource_tracker.ensure_running()  # begun later, it would unblock the signal
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # children inherit it
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class Promise(Protocol[Promised]):
    """The result of an item that is being worked on."""

    def result(self) -> Promised:
        """Wait for it; raises the job's error."""
        ...

    def add_done_callback(self, fn: Callable[[Any], object], /) -> object:
        """Call `fn` once it is done, in any thread."""
        ...


def in_order(
    submit: Callable[[Item], Promise[Result]],
    items: Iterable[Item],
    ahead: Callable[[], int],
    on_done: Callable[[], object] | None,
) -> Iterator[Result]:
    """Results in the order of the items, never more than `ahead()` submitted and not taken."""
    waiting: deque[Promise[Result]] = deque()
    for item in items:
        while len(waiting) >= max(1, ahead()):
            yield waiting.popleft().result()
        future = submit(item)
        if on_done is not None:
            future.add_done_callback(lambda _done: on_done())
        waiting.append(future)
    while waiting:
        yield waiting.popleft().result()


def _checked(workers: int | None) -> int:
    count = cores() if workers is None else workers
    if count < 1:
        raise SettingError(f"workers must be 1 or more, got {count}")
    return count


_held: Any = None


def _hold(shared: Any) -> None:
    global _held
    _held = shared


def _held_job(job: Callable[[Any, Item], Result], item: Item) -> Result:
    return job(_held, item)
