"""From a distribution over headings to the motors of a differential drive."""

from __future__ import annotations

import math
from typing import Any, final

import numpy as np

from ..core import F64, Command, Observation, SettingError
from ..kernels import steering as kernels
from ._why import Headings, Reading, goal_in_words, said, side, softmax


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

    def choice(self, outputs: Any, observation: Observation) -> Headings:
        """The directions of the first rover, how strong each is once turning costs, and the choice.

        The same rule as `decode`: the strongest heading, drawn towards its stronger neighbour.
        """
        logits = np.asarray(outputs, np.float64)[0]
        x, y = observation.goal[0].tolist()
        to_goal = math.atan2(y, x)
        turns = 2.0 * math.pi * np.arange(self.headings) / self.headings
        angles = np.arctan2(np.sin(to_goal + turns), np.cos(to_goal + turns))
        strength = logits - self.commitment * np.abs(angles)
        best = int(np.argmax(strength))
        left, right = logits[(best + 1) % self.headings], logits[best - 1]
        bend = 2.0 * logits[best] - left - right
        shift = 0.5 * float(left - right) / float(bend) if bend > 0.0 else 0.0
        wanted = to_goal + 2.0 * math.pi * (best + shift) / self.headings
        angle = math.atan2(math.sin(wanted), math.cos(wanted))
        return Headings(angles=angles, share=softmax(strength), chosen=best, angle=angle)

    def read(self, outputs: Any, observation: Observation) -> Reading:
        """What the logits (1, headings) mean for the first rover."""
        choice = self.choice(outputs, observation)
        logits = np.asarray(outputs, np.float64)[0]
        liked, best = int(np.argmax(logits)), choice.chosen
        share = softmax(logits)
        words = [
            goal_in_words(observation),
            f"Of {self.headings} directions the outputs favour the one "
            f"{side(float(choice.angles[liked]))} ({share[liked]:.0%}).",
        ]
        if liked != best:
            words.append(
                f"But turning costs {self.commitment:g} per radian, so it takes the one "
                f"{side(float(choice.angles[best]))} ({share[best]:.0%} before that cost)."
            )
        words += self._motors(choice.angle, outputs, observation)
        return Reading(words=tuple(words), headings=choice)

    def _motors(self, angle: float, outputs: Any, observation: Observation) -> list[str]:
        beams = observation.channel("beams")[0]
        spread = np.linspace(-math.pi / 2, math.pi / 2, len(beams))
        ahead = float(beams[np.abs(spread) <= kernels.AHEAD].min())
        words = [f"It steers {side(angle)}; {said(self.decode(outputs, observation))}"]
        if abs(angle) >= kernels.SHARP:
            words.append("The turn is too sharp to drive on: it turns on the spot.")
        elif ahead - self.margin < self.speed * self.period:
            words.append(f"Something {ahead:.2f} m ahead holds its speed down.")
        return words

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
