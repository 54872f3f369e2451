"""Codecs: what a network's inputs and outputs mean. Named in the network file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, final

import numpy as np

from ..core import F64, Codec, Command, Observation, SettingError, suggest


@final
class BassilCodec:
    """The paper's: two binary sensors in, motor commands along and across the heading out.

    Args:
        step: How far an output of 1 moves the rover in one period [m].
        period: Time between two decisions [s].
        stop_at_goal: With a clear sight, a step that would pass the goal ends at it.
    """

    name = "bassil"

    def __init__(
        self, *, step: float = 0.8287, period: float = 1.0, stop_at_goal: bool = True
    ) -> None:
        for what, number in (("step", step), ("period", period)):
            if not (isinstance(number, (int, float)) and np.isfinite(number) and number > 0):
                raise SettingError(f"codec bassil: {what} must be above 0, got {number!r}")
        self.step, self.period, self.stop_at_goal = float(step), float(period), bool(stop_at_goal)

    def encode(self, observation: Observation) -> F64:
        """Channels ``clear_sight`` and ``off_line`` side by side (n, 2)."""
        sight = observation.channel("clear_sight")
        return np.concatenate((sight, observation.channel("off_line")), axis=1)

    def decode(self, outputs: F64, observation: Observation) -> Command:
        """Outputs (n, 2) as body twists: `step` times the output in each period."""
        twist = np.zeros((len(outputs), 3))
        move = self.step * outputs
        if self.stop_at_goal:
            goal = observation.goal
            near = (goal * goal).sum(1) <= (move * move).sum(1)
            cut = near & (observation.channel("clear_sight")[:, 0] == 1.0)
            if cut.any():
                move = np.where(cut[:, None], goal, move)
        twist[:, :2] = move / self.period
        return Command(twist=twist)

    def settings(self) -> dict[str, Any]:
        """Name and parameters, as they stand in the network file."""
        return {
            "name": self.name,
            "step": self.step,
            "period": self.period,
            "stop_at_goal": self.stop_at_goal,
        }


_CODECS: dict[str, Callable[..., Codec]] = {BassilCodec.name: BassilCodec}


def build_codec(settings: Mapping[str, Any]) -> Codec:
    """The codec that a network file names.

    Raises:
        SettingError: Unknown codec or parameter.
    """
    parameters = dict(settings)
    name = parameters.pop("name", None)
    if name not in _CODECS:
        raise SettingError(f"unknown codec {name!r}; {suggest(str(name), _CODECS)}")
    try:
        return _CODECS[name](**parameters)
    except TypeError as error:
        raise SettingError(f"codec {name}: {error}") from None
