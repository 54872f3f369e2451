"""The parent's end of a worker: start it, ask it for samples, end it."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from .ccode import BUILD, HOME
from .machine import busy, load, others
from .model import Peer, Workload

THREADS = (
    *("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"),
    *("VECLIB_MAXIMUM_THREADS", "RAYON_NUM_THREADS"),
)
Sample = dict[str, Any]


class Worker:
    """One peer, in one process for all its samples."""

    def __init__(self, workload: Workload, peer: Peer, size: int, seconds: float) -> None:
        self.samples: list[Sample] = []
        self._process = _start(workload, peer, size, seconds, environment())
        ready = _answer(self._process)
        self.skipped: str = ready.get("skipped", "")

    def measure(self) -> None:
        """Take one sample."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.write("go\n")
            self._process.stdin.flush()
            answer = _answer(self._process)
        except BrokenPipeError:
            answer = _answer(self._process)
        self.skipped = answer.get("skipped", "")
        if not self.skipped:
            self.samples.append(answer)

    def close(self) -> None:
        """Let the process end."""
        _end(self._process)


class FreshStarts:
    """One peer, a new process for every sample, timed from its start to its first result."""

    def __init__(self, workload: Workload, peer: Peer, size: int, seconds: float) -> None:
        del seconds
        self.samples: list[Sample] = []
        self.skipped = ""
        self._what = (workload, peer, size)
        if peer.cache != "empty":
            self._run()  # fills the kernel cache, and the system's file cache

    def measure(self) -> None:
        """Take one sample."""
        answer = self._run()
        if not self.skipped:
            self.samples.append(answer)

    def close(self) -> None:
        """Nothing is running."""

    def _run(self) -> Sample:
        workload, peer, size = self._what
        with tempfile.TemporaryDirectory() as empty:
            cache = {"warm": BUILD / "kernel-cache", "empty": Path(empty)}.get(peer.cache)
            busy_before, began = busy(), time.perf_counter()
            process = _start(workload, peer, size, 0.0, environment(cache))
            answer = _answer(process)
            wall = time.perf_counter() - began
            busy_after = busy()
            _end(process)
        self.skipped = answer.get("skipped", "")
        if self.skipped:
            return answer
        foreign = others(busy_before, busy_after, answer["cpu"], wall)
        fresh: Sample = {"wall": wall, "units": 1, "others": foreign, "load": load(), "fresh": True}
        return {**answer, **fresh}


def environment(cache: Path | None = None) -> dict[str, str]:
    """The variables of a worker: one thread, this checkout, the wanted kernel cache."""
    paths = [str(HOME), str(HOME.parent / "src")]
    variables = {**os.environ, "PYTHONPATH": os.pathsep.join(paths), "KERAS_BACKEND": "jax"}
    variables.update(dict.fromkeys(THREADS, "1"))
    variables.update(JAX_PLATFORMS="cpu", CUDA_VISIBLE_DEVICES="")
    variables.pop("PYTHONDONTWRITEBYTECODE", None)  # a warm start has its bytecode at hand
    variables["PYTHONPYCACHEPREFIX"] = str(BUILD / "bytecode")
    if cache is not None:
        variables["ROVERNAV_CACHE_DIR"] = str(cache)
    return variables


def _start(
    workload: Workload, peer: Peer, size: int, seconds: float, variables: dict[str, str]
) -> subprocess.Popen[str]:
    BUILD.mkdir(exist_ok=True)
    arguments = (workload.name, peer.name, str(size), str(seconds))
    with (BUILD / "workers.log").open("a") as log:
        return subprocess.Popen(
            [sys.executable, "-m", "harness.worker", *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=log,
            text=True,
            env=variables,
            cwd=HOME,
        )


def _answer(process: subprocess.Popen[str]) -> Sample:
    assert process.stdout is not None
    line = process.stdout.readline()
    return json.loads(line) if line else {"skipped": f"its process ended with {process.wait()}"}


def _end(process: subprocess.Popen[str]) -> None:
    assert process.stdin is not None
    assert process.stdout is not None
    with contextlib.suppress(BrokenPipeError):
        process.stdin.close()
    process.wait()
    process.stdout.close()
