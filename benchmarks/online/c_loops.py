"""C: loops over any sizes, loops over fixed sizes, and the FANN library."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
from harness.ccode import c_function, pointer
from harness.model import Result, Skipped, Stopwatch, Trial

from . import task

SHAPE = np.array([[2, 3, 1], [3, 2, 0]], dtype=np.int_)
"""Inputs, units, activation of each layer, as generic.c reads them."""


def generic(epochs: int) -> Trial:
    """Sizes, depth and activations known at run time; libm's exp."""
    return _generic(epochs, rule=0)


def generic_paper(epochs: int) -> Trial:
    """The same with the paper's rule."""
    return _generic(epochs, rule=1)


def frozen(epochs: int) -> Trial:
    """Sizes and activations known to the compiler; libm's exp."""
    return _build(epochs, c_function("frozen"))


def fann(epochs: int) -> Trial:
    """The FANN library in double precision, `fann_train_epoch` in incremental mode.

    It keeps a sigmoid's output between 0.01 and 0.99 when it takes the slope, so it ends with
    an error that differs in the sixth digit.
    """
    needs = "FANN's header is not installed (on Debian: apt-get install libfann-dev)"
    return _build(epochs, c_function("fann", "-ldoublefann", advice=needs))


def _generic(epochs: int, *, rule: int) -> Trial:
    return _build(epochs, c_function("generic"), pointer(SHAPE), len(SHAPE), rule=(rule,))


def _build(epochs: int, train: Any, *shape: Any, rule: tuple[int, ...] = ()) -> Trial:
    start, end, x, y = task.start(), np.zeros(17), task.X.copy(), task.Y.copy()

    def trial(repeats: int) -> Result:
        watch = Stopwatch()
        with watch:
            failed = train(
                *(ctypes.c_long(n) if isinstance(n, int) else n for n in shape),
                *(pointer(array) for array in (start, end, x, y)),
                *(ctypes.c_long(n) for n in (task.PATTERNS, epochs, repeats)),
                *(ctypes.c_double(n) for n in (task.ETA, task.MOMENTUM)),
                *(ctypes.c_long(n) for n in rule),
            )
        if failed:
            raise Skipped("the C code could not build the network")
        return watch.result(repeats * epochs * task.PATTERNS, task.flat_rmse(end))

    return trial
