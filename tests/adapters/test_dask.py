from __future__ import annotations

import gc
import itertools
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from rovernav.adapters import DaskExecutor
from rovernav.core import Executor, PatternError, Serial, SettingError, WorkerError
from tests.adapters import jobs
from tests.adapters.clusters import pids

pytestmark = pytest.mark.xdist_group("cluster")  # one cluster for all


def tasks(client: Any) -> list[str]:
    """What the scheduler knows of ours."""

    def names(dask_scheduler: Any) -> list[str]:
        return [str(key) for key in dask_scheduler.tasks]

    return [name for name in client.run_on_scheduler(names) if "rovernav" in name]


def wait_until_forgotten(client: Any, word: str) -> None:
    until = time.monotonic() + 30
    while gc.collect() >= 0 and (left := [name for name in tasks(client) if word in name]):
        assert time.monotonic() < until, left
        time.sleep(0.05)


def test_it_plays_the_role(executor: DaskExecutor) -> None:
    assert isinstance(executor, Executor)
    assert executor.workers == 2


@pytest.mark.parametrize("shared", [0.1, np.arange(50) / 3])
def test_order_and_bits_are_those_of_a_serial_run(executor: DaskExecutor, shared: Any) -> None:
    there = list(executor.map(jobs.mixed, range(30), shared=shared))
    here = list(Serial().map(jobs.mixed, range(30), shared=shared))
    assert [a.tobytes() for a in there] == [a.tobytes() for a in here]
    assert all(a.flags.writeable for a in there)


def until_both_have_worked(executor: DaskExecutor, shared: Any) -> list[Any]:
    """What `jobs.whose` finds, map after map; on a busy machine one worker may get all of one."""
    found: list[Any] = []
    until = time.monotonic() + 60.0
    while len({pid for pid, _ in found}) < 2 and time.monotonic() < until:
        found += executor.map(jobs.whose, range(100), shared=shared)
    return found


def test_both_workers_work(executor: DaskExecutor) -> None:
    assert len({pid for pid, _ in until_both_have_worked(executor, 1)}) == 2


def test_every_item_is_told_once_and_before_the_end(executor: DaskExecutor) -> None:
    done = itertools.count()
    for _ in executor.map(jobs.mixed, range(25), shared=1.0, on_done=lambda: next(done)):
        pass
    assert next(done) == 25


def test_progress_is_the_clusters_and_not_that_of_the_results_taken(executor: DaskExecutor) -> None:
    done: list[float] = []
    results = executor.map(
        jobs.mixed, range(6), shared=1.0, on_done=lambda: done.append(time.monotonic())
    )
    next(results)
    until = time.monotonic() + 30
    while len(done) < 6:  # nobody takes them
        assert time.monotonic() < until
        time.sleep(0.01)
    results.close()  # type: ignore[attr-defined]


def test_items_are_drawn_only_a_few_ahead(executor: DaskExecutor) -> None:
    drawn = 0

    def endless() -> Iterator[int]:
        nonlocal drawn
        while True:
            drawn += 1
            yield drawn

    results = executor.map(jobs.slowest, endless())
    assert [next(results) for _ in range(5)] == [1, 2, 3, 4, 5]
    assert drawn <= 5 + 3 * 2


def test_items_that_take_no_time_share_tasks(executor: DaskExecutor, client: Any) -> None:
    def done(dask_scheduler: Any) -> int:
        return sum(
            prefix.state_counts["memory"] for prefix in dask_scheduler.task_prefixes.values()
        )

    before = client.run_on_scheduler(done)
    results = list(executor.map(jobs.echo, range(3000), shared=2))
    assert results == [2] * 3000
    assert client.run_on_scheduler(done) - before < 300


@pytest.mark.parametrize(
    ("how", "kind", "words"),
    [
        ("setting", SettingError, "^item 3 is bad$"),
        ("pattern", PatternError, "^line 7 of the table is empty$"),
        ("zero", ZeroDivisionError, "integer"),
        ("odd", RuntimeError, "^Unportable: gone at 3$"),
    ],
)
def test_an_error_is_raised_in_its_place(
    executor: DaskExecutor, client: Any, how: str, kind: type[Exception], words: str
) -> None:
    results = executor.map(jobs.failing, range(40), shared=how)
    assert [next(results) for _ in range(3)] == [0, 1, 2]
    with pytest.raises(kind, match=words) as caught:
        next(results)
    assert type(caught.value) is kind
    assert list(results) == []
    wait_until_forgotten(client, "rovernav-failing")  # those in flight were taken back


def test_nothing_is_left_on_the_cluster(executor: DaskExecutor, client: Any) -> None:
    list(executor.map(jobs.mixed, range(10), shared=2.5))
    assert [name for name in tasks(client) if "shared" in name]
    executor.forget()
    wait_until_forgotten(client, "rovernav")


def test_a_map_that_nobody_finishes_is_taken_back(executor: DaskExecutor, client: Any) -> None:
    results = executor.map(jobs.slow, range(1000), shared=np.ones(3))
    next(results)
    del results
    wait_until_forgotten(client, "rovernav-slow")


# Shared values


def opened(results: list[tuple[int, dict[str, int]]], name: str) -> dict[int, int]:
    """How often each process has opened the value of that name."""
    most: dict[int, int] = {}
    for pid, counts in results:
        most[pid] = max(most.get(pid, 0), counts.get(name, 0))
    return most


def test_a_shared_value_is_packed_once_and_opened_once_by_each_worker(
    executor: DaskExecutor,
) -> None:
    ground = jobs.Ground(heights=np.zeros((500, 500)), counted=jobs.Counted("ground"))
    before = jobs.Counted.packed
    results = until_both_have_worked(executor, ground)
    results += executor.map(jobs.whose, range(50), shared=ground)
    assert jobs.Counted.packed == before + 1
    counts = opened(results, "ground")
    assert len(counts) == 2
    assert set(counts.values()) == {1}


def test_equal_content_is_not_sent_again_and_changed_content_is(executor: DaskExecutor) -> None:
    array = np.zeros(1000)
    first = list(executor.map(jobs.whose, range(20), shared=(array, jobs.Counted("same"))))
    again = list(executor.map(jobs.whose, range(20), shared=(array.copy(), jobs.Counted("same"))))
    assert set(opened(first + again, "same").values()) == {1}
    array[7] = 1.0  # an array can change, so it is looked at each time
    results = executor.map(jobs.slow, range(10), shared=array)
    assert list(results) == [i + float(i == 7) for i in range(10)]
    array[7] = 2.0
    assert list(executor.map(jobs.slow, [7], shared=array)) == [9.0]


def test_the_parts_of_a_tuple_travel_by_themselves(executor: DaskExecutor) -> None:
    world = jobs.Ground(heights=np.zeros(10), counted=jobs.Counted("world"))
    results: list[Any] = []
    for number in range(3):  # as for one controller after another
        shared = (world, jobs.Counted("weights", number))
        results += executor.map(jobs.whose, range(12), shared=shared)
    assert set(opened(results, "world").values()) == {1}
    assert set(opened(results, "weights").values()) == {3}


def test_arrays_arrive_aligned_and_as_writable_as_they_were(executor: DaskExecutor) -> None:
    free, frozen = np.zeros(5), np.zeros(7)
    frozen.flags.writeable = False
    assert list(executor.map(jobs.flagged, [0], shared=(free, frozen))) == [(True, False, True)]
    shared: Any = {"a": 1}, [2], 3, None, "five"  # more parts than travel by themselves
    assert list(executor.map(jobs.echo, [0], shared=shared)) == [shared]


def test_kernels_get_one_thread(executor: DaskExecutor) -> None:
    assert list(executor.map(jobs.threads, range(2))) == [1, 1]


# Workers that do not fit


def test_a_worker_with_other_sources_does_nothing(
    executor: DaskExecutor, monkeypatch: pytest.MonkeyPatch
) -> None:
    from rovernav.adapters import _dask, _work

    ours = {**_work.fingerprint(), "numba": "0.0.1"}
    monkeypatch.setattr(_dask, "own_mark", lambda: "another")
    monkeypatch.setattr(_dask, "fingerprint", lambda: ours)
    words = r"^a worker has numba [\d.]+, this machine has 0.0.1; results could differ, so install"
    with pytest.raises(WorkerError, match=words):
        list(executor.map(jobs.mixed, range(3), shared=1.0))
    monkeypatch.setattr(_dask, "fingerprint", lambda: {**_work.fingerprint()})
    with pytest.raises(WorkerError, match="a worker has another rovernav than this machine"):
        list(executor.map(jobs.mixed, range(3), shared=1.0))


def test_another_processor_is_worth_a_note(
    executor: DaskExecutor, monkeypatch: pytest.MonkeyPatch
) -> None:
    from rovernav.adapters import _dask

    list(executor.map(jobs.mixed, range(4), shared=1.0))
    assert executor.notes == []
    monkeypatch.setattr(_dask, "processor", lambda: "m68k")
    list(executor.map(jobs.mixed, range(4), shared=1.0))
    (note,) = executor.notes
    assert "than this machine (m68k); results may differ from this machine's in their" in note


def test_a_job_that_workers_cannot_import(executor: DaskExecutor) -> None:
    import sys
    import types

    module = types.ModuleType("only_here")
    exec("def job(shared, item): return item", module.__dict__)
    sys.modules["only_here"] = module
    try:
        with pytest.raises(WorkerError, match="cannot open its work: No module named 'only_here'"):
            list(executor.map(module.job, range(3)))
    finally:
        del sys.modules["only_here"]


def test_what_is_defined_on_the_spot_travels_too(executor: DaskExecutor) -> None:
    scale = 3
    results = executor.map(lambda shared, item: shared + scale * item, range(4), shared=1)
    assert list(results) == [1, 4, 7, 10]


# Deaths


@pytest.mark.long
def test_the_worker_that_holds_the_shared_value_is_killed(
    executor: DaskExecutor, client: Any
) -> None:
    shared = np.arange(40) / 7
    results = executor.map(jobs.slow, range(40), shared=shared)
    found = [next(results) for _ in range(4)]
    holders = client.who_has()
    (name,) = [key for key in holders if "rovernav-shared" in str(key)]
    kill(pids(client)[holders[name][0]])
    found += results
    assert found == list(Serial().map(jobs.slow, range(40), shared=shared))


@pytest.mark.long
def test_all_workers_killed_at_once_lose_nothing(executor: DaskExecutor, client: Any) -> None:
    shared = np.arange(12) / 7  # every copy dies with them
    results = executor.map(jobs.slow, range(12), shared=shared)
    found = [next(results) for _ in range(2)]
    for pid in pids(client).values():
        kill(pid)
    found += results
    assert found == [shared[i] + i for i in range(12)]


@pytest.mark.long
def test_an_item_that_ends_its_workers_is_given_up(executor: DaskExecutor, client: Any) -> None:
    def allow(failures: int) -> None:
        def change(dask_scheduler: Any) -> None:
            dask_scheduler.allowed_failures = failures

        client.run_on_scheduler(change)

    allow(1)
    try:
        words = r"^item 2 was given up: 2 workers ended, one after another, while they had it"
        with pytest.raises(WorkerError, match=words):
            list(executor.map(jobs.deadly, [0, 1]))
    finally:
        allow(3)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(3))
def test_kills_at_random_moments_lose_nothing(
    executor: DaskExecutor, client: Any, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    shared = np.arange(400) / 7
    results = executor.map(jobs.slow, range(400), shared=shared)
    found: list[float] = []
    kills = 0
    again = time.monotonic() + rng.uniform(0.0, 2.0)
    for result in results:
        found.append(result)
        if time.monotonic() > again:
            alive = sorted(pids(client).values())
            if alive:
                kill(alive[rng.integers(len(alive))])
                kills += 1
            again = time.monotonic() + rng.uniform(1.0, 5.0)
    assert kills >= 4
    assert found == [shared[i] + i for i in range(400)]


def kill(pid: int) -> None:
    import os
    import signal

    os.kill(pid, signal.SIGKILL)
