"""Drivers without a network: a goal seeker, and a planner on what was sensed."""

from __future__ import annotations

from typing import final

import numpy as np

from ..core import F64, Command, Mission, Observation, SettingError
from ..kernels import teaching as kernels
from ..mapping import LocalMap
from ._headings import HeadingCodec
from ._why import Why, side


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
        return self.codec.decode(self._logits(observation), observation), None

    def why(self, observation: Observation, memory: None) -> Why:
        """It only ever wants to go to the goal."""
        command, _ = self.act(observation, memory)
        reading = self.codec.read(self._logits(observation), observation)
        goal, _, *motors = reading.words
        return Why(
            words=(goal, "It always turns to the goal and never looks for a way round.", *motors),
            command=command.twist[0],
            inputs=_goal(observation),
        )

    def _logits(self, observation: Observation) -> F64:
        logits = np.zeros((len(observation.goal), self.codec.headings))
        logits[:, 0] = 1e6  # no commitment outweighs the goal
        return logits


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
        return self.codec.decode(self._logits(observation), observation), None

    def why(self, observation: Observation, memory: None) -> Why:
        """Where its cost to go falls fastest, and how much the straight way to the goal would cost.

        The label of a heading is exp(-cost / softness), so the logarithm of two labels' ratio is
        the difference between the costs.
        """
        logits = self._logits(observation)
        command, _ = self.act(observation, memory)
        reading = self.codec.read(logits, observation)
        softness = self._weights[3]
        best = int(np.argmax(logits[0]))
        angles = self.codec.choice(logits, observation).angles
        words = [
            reading.words[0],
            "It plans on the map of what was sensed so far; what was never seen counts as free.",
            f"The cheapest way on leads {side(float(angles[best]))}.",
        ]
        if best:
            extra = float(logits[0, best] - logits[0, 0]) * softness
            more = f"{extra:.1f} cells more" if extra < 15.0 else "far more, or is blocked"
            words.append(f"Straight at the goal would cost {more}.")
        return Why(
            words=(*words, *reading.words[2:]),
            command=command.twist[0],
            inputs=_goal(observation),
            headings=reading.headings,
        )

    def _logits(self, observation: Observation) -> F64:
        if not isinstance(observation.map, LocalMap):
            raise SettingError("the planner on sensed ground needs a rover with a local map")
        return np.log(np.maximum(self.headings(observation.map), 1e-30))


def _goal(observation: Observation) -> tuple[tuple[str, float, str], ...]:
    """The goal as seen by the first rover, and the nearest thing that its beams met."""
    x, y = observation.goal[0].tolist()
    nearest = float(observation.channel("beams")[0].min())
    return ("goal_forward", x, "m"), ("goal_left", y, "m"), ("nearest_beam", nearest, "m")
