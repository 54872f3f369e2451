"""Reaching a Dask cluster: its address, its answer, its versions, and silence about it all."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import re
import time
import warnings
from collections.abc import Generator, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from ..core import MissingExtraError, SettingError, WorkerError, cores
from ..core.executors import undisturbed
from ._dask import DaskExecutor

LOCAL = "local"
TIMEOUT = 10.0
"""How long a cluster may take to answer [s]."""
START_TIMEOUT = 60.0
"""How long workers of this machine may take to start [s]: they load Python and its packages."""
_ADDRESS = re.compile(r"(tcp|tls)://(\[[0-9a-fA-F:.]+\]|[^\s:/\[\]@]+):(\d{1,5})")
_EVERYWHERE = ("rovernav", "distributed")
_ON_WORKERS = (*_EVERYWHERE, "numpy", "numba", "llvmlite")
_LOGGERS = ("distributed", "tornado", "asyncio", "bokeh")
Versions = Mapping[str, str | None]


@contextlib.contextmanager
def open_executor(
    address: str, *, workers: int | None = None, timeout: float = TIMEOUT
) -> Generator[DaskExecutor]:
    """An executor on a cluster that runs already, or on one made for the occasion.

    Args:
        address: Of the scheduler, ``tcp://HOST:PORT`` (or ``tls://`` with Dask's own settings), or
            ``local``: a scheduler and workers on this machine, which end with the executor. They
            listen on 127.0.0.1 only, but to whoever has an account here.
        workers: Processes of a ``local`` cluster; all processors where not given.
        timeout: How long the cluster may take to answer and to show a worker [s].

    Raises:
        MissingExtraError: The extra ``cluster`` is not installed.
        SettingError: An address or number that cannot be one.
        WorkerError: Nobody answers in time, there is no worker, or versions differ.
    """
    need_extra()
    if not 0.0 < timeout <= 86_400.0:
        raise SettingError(f"a cluster may take from 0 to 86400 s to answer, got {timeout:g}")
    if address != LOCAL and workers is not None:
        raise SettingError("a cluster has workers of its own; give their number only for 'local'")
    with contextlib.ExitStack() as stack:
        stack.enter_context(_silence())
        if address == LOCAL:
            cluster = stack.enter_context(_local_cluster(cores() if workers is None else workers))
            client = connect(cluster.scheduler_address, timeout=max(timeout, START_TIMEOUT))
        else:
            client = connect(address, timeout=timeout)
        stack.callback(_close, client)
        executor = DaskExecutor(client)
        stack.callback(executor.forget)
        yield executor


def connect(address: str, *, timeout: float = TIMEOUT) -> Any:
    """A ``distributed.Client`` of a running cluster, which has workers and fits this machine.

    Args:
        address: Of the scheduler: ``tcp://HOST:PORT`` or ``tls://HOST:PORT``.
        timeout: How long it may take [s].

    Raises:
        MissingExtraError: The extra ``cluster`` is not installed.
        SettingError: Not an address.
        WorkerError: Nobody answers in time, there is no worker, or versions differ.
    """
    need_extra()
    _check_address(address)
    until = time.monotonic() + timeout
    try:
        client = _client(address, timeout, until)
    except Exception as error:
        raise WorkerError(
            f"no Dask scheduler answers at {address} within {timeout:g} s ({_reason(error)}); "
            "start one with 'dask scheduler', or check the address"
        ) from None
    try:
        _need_workers(client, address, timeout, until)
        _compare(*_reported(client, max(1.0, until - time.monotonic())))
    except BaseException:
        _close(client)
        raise
    return client


def _client(address: str, timeout: float, until: float) -> Any:
    """A client; any error means that no scheduler is there."""
    from distributed import Client

    _greet(address, timeout)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # versions are compared afterwards, in our words
        left = max(1.0, until - time.monotonic())
        return Client(address, timeout=left, set_as_default=False, name="rovernav")


def _greet(address: str, timeout: float) -> None:
    """Ask a scheduler who it is; a client would wait for ever for a stranger that says nothing."""
    from distributed import Security
    from distributed.core import rpc

    async def ask() -> None:
        arguments = Security().get_connection_args("client")
        there: Any = rpc(address, connection_args=arguments, timeout=timeout)
        try:
            who = await asyncio.wait_for(there.identity(n_workers=0), timeout)
        finally:
            await there.close_rpc()
        if who.get("type") != "Scheduler":
            raise OSError(f"a Dask {who.get('type')} is there")

    with ThreadPoolExecutor(1) as pool:  # this thread may have a loop of its own
        pool.submit(asyncio.run, ask()).result()


def need_extra() -> None:
    """Raise `MissingExtraError` unless the extra ``cluster`` is installed."""
    try:
        import distributed  # noqa: F401  # pyright: ignore[reportUnusedImport]
    except ImportError:
        raise MissingExtraError(
            "clusters need the extra 'cluster'; install it with: pip install 'rovernav[cluster]'"
        ) from None


def _check_address(address: str) -> None:
    found = _ADDRESS.fullmatch(address)
    if not found or not 1 <= int(found[3]) <= 65_535:
        raise SettingError(
            f"a cluster's address is written tcp://HOST:PORT, like tcp://10.0.0.5:8786, or is "
            f"'local', got {address!r}"
        )


def _need_workers(client: Any, address: str, timeout: float, until: float) -> None:
    try:
        client.wait_for_workers(1, timeout=max(0.5, until - time.monotonic()))
    except Exception as error:
        if isinstance(error, TimeoutError):
            raise WorkerError(
                f"the cluster at {address} has no worker after {timeout:g} s; start one with "
                f"'dask worker {address}', or wait longer for it"
            ) from None
        raise WorkerError(f"the cluster at {address} went away: {_reason(error)}") from None


def _reported(client: Any, timeout: float) -> tuple[Versions, Versions, dict[str, Versions]]:
    """The versions that this process, the scheduler and each worker say they have."""
    from distributed.versions import get_versions

    names = [*_ON_WORKERS]

    async def ask() -> tuple[Any, Any]:
        scheduler = await client.scheduler.versions(packages=names)
        message = {"op": "versions", "packages": names}
        return scheduler, await client.scheduler.broadcast(msg=message, on_error="ignore")

    try:
        scheduler, workers = client.sync(ask, callback_timeout=timeout)
    except Exception as error:
        raise WorkerError(f"the cluster does not tell its versions: {_reason(error)}") from None
    return (
        get_versions(packages=names)["packages"],
        scheduler["packages"],
        {name: one["packages"] for name, one in workers.items()},
    )


def _compare(ours: Versions, scheduler: Versions, workers: Mapping[str, Versions]) -> None:
    """Raise `WorkerError` at the first version that is not ours."""
    machines = [("the scheduler", scheduler, _EVERYWHERE)]
    machines += [(f"the worker {name}", one, _ON_WORKERS) for name, one in workers.items()]
    for who, theirs, packages in machines:
        pairs = [("Python", _minor(theirs), _minor(ours))]
        pairs += [(name, theirs.get(name), ours.get(name)) for name in packages]
        for name, got, wanted in pairs:
            if got is None:
                raise WorkerError(f"{who} has no {name}; install {name} {wanted} there")
            if got != wanted:
                raise WorkerError(
                    f"{who} has {name} {got}, this machine has {wanted}; "
                    "results could differ, so install the same on all"
                )


def _minor(versions: Versions) -> str:
    """3.11 of a Python 3.11.9."""
    return ".".join((versions.get("python") or "?").split(".")[:2])


@contextlib.contextmanager
def _local_cluster(workers: int) -> Generator[Any]:
    """A scheduler in this process and workers in processes of their own, on 127.0.0.1."""
    if workers < 1:
        raise SettingError(f"workers must be 1 or more, got {workers}")
    import distributed
    from dask.config import set as configured

    start: Any = distributed.LocalCluster
    settings = {
        "distributed.scheduler.active-memory-manager.start": False,  # it would drop copies
        "distributed.scheduler.http.routes": [],
        "distributed.worker.http.routes": [],
    }
    nowhere = "127.0.0.1:0"  # any port that is free: two of these may run side by side
    with configured(settings), undisturbed(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        cluster = start(
            n_workers=workers,
            threads_per_worker=1,
            host="127.0.0.1",
            dashboard_address=nowhere,
            worker_dashboard_address=nowhere,
            scheduler_kwargs={"dashboard": False},
            memory_limit=0,  # as much as worker processes without Dask
            silence_logs=logging.CRITICAL,
            env={"NUMBA_NUM_THREADS": "1"},
        )
    try:
        yield cluster
    finally:
        with contextlib.suppress(Exception):
            cluster.close(timeout=5)


@contextlib.contextmanager
def _silence() -> Generator[None]:
    """Dask's log says again, at length, what our errors say."""
    names = [name for name in logging.root.manager.loggerDict if name.split(".")[0] in _LOGGERS]
    before = [(logger := logging.getLogger(name), logger.level) for name in {*names, *_LOGGERS}]
    for logger, _ in before:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in before:
            logger.setLevel(level)


def _close(client: Any) -> None:
    with contextlib.suppress(Exception):
        client.close(timeout=2)


def _reason(error: BaseException) -> str:
    """The first words of an error."""
    words = " ".join(str(error).split()) or type(error).__name__
    return words if len(words) <= 120 else f"{words[:117]}..."
