"""C: eight networks side by side, one network after the other, and the FANN library."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
from harness.ccode import c_function, pointer
from harness.model import Result, Skipped, Stopwatch, Trial

from . import task

RATES = (ctypes.c_double(task.ETA), ctypes.c_double(task.MOMENTUM))


def lanes(epochs: int) -> Trial:
    """Loops whose last axis is the network, vectorised by gcc; an exponential of its own."""
    function, start, end = c_function("lanes"), task.start(), np.zeros((task.NETWORKS, 17))
    numbers = [ctypes.c_long(n) for n in (task.NETWORKS, task.PATTERNS, epochs)]

    def once() -> int:
        return function(
            pointer(start), pointer(end), pointer(task.X), pointer(task.Y), *numbers, *RATES
        )

    return _trial(epochs, once, end)


def one_by_one(epochs: int) -> Trial:
    """All sizes known to the compiler, one network after the other; libm's exp."""
    return _each(epochs, c_function("frozen"))


def fann(epochs: int) -> Trial:
    """The FANN library in double precision; see the workload `online` for its sigmoid."""
    needs = "FANN's header is not installed (on Debian: apt-get install libfann-dev)"
    return _each(epochs, c_function("fann", "-ldoublefann", advice=needs))


def _each(epochs: int, function: Any) -> Trial:
    start, end = task.start(), np.zeros((task.NETWORKS, 17))
    numbers = [ctypes.c_long(n) for n in (task.PATTERNS, epochs, 1)]
    table = (pointer(task.X), pointer(task.Y))
    rows = [(pointer(a), pointer(b)) for a, b in zip(start, end, strict=True)]

    def once() -> int:
        return sum(function(*row, *table, *numbers, *RATES) for row in rows)

    return _trial(epochs, once, end)


def _trial(epochs: int, once: Any, end: Any) -> Trial:
    def trial(repeats: int) -> Result:
        watch = Stopwatch()
        with watch:
            failed = sum(once() for _ in range(repeats))
        if failed:
            raise Skipped("the C code could not build the networks")
        return watch.result(repeats * epochs * task.PATTERNS * task.NETWORKS, task.flat_rmse(end))

    return trial
