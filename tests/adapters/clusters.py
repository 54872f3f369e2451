"""Real clusters for tests: a scheduler and workers with nannies, each a process, on loopback."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Generator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
START = 120.0
"""How long a loaded machine may take to start a process [s]."""


class Cluster:
    """One scheduler and some workers; `stop` leaves no process behind."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._processes: list[subprocess.Popen[bytes]] = []
        file = folder / "scheduler.json"
        words = ("--port", "0", "--scheduler-file", str(file), "--idle-timeout", "300")
        self.scheduler = self._start("scheduler", *words)
        until = time.monotonic() + START
        while True:
            with contextlib.suppress(OSError, ValueError):  # not there, or half written
                self.address = str(json.loads(file.read_text())["address"])
                break
            assert self.scheduler.poll() is None, self.log()
            assert time.monotonic() < until, self.log()
            time.sleep(0.02)

    def add_worker(self) -> subprocess.Popen[bytes]:
        """A nanny with one worker of one thread."""
        words = ("--nworkers", "1", "--nthreads", "1", "--memory-limit", "0")
        words += ("--death-timeout", "120")  # where the tests themselves are killed
        return self._start("worker", self.address, *words, "--local-directory", str(self.folder))

    def stop(self) -> None:
        for process in reversed(self._processes):
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()

    def log(self) -> str:
        return "\n".join(path.read_text() for path in self.folder.glob("*.log"))

    def _start(self, what: str, *words: str) -> subprocess.Popen[bytes]:
        path = os.pathsep.join([str(ROOT / "src"), str(ROOT), os.environ.get("PYTHONPATH", "")])
        environment = os.environ | {
            "PYTHONPATH": path,
            # It drops copies that nobody needs at the moment, which tests count.
            "DASK_DISTRIBUTED__SCHEDULER__ACTIVE_MEMORY_MANAGER__START": "False",
        }
        log = self.folder / f"{len(self._processes)}-{what}.log"
        with log.open("wb") as out:
            process = subprocess.Popen(
                [sys.executable, "-m", f"distributed.cli.dask_{what}", *words,
                 "--host", "127.0.0.1", "--no-dashboard"],
                cwd=self.folder, env=environment, stdout=out, stderr=out, start_new_session=True,
            )  # fmt: skip
        self._processes.append(process)
        return process


@contextlib.contextmanager
def running(folder: Path, workers: int) -> Generator[Cluster]:
    """A cluster for as long as the block lasts."""
    cluster = Cluster(folder)
    try:
        for _ in range(workers):
            cluster.add_worker()
        yield cluster
    finally:
        cluster.stop()


def wait_for_workers(client: Any, count: int) -> None:
    """Until exactly so many workers are there."""
    until = time.monotonic() + START
    while len(client.nthreads()) != count:
        assert time.monotonic() < until, f"{client.nthreads()} after {START} s"
        time.sleep(0.05)


def pids(client: Any) -> dict[str, int]:
    """The process of each worker; not its nanny's."""
    found: dict[str, int] = client.run(os.getpid, on_error="ignore")
    return found
