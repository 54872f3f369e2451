"""A driver held back from ground that its own map forbids."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, final

import numpy as np

from ..core import Command, Controller, Memory, Mission, Observation, SettingError
from ..kernels import guard as kernels
from ..mapping import Elevation, LocalMap
from ._why import Why, explain


@final
class Guarded:
    """Lets any driver drive, but not onto ground that the rover's map of heights forbids.

    The arc of a command is looked at on the map before it is driven, and ends before the first
    cell where the rover's middle must not be. A rover that stands on such ground, because it learnt
    only now what lies near it, may move no nearer to the hazard than it is. Where nothing is left
    of an arc the rover turns on the spot, which is always allowed. Maps without heights are left to
    the driver: their beams say exactly how far it is.

    Args:
        driver: Who drives.
        period: How long a command is driven [s].
        radius: How far from a hazard the map blocks ground [m].
    """

    def __init__(self, driver: Controller, *, period: float, radius: float) -> None:
        for what, got in (("period", period), ("radius", radius)):
            if not (math.isfinite(got) and got > 0):
                raise SettingError(f"a guarded driver needs a {what} above 0, got {got!r}")
        self.driver, self.period, self.radius = driver, float(period), float(radius)

    def start(self, mission: Mission, rng: np.random.Generator) -> Memory:
        """The driver's."""
        return self.driver.start(mission, rng)

    def act(self, observation: Observation, memory: Memory) -> tuple[Command, Memory]:
        """The part of the driver's command that the map allows."""
        command, after = self.driver.act(observation, memory)
        return self._held(observation, command), after

    def why(self, observation: Observation, memory: Memory) -> Why:
        """The driver's reasons, and whether it was held back."""
        told = explain(self.driver, observation, memory)
        command = self._held(observation, Command(twist=told.command[None])).twist[0]
        if np.array_equal(command, told.command):
            return told
        word = (
            f"Its map forbids the rest of that way: {command[0]:.2f} m/s are left of "
            f"{told.command[0]:.2f} m/s."
        )
        return replace(told, words=(*told.words, word), command=command)

    def _held(self, observation: Observation, command: Command) -> Command:
        local: Any = observation.map
        if not (isinstance(local, LocalMap) and isinstance(local.ground, Elevation)):
            return command
        twist = np.array(command.twist, np.float64, order="C")
        kernels.hold_back(
            local.pose, local.cells, local.ground.reason, local.centre, local.cell, self.period,
            self.radius / local.cell, twist,
        )  # fmt: skip
        return Command(twist=twist)
