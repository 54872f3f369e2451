from __future__ import annotations

import itertools
import os
import signal
import threading
from collections.abc import Iterator
from typing import Any

import pytest

from rovernav.core import Executor, Processes, Serial, SettingError, Threads, WorkerError


def scaled(shared: float, item: int) -> float:
    return shared * item


def failing(_shared: Any, item: int) -> int:
    if item == 3:
        raise SettingError("item 3 is bad")
    return item


@pytest.mark.parametrize(
    "executor", [Serial(), Threads(3), Processes(2)], ids=lambda e: type(e).__name__
)
def test_results_come_in_the_order_of_the_items(executor: Executor) -> None:
    done = itertools.count()
    results = list(executor.map(scaled, range(20), shared=0.5, on_done=lambda: next(done)))
    assert results == [0.5 * item for item in range(20)]
    assert next(done) == 20


@pytest.mark.parametrize("executor", [Serial(), Threads(3)], ids=["serial", "threads"])
def test_the_error_of_a_job_stands_in_its_place(executor: Executor) -> None:
    results = executor.map(failing, range(10))
    assert [next(results) for _ in range(3)] == [0, 1, 2]
    with pytest.raises(SettingError, match="item 3 is bad"):
        next(results)


def test_items_are_drawn_only_a_few_ahead() -> None:
    drawn = 0

    def endless() -> Iterator[int]:
        nonlocal drawn
        while True:
            drawn += 1
            yield drawn

    results = Threads(2).map(scaled, endless(), shared=1.0)
    assert [next(results) for _ in range(5)] == [1, 2, 3, 4, 5]
    assert drawn <= 5 + 3 * 2
    del results  # ends the threads


def test_threads_run_side_by_side() -> None:
    meet = threading.Barrier(2, timeout=30)

    def wait(_shared: Any, _item: int) -> int:
        return meet.wait()

    assert sorted(Threads(2).map(wait, range(2))) == [0, 1]


def dying(_shared: Any, item: int) -> int:
    if item == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return item


def deaf(_shared: Any, item: int) -> int:
    os.kill(os.getpid(), signal.SIGINT)
    return item


def test_a_process_that_dies_is_told_of_in_a_sentence() -> None:
    with pytest.raises(WorkerError, match=r"^a worker process ended before its work was done, per"):
        list(Processes(1).map(dying, range(3)))


@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="no signal masks here")
def test_processes_leave_ctrl_c_to_their_parent() -> None:
    assert list(Processes(1).map(deaf, range(2))) == [0, 1]


@pytest.mark.parametrize("kind", [Threads, Processes])
def test_no_workers_are_refused(kind: Any) -> None:
    with pytest.raises(SettingError, match=r"workers must be 1 or more, got 0"):
        kind(0)


def test_all_processors_where_nothing_is_said() -> None:
    assert Threads().workers >= 1
