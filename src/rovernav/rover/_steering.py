"""How a rover steers, and how fast its motors answer."""

from __future__ import annotations

import math
from typing import Literal, get_args

from ..core import SettingError, suggest, value

Kind = Literal["two-axis", "skid", "ackermann", "crab"]


@value
class Steering:
    """What commands the wheels can follow.

    Attributes:
        kind: "skid": no wheel is steered; the sides turn at different speeds, on the spot too.
            "ackermann": wheels at the ends are steered, those of one axle are not: the middle axle
            of six wheels, the rear axle of four. "crab": every wheel is steered, so the rover also
            moves sideways. "two-axis": the seed paper's, along and across a heading that stays.
        max_steer: Largest angle of a steered wheel [rad]; 90 deg and more is no limit.
        wheel_speed: Fastest that a wheel turns, as way of its rim [m/s]; 0 where it never limits.
        acceleration: Most that the speed changes in a second [m/s^2]; 0 where it never limits.
        turn_acceleration: Most that the turn rate changes in a second [rad/s^2]; 0 likewise.
        lag: Time constant with which speeds follow a command [s]; 0 where they do at once.
    """

    kind: Kind
    max_steer: float = math.pi / 2.0
    wheel_speed: float = 0.0
    acceleration: float = 0.0
    turn_acceleration: float = 0.0
    lag: float = 0.0

    def _check(self) -> None:
        if self.kind not in get_args(Kind):
            raise SettingError(
                f"unknown steering {self.kind!r}; {suggest(self.kind, get_args(Kind))}"
            )
        if not 0.0 < self.max_steer <= math.pi:
            got = math.degrees(self.max_steer)
            raise SettingError(f"max_steer must lie above 0 and within 180 deg, got {got:g}")
        for name in ("wheel_speed", "acceleration", "turn_acceleration", "lag"):
            got = getattr(self, name)
            if not 0.0 <= got <= 1e6:
                raise SettingError(f"{name} must be 0 or a positive number, got {got:g}")
