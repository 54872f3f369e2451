"""Made-up observations for controllers."""

from __future__ import annotations

from typing import Any

import numpy as np

from rovernav.core import Mission, Observation
from rovernav.mapping import LocalMapper

NAMES = ("clear_sight", "off_line")


def bassil(n: int, rng: np.random.Generator) -> Observation:
    """What the paper's two sensors might say; some goals lie within a step."""
    channels = {name: rng.integers(0, 2, (n, 1)).astype(float) for name in NAMES}
    return Observation(
        goal=rng.normal(0.0, 1.5, (n, 2)),
        twist=rng.normal(size=(n, 3)),
        channels=channels,
    )


FAN = np.linspace(-np.pi / 2, np.pi / 2, 49)


def scanned(n: int, rng: np.random.Generator) -> Observation:
    """What a fan of beams might see at some place, and the local map of it."""
    pose = rng.uniform((0, 0, -3), (30, 30, 3), (n, 3))
    goal = rng.uniform(0, 30, (n, 2))
    away, heading = goal - pose[:, :2], pose[:, 2]
    c, s = np.cos(heading), np.sin(heading)
    mission = Mission(start=pose, goal=goal, goal_radius=0.1, time_limit=9.0)
    mapper = LocalMapper(FAN, reach=12.0)
    channels = {"beams": rng.uniform(0.5, 12.5, (n, 49))}
    more, local = mapper.update(mapper.start(mission), pose, goal, channels)
    return Observation(
        goal=np.stack([c * away[:, 0] + s * away[:, 1], c * away[:, 1] - s * away[:, 0]], axis=1),
        twist=np.zeros((n, 3)),
        channels={**channels, **more},
        map=local,
    )


def one(sight: float, off_line: float, goal: Any = (5.0, 0.0)) -> Observation:
    """What one rover sees."""
    return Observation(
        goal=np.array([goal], dtype=float),
        twist=np.zeros((1, 3)),
        channels={"clear_sight": np.array([[sight]]), "off_line": np.array([[off_line]])},
    )
