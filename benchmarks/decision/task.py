"""The network that decides, what it is asked, and what it has to answer."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from harness.model import Result, Stopwatch, Trial

HIDDEN = np.array([[0.17, 0.33, 0.1], [0.3, 0.71, 0.21], [0.15, 0.43, 0.69]])
OUT = np.array([[0.11, 0.03, 0.52, 0.41], [0.93, 0.14, 0.79, 0.66]])
"""The paper's initial weights, (units, inputs + 1), bias column last."""
X = np.array([0.0, 1.0])
"""Sight blocked, off the line."""


def parts() -> tuple[Any, Any, Any, Any]:
    """w1 (3, 2), b1 (3,), w2 (2, 3), b2 (2,)."""
    return HIDDEN[:, :2].copy(), HIDDEN[:, 2].copy(), OUT[:, :3].copy(), OUT[:, 3].copy()


def expected() -> Any:
    """What the network answers (2,)."""
    hidden = 1.0 / (1.0 + np.exp(-(HIDDEN @ [*X, 1.0])))
    return OUT @ [*hidden, 1.0]


def calls(size: int, decide: Callable[[], Any], outputs: Callable[[Any], Any]) -> Trial:
    """`size` calls of `decide` in each repetition; `outputs` reads an answer, untimed."""

    def trial(repeats: int) -> Result:
        watch, answer = Stopwatch(), decide()
        with watch:
            for _ in range(repeats * size):
                answer = decide()
        difference = np.abs(np.ravel(outputs(answer)) - expected())
        return watch.result(repeats * size, float(difference.max()))

    return trial
