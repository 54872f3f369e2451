"""From a distribution over headings to the motors of a differential drive."""

from __future__ import annotations

import math
from typing import Any, final

import numpy as np

from ..core import F64, Command, Observation, SettingError
from ..kernels import steering as kernels


@final
class HeadingCodec:
    """The neural driver's: free distances all round in, a distribution over headings out.

    Inputs, in the frame whose zero points at the goal: the free share of the sensor's reach in
    `rays` directions, cosine and sine of the rover's heading, and the distance to the goal as a
    share of the reach, at most 1. Outputs: logits of `headings` directions, the first towards the
    goal, the others following to the left.

    Args:
        rays: Directions in which the local map is asked.
        headings: Directions to choose from.
        speed: Forward speed on free ground [m/s].
        turn_rate: Turn rate [rad/s].
        period: Time between two decisions [s].
        margin: Distance kept from what the beams see ahead [m].
        commitment: How much a heading's logit falls per radian of turning to it: a rover that
            changes its mind at every step gets nowhere.
    """

    name = "headings"

    def __init__(  # noqa: PLR0913 - the parameters that a network file names, by keyword
        self,
        *,
        rays: int = 64,
        headings: int = 32,
        speed: float = 0.3,
        turn_rate: float = 0.698,
        period: float = 1.0,
        margin: float = 0.05,
        commitment: float = 1.0,
    ) -> None:
        for what, number in (("speed", speed), ("turn_rate", turn_rate), ("period", period)):
            if not (_is_finite(number) and number > 0):
                raise SettingError(f"codec headings: {what} must be above 0, got {number!r}")
        for what, number in (("margin", margin), ("commitment", commitment)):
            if not (_is_finite(number) and number >= 0):
                raise SettingError(f"codec headings: {what} must be 0 or above, got {number!r}")
        for what, count in (("rays", rays), ("headings", headings)):
            if not (_is_finite(count) and count == int(count) and 4 <= count <= 4096):
                raise SettingError(
                    f"codec headings: {what} must be a whole number from 4 to 4096, got {count!r}"
                )
        self.rays, self.headings = int(rays), int(headings)
        self.speed, self.turn_rate = float(speed), float(turn_rate)
        self.period, self.margin = float(period), float(margin)
        self.commitment = float(commitment)

    @property
    def sizes(self) -> tuple[int, int]:
        """Inputs and outputs of the networks that it fits."""
        return self.rays + 3, self.headings

    def encode(self, observation: Observation) -> F64:
        """Network inputs (n, rays + 3)."""
        around = observation.channel("around")
        if around.shape[1] != self.rays:
            raise SettingError(
                f"codec headings needs {self.rays} rays around, this rover has {around.shape[1]}"
            )
        out = np.empty((len(around), self.rays + 3))
        kernels.encode(around, observation.channel("reach"), observation.goal, out)
        return out

    def decode(self, outputs: F64, observation: Observation) -> Command:
        """The body twist (n, 3) that turns to the chosen heading and drives as far as is seen."""
        twist = np.empty((len(outputs), 3))
        limits = kernels.Limits(
            speed=self.speed,
            turn_rate=self.turn_rate,
            period=self.period,
            margin=self.margin,
            commitment=self.commitment,
        )
        kernels.decode(
            np.ascontiguousarray(outputs, dtype=np.float64),
            observation.goal,
            observation.channel("beams"),
            limits,
            twist,
        )
        return Command(twist=twist)

    def settings(self) -> dict[str, Any]:
        """Name and parameters, as they stand in the network file."""
        return {
            "name": self.name,
            "rays": self.rays,
            "headings": self.headings,
            "speed": self.speed,
            "turn_rate": self.turn_rate,
            "period": self.period,
            "margin": self.margin,
            "commitment": self.commitment,
        }


def _is_finite(number: object) -> bool:
    """Whether it is a number at all: the parameters of a codec come out of files."""
    return isinstance(number, (int, float)) and math.isfinite(number)
