from __future__ import annotations

import contextlib
import logging
import os
import signal
import socket
import sys
import threading
import time
from collections.abc import Generator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from distributed import Client

from rovernav.adapters import DaskExecutor, connect, open_executor
from rovernav.adapters import _cluster as reaching
from rovernav.core import MissingExtraError, SettingError, WorkerError
from tests.adapters import jobs
from tests.adapters.clusters import Cluster, pids, running, wait_for_workers

pytestmark = pytest.mark.xdist_group("cluster")  # one cluster for all


@contextlib.contextmanager
def listening(answer: bytes | None) -> Generator[int]:
    """A port at which somebody listens who is no Dask scheduler."""
    server = socket.create_server(("127.0.0.1", 0))
    held: list[socket.socket] = []

    def serve() -> None:
        with contextlib.suppress(OSError):
            while True:
                held.append(server.accept()[0])
                if answer:
                    held[-1].sendall(answer)

    threading.Thread(target=serve, daemon=True).start()
    try:
        yield server.getsockname()[1]
    finally:
        server.close()
        for one in held:
            one.close()


def unused_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return server.getsockname()[1]


@pytest.mark.parametrize(
    "address",
    ["", "cluster", "localhost:8786", "http://a:1", "tcp://:8786", "tcp://host", "tcp://host:0",
     "tcp://host:65536", "tcp://host:8786/x", "tcp://a b:8786", "tcp://a@b:8786", "Local"],
)  # fmt: skip
def test_what_is_no_address(address: str) -> None:
    with pytest.raises(SettingError, match="a cluster's address is written tcp://HOST:PORT, like"):
        connect(address)
    with pytest.raises(SettingError, match="or is 'local', got"), open_executor(address):
        pass


def test_nobody_there() -> None:
    address, begun = f"tcp://127.0.0.1:{unused_port()}", time.monotonic()
    words = rf"^no Dask scheduler answers at {address} within 1 s \(.*\); start one with"
    with pytest.raises(WorkerError, match=words), open_executor(address, timeout=1.0):
        pass
    assert time.monotonic() < begun + 20.0


@pytest.mark.parametrize("answer", [None, b"HTTP/1.1 400 Bad Request\r\n\r\n"])
def test_somebody_else_is_there(answer: bytes | None) -> None:
    with listening(answer) as port:
        address, begun = f"tcp://127.0.0.1:{port}", time.monotonic()
        with pytest.raises(WorkerError, match=r"no Dask scheduler answers at .* within 1 s"):
            connect(address, timeout=1.0)
        assert time.monotonic() < begun + 20.0


@pytest.mark.parametrize("timeout", [0.0, -1.0, float("nan"), float("inf"), 1e9])
def test_impossible_limits(timeout: float) -> None:
    words = "a cluster may take from 0 to 86400 s to answer"
    with pytest.raises(SettingError, match=words), open_executor("local", timeout=timeout):
        pass


def test_workers_of_another_cluster_cannot_be_chosen() -> None:
    with (
        pytest.raises(SettingError, match="give their number only for 'local'"),
        open_executor("tcp://127.0.0.1:1", workers=2),
    ):
        pass
    with (
        pytest.raises(SettingError, match="workers must be 1 or more, got 0"),
        open_executor("local", workers=0),
    ):
        pass


def test_without_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    words = r"^clusters need the extra 'cluster'; install it with: pip install 'rovernav\[cluster\]"
    with pytest.raises(MissingExtraError, match=words), open_executor("local"):
        pass
    with pytest.raises(MissingExtraError, match=words):
        connect("tcp://127.0.0.1:1")


# Versions: the cluster's real answers, one of them changed


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ((2, "numba", "0.1"), r"^the worker tcp://.* has numba 0.1, this machine has .*; results"),
        ((2, "numpy", "1.26.4"), "has numpy 1.26.4, this machine has"),
        ((2, "rovernav", "0.0.9"), "has rovernav 0.0.9, this machine has"),
        (
            (2, "rovernav", None),
            r"^the worker tcp://.* has no rovernav; install rovernav .* there$",
        ),
        (
            (2, "python", "3.9.1.final.0"),
            r"has Python 3.9, this machine has 3\.\d+; .* the same on",
        ),
        ((1, "distributed", "2024.1"), "^the scheduler has distributed 2024.1, this machine has"),
        ((1, "rovernav", None), "^the scheduler has no rovernav; install"),
        ((1, "numba", None), ""),  # the scheduler computes nothing
        ((2, "python", f"{sys.version_info[0]}.{sys.version_info[1]}.99.final.0"), ""),
    ],
)
def test_versions_that_differ_are_named(
    cluster: Cluster,
    client: Any,
    monkeypatch: pytest.MonkeyPatch,
    change: tuple[int, str, str | None],
    words: str,
) -> None:
    who, package, version = change
    found = reaching._reported(client, 10.0)
    assert len(found[2]) == 2
    machine: Any = list(found[2].values())[-1] if who == 2 else found[who]
    assert machine[package]
    machine[package] = version
    monkeypatch.setattr(reaching, "_reported", lambda _client, _timeout: found)
    if not words:
        connect(cluster.address, timeout=30.0).close()
        return
    with pytest.raises(WorkerError, match=words):
        connect(cluster.address, timeout=30.0)


def test_a_cluster_that_is_handed_in_stays_as_it_is(cluster: Cluster, client: Any) -> None:
    before = pids(client)
    with open_executor(cluster.address, timeout=60.0) as executor:
        assert executor.workers == 2
        assert next(executor.map(jobs.mixed, [1], shared=0.0)).tolist() == [0.0] * 50
    assert pids(client) == before


def test_logs_are_as_loud_afterwards_as_before(cluster: Cluster, client: Any) -> None:
    loggers = [logging.getLogger(name) for name in ("distributed", "distributed.client")]
    before = [logger.level for logger in loggers]
    with open_executor(cluster.address, timeout=60.0):
        assert not any(logger.isEnabledFor(logging.CRITICAL) for logger in loggers)
    assert [logger.level for logger in loggers] == before


# One cluster that is taken apart


@pytest.mark.long
def test_workers_come_leave_and_the_cluster_goes(tmp_path: Path) -> None:
    with running(tmp_path, 0) as cluster:
        words = rf"the cluster at {cluster.address} has no worker after 0.5 s; start one with 'dask"
        with pytest.raises(WorkerError, match=words):
            connect(cluster.address, timeout=0.5)
        with Client(cluster.address, set_as_default=False) as alone:
            numbers = DaskExecutor(alone, patience=0.5).map(jobs.slow, [1], shared=[1.0])
            with pytest.raises(WorkerError, match=r"^the cluster has had no worker for . s; start"):
                list(numbers)

        first = cluster.add_worker()
        client = connect(cluster.address, timeout=120.0)
        executor = DaskExecutor(client)
        shared = (np.arange(80) / 7, jobs.Counted("late"))
        results = executor.map(jobs.whose, range(4000), shared=shared)
        first_pid = next(results)[0]
        assert {next(results)[0] for _ in range(10)} == {first_pid}

        cluster.add_worker()  # one that comes later gets its share, and the shared value
        wait_for_workers(client, 2)
        until = time.monotonic() + 60.0
        while len({next(results)[0] for _ in range(10)}) == 1:
            assert time.monotonic() < until
        results.close()  # type: ignore[attr-defined]

        numbers = executor.map(jobs.slow, range(30), shared=shared[0])
        found = [next(numbers) for _ in range(4)]
        first.send_signal(signal.SIGTERM)  # one leaves as it should, the other is killed
        found += [next(numbers) for _ in range(6)]
        last = [pid for pid in pids(client).values() if pid != first_pid]
        os.kill(last[0], signal.SIGKILL)
        found += numbers
        assert found == [shared[0][i] + i for i in range(30)]

        numbers = executor.map(jobs.slow, range(30), shared=shared[0])
        next(numbers)
        cluster.scheduler.kill()
        with pytest.raises(WorkerError, match=r"^the cluster has gone"):
            list(numbers)
        client.close(timeout=1)
        with pytest.raises(WorkerError, match=r"the connection to the cluster was closed|has gone"):
            list(executor.map(jobs.slow, range(30), shared=shared[0]))


def test_a_local_cluster_ends_with_its_executor() -> None:
    with open_executor("local", workers=2) as executor:
        assert executor.workers == 2
        assert len(executor._client.scheduler_info()["workers"]) == 2
        addresses = list(executor._client.nthreads())
        assert all(address.startswith("tcp://127.0.0.1:") for address in addresses)
        processes = {pid for pid, _ in executor.map(jobs.whose, range(12), shared=1)}
    assert len(processes) == 2
    for pid in processes:
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)
