"""Drivers without a network: a goal seeker, and a planner on what was sensed."""

from __future__ import annotations

from typing import final

import numpy as np

from ..core import F64, Command, Mission, Observation, SettingError
from ..kernels import teaching as kernels
from ..mapping import LocalMap
from ._headings import HeadingCodec


@final
class GoalSeeker:
    """Turns to the goal and drives; stops before what it sees ahead. The baseline.

    Args:
        codec: The motors that the neural driver uses too.
    """

    def __init__(self, codec: HeadingCodec | None = None) -> None:
        self.codec = codec or HeadingCodec()

    def start(self, mission: Mission, rng: np.random.Generator) -> None:
        """Nothing to remember."""
        return

    def act(self, observation: Observation, memory: None) -> tuple[Command, None]:
        """Always the heading of the goal."""
        logits = np.zeros((len(observation.goal), self.codec.headings))
        logits[:, 0] = 1e6  # no commitment outweighs the goal
        return self.codec.decode(logits, observation), None


@final
class SensedPlanner:
    """Plans anew at every step on the map of what was sensed: unknown ground is free.

    The teacher of the neural driver. It knows exactly what the student has sensed and no more.

    Args:
        codec: The motors and the number of headings.
        ahead: How far along a heading it looks before it asks for the cost to go [cells].
        shy: Extra cost per cell beside something.
        turn: Cost of turning away from the present heading [cells/rad].
        softness: Difference in cost that makes a heading e times less likely [cells].
    """

    def __init__(
        self,
        codec: HeadingCodec | None = None,
        *,
        ahead: float = 4.0,
        shy: float = 1.0,
        turn: float = 0.5,
        softness: float = 0.25,
    ) -> None:
        self.codec = codec or HeadingCodec()
        self._weights = (ahead, shy, turn, softness)

    def start(self, mission: Mission, rng: np.random.Generator) -> None:
        """Nothing to remember: the map remembers."""
        return

    def headings(self, local: LocalMap) -> F64:
        """Distribution over headings (n, headings): heading 0 points at the goal, rows sum to 1."""
        out = np.empty((len(local.pose), self.codec.headings))
        settings = kernels.TeacherSettings(local.cell, *self._weights)
        kernels.label(local.cells, local.centre, local.pose, local.goal, settings, out)
        return out

    def act(self, observation: Observation, memory: None) -> tuple[Command, None]:
        """The likeliest heading."""
        if not isinstance(observation.map, LocalMap):
            raise SettingError("the planner on sensed ground needs a rover with a local map")
        logits = np.log(np.maximum(self.headings(observation.map), 1e-30))
        return self.codec.decode(logits, observation), None
