"""Made-up observations for controllers."""

from __future__ import annotations

from typing import Any

import numpy as np

from rovernav.core import Observation

NAMES = ("clear_sight", "off_line")


def bassil(n: int, rng: np.random.Generator) -> Observation:
    """What the paper's two sensors might say; some goals lie within a step."""
    channels = {name: rng.integers(0, 2, (n, 1)).astype(float) for name in NAMES}
    return Observation(
        goal=rng.normal(0.0, 1.5, (n, 2)),
        twist=rng.normal(size=(n, 3)),
        channels=channels,
    )


def one(sight: float, off_line: float, goal: Any = (5.0, 0.0)) -> Observation:
    """What one rover sees."""
    return Observation(
        goal=np.array([goal], dtype=float),
        twist=np.zeros((1, 3)),
        channels={"clear_sight": np.array([[sight]]), "off_line": np.array([[off_line]])},
    )
