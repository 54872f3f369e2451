"""Small drives to test with."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any, final

import numpy as np

from rovernav.core import Command, Controller, Mission, Observation
from rovernav.sim import Drive, TwoAxis, Worlds


@final
class Always:
    """Commands the same twist, or one for each rover, whatever it sees."""

    def __init__(self, *twist: Any) -> None:
        self.twist = np.array(twist, dtype=float)

    def start(self, mission: Mission, rng: np.random.Generator) -> None:
        return

    def act(self, observation: Observation, memory: None) -> tuple[Command, None]:
        return Command(twist=np.broadcast_to(self.twist, (len(observation.goal), 3)).copy()), None


@final
class Mirrored:
    """Drives as another controller would in the mirrored world."""

    def __init__(self, other: Controller) -> None:
        self.other = other

    def start(self, mission: Mission, rng: np.random.Generator) -> Any:
        return self.other.start(mission, rng)

    def act(self, observation: Observation, memory: Any) -> tuple[Command, Any]:
        seen = dataclasses.replace(observation, goal=observation.goal * (1, -1))
        command, after = self.other.act(seen, memory)
        return Command(twist=command.twist * (1, -1, -1)), after


def mission(starts: Any, goal: Sequence[float], *, radius: float = 0.1, limit: float) -> Mission:
    """Rovers with these starts (x, y, heading) and one goal."""
    start = np.array(starts, dtype=float).reshape(-1, 3)
    goals = np.tile(np.array(goal, dtype=float), (len(start), 1))
    return Mission(start=start, goal=goals, goal_radius=radius, time_limit=limit)


def drive(
    controller: Controller,
    *boxes: Sequence[float],
    starts: Sequence[Sequence[float]] = ((0.0, 0.0, 0.0),),
    goal: Sequence[float] = (10.0, 0.0),
    limit: float = 50.0,
    period: float = 1.0,
    **more: Any,
) -> Drive:
    """Rovers on two axes in one world of 20 m to each side, without sensors."""
    worlds = Worlds.single(boxes, bounds=(-20, -20, 20, 20), rovers=len(starts))
    parts: dict[str, Any] = {
        "worlds": worlds,
        "mission": mission(starts, goal, limit=limit),
        "sensors": (),
        "controller": controller,
        "motion": TwoAxis(period),
    }
    return Drive(**{**parts, **more})
