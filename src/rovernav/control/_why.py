"""Why a controller commanded what it commanded: numbers and plain sentences."""

from __future__ import annotations

import math
from typing import Any, Protocol, runtime_checkable

import numpy as np

from ..core import F64, Command, Controller, Memory, Observation, map_arrays, value
from ..nets import Explanation


@value
class Headings:
    """A choice among directions.

    Attributes:
        angles: Each direction seen from the rover, left positive (h,) [rad].
        share: How much the controller favours each, rows of a distribution that sums to 1 (h,).
        chosen: Which one it took.
        angle: The direction that it steers for, between two of them [rad].
    """

    angles: F64
    share: F64
    chosen: int
    angle: float


@value
class Why:
    """What made a controller decide.

    Attributes:
        words: The reasons, a sentence each.
        command: Forward [m/s], left [m/s], turn [rad/s] (3,).
        inputs: Name, number and unit of what it looked at.
        network: The forward pass taken apart, for a network.
        output_names: Names of the network's outputs.
        headings: The directions it chose from, if it did.
    """

    words: tuple[str, ...]
    command: F64
    inputs: tuple[tuple[str, float, str], ...] = ()
    network: Explanation | None = None
    output_names: tuple[str, ...] = ()
    headings: Headings | None = None


@value
class Reading:
    """What a codec made of a network's outputs: sentences, and the directions it chose from."""

    words: tuple[str, ...]
    headings: Headings | None = None


@runtime_checkable
class Explains(Protocol):
    """A controller that can say why."""

    def why(self, observation: Observation, memory: Memory) -> Why:
        """Why it commands what it commands the first rover of the observation."""
        ...


@runtime_checkable
class ReadsOutputs(Protocol):
    """A codec that can say what it makes of a network's outputs."""

    def read(self, outputs: Any, observation: Observation) -> Reading:
        """What the outputs (1, o) mean in this observation of one rover."""
        ...


def explain(
    controller: Controller, observation: Observation, memory: Memory = None, *, k: int = 0
) -> Why:
    """Why a controller commands rover k what it commands.

    Args:
        controller: Any; one that does not play `Explains` is shown by its command alone.
        observation: What n rovers see.
        memory: The controller's memory before this step.
        k: Which rover.
    """
    one = map_arrays(observation, lambda array: array[k : k + 1])
    if isinstance(controller, Explains):
        return controller.why(one, memory)
    command, _ = controller.act(one, memory)
    return Why(
        words=(
            f"{type(controller).__name__} does not say why; {said(command)}",
            "A controller that has a method `why` is asked here.",
        ),
        command=command.twist[0],
    )


def said(command: Command) -> str:
    """A command in words."""
    forward, left, turn = command.twist[0].tolist()
    parts = [f"drive {'forward' if forward >= 0 else 'backward'} at {abs(forward):.2f} m/s"]
    if abs(left) >= 0.005:
        parts.append(f"{'left' if left > 0 else 'right'} at {abs(left):.2f} m/s")
    if abs(turn) >= math.radians(0.5):
        parts.append(f"turn {'left' if turn > 0 else 'right'} at {math.degrees(abs(turn)):.0f}°/s")
    return f"the command is: {', '.join(parts)}."


def side(angle: float, *, of: str = "") -> str:
    """An angle in words: ``straight ahead``, ``23° to the left``."""
    degrees = math.degrees(math.atan2(math.sin(angle), math.cos(angle)))
    if abs(degrees) < 0.5:
        return f"straight at {of}" if of else "straight ahead"
    way = "left" if degrees > 0 else "right"
    return f"{abs(degrees):.0f}° to the {way}{f' of {of}' if of else ''}"


def goal_in_words(observation: Observation) -> str:
    """Where the goal lies."""
    x, y = observation.goal[0].tolist()
    return f"The goal lies {side(math.atan2(y, x))}, {math.hypot(x, y):.2f} m away."


def softmax(logits: Any) -> F64:
    """A distribution from logits."""
    strength = np.exp(np.asarray(logits, np.float64) - np.max(logits))
    return strength / strength.sum()
