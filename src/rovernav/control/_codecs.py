"""Codecs: what a network's inputs and outputs mean. Named in the network file."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Any, final

import numpy as np

from ..core import F64, Codec, Command, Float, Observation, SettingError, suggest
from ..kernels import drive as kernels
from ._headings import HeadingCodec
from ._why import Reading, goal_in_words, said


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
        given: dict[str, Any] = {"step": step, "period": period}
        for what, number in given.items():
            if not (isinstance(number, (int, float)) and np.isfinite(number) and number > 0):
                raise SettingError(f"codec bassil: {what} must be above 0, got {number!r}")
        if stop_at_goal not in (True, False):
            raise SettingError(
                f"codec bassil: stop_at_goal must be true or false, got {stop_at_goal!r}"
            )
        self.step, self.period, self.stop_at_goal = float(step), float(period), bool(stop_at_goal)

    @property
    def sizes(self) -> tuple[int, int]:
        """Inputs and outputs of the networks that it fits."""
        return 2, 2

    def encode(self, observation: Observation) -> F64:
        """Channels ``clear_sight`` and ``off_line`` side by side (n, 2)."""
        out = np.empty((len(observation.goal), 2))
        sight, off_line = observation.channel("clear_sight"), observation.channel("off_line")
        kernels.side_by_side(sight, off_line, out)
        return out

    def decode(self, outputs: Float, observation: Observation) -> Command:
        """Outputs (n, 2) as body twists: `step` times the output in each period."""
        twist = np.empty((len(outputs), 3))
        kernels.axis_speeds(
            outputs, self.step, self.period, observation.goal,
            observation.channel("clear_sight"), self.stop_at_goal, twist,
        )  # fmt: skip
        return Command(twist=twist)

    def read(self, outputs: Float, observation: Observation) -> Reading:
        """What the outputs (1, 2) mean for the first rover."""
        along, across = np.asarray(outputs, np.float64)[0].tolist()
        clear = observation.channel("clear_sight")[0, 0] == 1.0
        off = observation.channel("off_line")[0, 0] == 1.0
        command = self.decode(outputs, observation)
        words = [
            goal_in_words(observation),
            "Sensor x: the straight line to the goal is "
            + ("free." if clear else "blocked.")
            + " Sensor y: the rover is "
            + ("off the line from start to goal." if off else "on the line from start to goal."),
            f"The motors get {along:+.3f} along and {across:+.3f} across the heading, steps of "
            f"{self.step:g} m; {said(command)}",
        ]
        if not np.allclose(
            command.twist[0, :2] * self.period, [along * self.step, across * self.step]
        ):
            words.append("The goal is nearer than one step and in sight: the step ends at it.")
        if not clear:
            words.append("The two bits do not say on which side the obstacle can be passed.")
        return Reading(words=tuple(words))

    def settings(self) -> dict[str, Any]:
        """Name and parameters, as they stand in the network file."""
        return {
            "name": self.name,
            "step": self.step,
            "period": self.period,
            "stop_at_goal": self.stop_at_goal,
        }


_CODECS: dict[str, Callable[..., Codec]] = {
    BassilCodec.name: BassilCodec,
    HeadingCodec.name: HeadingCodec,
}


def build_codec(settings: Mapping[str, Any]) -> Codec:
    """The codec that a network file names.

    Raises:
        SettingError: Unknown codec or parameter.
    """
    parameters = dict(settings)
    name = parameters.pop("name", None)
    if not isinstance(name, str) or name not in _CODECS:
        raise SettingError(f"unknown codec {name!r}; {suggest(str(name), _CODECS)}")
    allowed = inspect.signature(_CODECS[name]).parameters
    for key in parameters:
        if key not in allowed:
            raise SettingError(f"codec {name}: unknown parameter {key!r}; {suggest(key, allowed)}")
    try:
        return _CODECS[name](**parameters)
    except TypeError as error:
        raise SettingError(f"codec {name}: {error}") from None
