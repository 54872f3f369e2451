"""How commands become motion."""

from __future__ import annotations

from dataclasses import replace
from typing import final

import numpy as np

from ..core import Command, RoverState, SettingError
from ..kernels import drive as kernels


@final
class TwoAxis:
    """The paper's rover: a point whose two motors move it along and across its heading.

    The heading never changes. It follows every command exactly, at once.

    Args:
        period: Time between two decisions [s].
    """

    def __init__(self, period: float = 1.0) -> None:
        if not (np.isfinite(period) and period > 0):
            raise SettingError(f"the period must be above 0 s, got {period!r}")
        self.period = float(period)

    def step(self, state: RoverState, command: Command) -> RoverState:
        """The state one period later, obstacles not yet considered."""
        pose = np.empty_like(state.pose)
        kernels.two_axis(state.pose, command.twist, self.period, pose)
        return replace(
            state,
            time=state.time + self.period,
            pose=pose,
            twist=command.twist,
            odometry=state.odometry + _moved(state.pose, pose),
        )


@final
class DifferentialDrive:
    """Two driven sides: forward speed and turn rate, within the rover's limits.

    A command is limited to `speed` and `turn_rate` and then followed exactly for one period, along
    an arc. Sideways speed is ignored: such a rover has none.

    Args:
        speed: Top speed [m/s].
        turn_rate: Top turn rate [rad/s].
        period: Time between two decisions [s].
    """

    def __init__(self, *, speed: float, turn_rate: float, period: float = 0.5) -> None:
        for what, number in (("speed", speed), ("turn rate", turn_rate), ("period", period)):
            if not (np.isfinite(number) and number > 0):
                raise SettingError(f"a differential drive needs a {what} above 0, got {number!r}")
        self.speed, self.turn_rate = float(speed), float(turn_rate)
        self.period = float(period)

    def step(self, state: RoverState, command: Command) -> RoverState:
        """The state one period later, obstacles not yet considered."""
        pose, twist = np.empty_like(state.pose), np.empty_like(state.pose)
        kernels.differential(
            state.pose, command.twist, self.speed, self.turn_rate, self.period, pose, twist
        )
        return replace(
            state,
            time=state.time + self.period,
            pose=pose,
            twist=twist,
            odometry=state.odometry + _moved(state.pose, pose),
        )


def _moved(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    return np.hypot(after[:, 0] - before[:, 0], after[:, 1] - before[:, 1])
