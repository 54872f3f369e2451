"""Small drives, and pictures read back."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from rovernav.core import Mission, Outcome
from rovernav.sim import Trace

Points = Sequence[tuple[float, float]]


def drive(points: Points, outcome: Outcome, goal: tuple[float, float] | None = None) -> Trace:
    """One rover through `points`, a step of one second to each."""
    xy = np.array(points, dtype=np.float64)
    steps = len(xy) - 1
    pose = np.zeros((steps + 1, 1, 3))
    pose[:, 0, :2] = xy
    return Trace(
        time=np.arange(steps + 1.0)[:, None],
        pose=pose,
        commands=np.zeros((0, 1, 3)),
        channels={},
        mission=Mission.between(points[0], goal or points[-1], goal_radius=0.5, time_limit=60.0),
        outcome=np.array([outcome], np.int8),
        steps=np.array([steps]),
        length=np.array([np.hypot(*np.diff(xy, axis=0).T).sum()]),
        seed=0,
        settings={},
    )


def pixels(path: Path) -> np.ndarray[Any, Any]:
    """Colours (h, w, 3), 0 to 255, the upper row first."""
    from matplotlib.image import imread

    return np.round(imread(path)[..., :3] * 255).astype(int)


def share(image: np.ndarray[Any, Any], colour: str, within: int = 6) -> float:
    """Share of the pixels that have a colour, nearly."""
    wanted = [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
    return float((np.abs(image - wanted).max(axis=-1) <= within).mean())
