"""The values that flow through a drive, batch axis first: n rovers at once.

Frames follow ROS REP-103: x east, y north, z up; heading counter-clockwise from +x, in (-pi, pi].
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from ._arrays import F64, I8, I64
from .errors import SettingError, ShapeError
from .outcome import Outcome
from .values import read_only, value

_DRIVING = int(Outcome.DRIVING)  # a member of an enumeration takes half a microsecond to find
NOT_GIVEN: Any = None
"""Stands for an array that a value fills in by itself."""


@value
class Mission:
    """Where each rover starts and where it shall go.

    Attributes:
        start: Poses (n, 3): x [m], y [m], heading [rad].
        goal: Goals (n, 2): x [m], y [m].
        goal_radius: A rover within this distance of its goal has reached it [m].
        time_limit: A drive that lasts longer ends as `Outcome.TIMED_OUT` [s].
        number: Number of each rover (n,), 0 to n - 1 where not given. Whatever is random for a
            rover hangs on it, so a rover taken out of a batch keeps its luck.
    """

    start: F64
    goal: F64
    goal_radius: float
    time_limit: float
    number: I64 = NOT_GIVEN

    def _check(self) -> None:
        if self.number is NOT_GIVEN:
            object.__setattr__(self, "number", read_only(np.arange(len(self.start))))
        if self.number.shape != (len(self.start),) or self.number.dtype != np.int64:
            raise ShapeError(
                f"a mission needs one int64 number for each of {len(self.start)} rovers, "
                f"got {self.number.dtype} {self.number.shape}"
            )
        _need(self.start, "mission start", 3)
        _need(self.goal, "mission goal", 2)
        if len(self.start) != len(self.goal):
            raise ShapeError(
                f"a mission needs one goal for each start, got {len(self.start)} starts and "
                f"{len(self.goal)} goals"
            )
        for what, number in (("goal radius", self.goal_radius), ("time limit", self.time_limit)):
            if not (np.isfinite(number) and number >= 0):
                raise SettingError(
                    f"a mission's {what} must be 0 or a positive number, got {number!r}"
                )

    @classmethod
    def between(
        cls,
        a: tuple[float, float],
        b: tuple[float, float],
        *,
        goal_radius: float,
        time_limit: float,
    ) -> Mission:
        """One rover from `a` to `b` [m], facing `b` at the start."""
        heading = np.arctan2(b[1] - a[1], b[0] - a[0])
        return cls(
            start=np.array([[a[0], a[1], heading]]),
            goal=np.array([b], dtype=np.float64),
            goal_radius=goal_radius,
            time_limit=time_limit,
        )


@value
class RoverState:
    """What n rovers are doing now.

    Attributes:
        time: Seconds since the start (n,) [s].
        pose: x [m], y [m], heading [rad] (n, 3).
        twist: Body velocity (n, 3): forward [m/s], left [m/s], turn [rad/s]; where wheels slip,
            what they drive, nothing taken off for the slip.
        odometry: Distance driven (n,) [m].
        outcome: `Outcome` codes (n,), int8.
        attitude: Height of the middle at the axles [m], pitch (nose up) [rad] and roll (left side
            up) [rad] (n, 3); 0 on flat worlds.
        slip: Share of the wheels' way that is lost along, and that slides to the left (n, 2).
        energy: Spent since the start (n,) [J].
        stall: Way that was commanded [m], and way made good [m], since progress was last looked at
            (n, 2).
    """

    time: F64
    pose: F64
    twist: F64
    odometry: F64
    outcome: I8
    attitude: F64 = NOT_GIVEN
    slip: F64 = NOT_GIVEN
    energy: F64 = NOT_GIVEN
    stall: F64 = NOT_GIVEN

    def _check(self) -> None:
        n = len(self.pose)
        shapes = (("attitude", (n, 3)), ("slip", (n, 2)), ("energy", (n,)), ("stall", (n, 2)))
        for name, shape in shapes:
            if getattr(self, name) is NOT_GIVEN:
                object.__setattr__(self, name, read_only(np.zeros(shape)))

    @classmethod
    def at_start(cls, mission: Mission) -> RoverState:
        """All rovers at rest at the start of their missions."""
        n = len(mission.start)
        return cls(
            time=np.zeros(n),
            pose=mission.start.copy(),
            twist=np.zeros((n, 3)),
            odometry=np.zeros(n),
            outcome=np.full(n, Outcome.DRIVING, np.int8),
        )

    @property
    def driving(self) -> np.ndarray:
        """Which rovers have not ended yet (n,), bool."""
        return self.outcome == _DRIVING


@value
class Observation:
    """What n rovers know: never the world itself.

    Attributes:
        goal: The goal in each rover's frame (n, 2): forward [m], left [m].
        twist: Body velocity (n, 3) [m/s, m/s, rad/s].
        channels: What each sensor read, by name: (n, b) each.
        map: What the map room made of all readings so far; None without a mapper.
        pose: Where each rover thinks it is (n, 3) [m, m, rad]: the truth, unless it carries
            odometry; None where nobody told.
    """

    goal: F64
    twist: F64
    channels: Mapping[str, F64]
    map: Any = None
    pose: Any = None

    def _check(self) -> None:
        frozen = {name: read_only(reading) for name, reading in self.channels.items()}
        object.__setattr__(self, "channels", MappingProxyType(frozen))

    def channel(self, name: str) -> F64:
        """The readings (n, b) of the sensor `name`; an error names the sensors there are."""
        try:
            return self.channels[name]
        except KeyError:
            have = ", ".join(sorted(self.channels)) or "none"
            raise ShapeError(
                f"the controller needs the sensor {name!r}, which this rover does not carry; "
                f"it carries: {have}"
            ) from None


@value
class Command:
    """What the motors shall do: body twists (n, 3), forward [m/s], left [m/s], turn [rad/s]."""

    twist: F64


def _need(array: F64, name: str, columns: int) -> None:
    if array.ndim != 2 or array.shape[1] != columns:
        raise ShapeError(f"{name} must have shape (n, {columns}), got {array.shape}")
    if not np.isfinite(array).all():
        raise ShapeError(f"{name} has a coordinate that is not a finite number")
