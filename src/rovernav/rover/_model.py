"""The rover described: its size, its limits and how it moves."""

from __future__ import annotations

import math
from typing import Any, Literal, get_args

from ..core import F64, SettingError, suggest, value
from ._chassis import Chassis, chassis_array
from ._mobility import Mobility
from ._steering import Kind, Steering

Drive = Literal["differential", "two-axis"]

NOT_GIVEN: Any = None
"""Stands for what a rover fills in by itself."""
_STEERS: dict[str, Kind] = {"two-axis": "two-axis", "differential": "skid"}

POINT_FOOTING = 0.3
"""Ground over which a rover without a size feels a slope [m]: a small wheelbase."""

DEGREE = math.pi / 180.0
"""One degree [rad]."""


@value
class Rover:
    """A rover: plain numbers, each of which `source` accounts for.

    Attributes:
        name: Short name.
        source: Where each number comes from; "memory" marks an unchecked one.
        drive: "two-axis": a point that moves `step` times two numbers in [-1, 1] along x and y, as
            the seed paper's rover does. "differential": left and right wheels, turns on the spot.
        length: Along the rover, wheels included [m]; 0 for a point.
        width: Across the rover, wheels included [m]; 0 for a point.
        wheel_radius: [m]; 0 where wheels are not modelled.
        clearance: Height of the belly above level ground [m].
        max_slope: Steepest ground the rover may stand on [rad].
        max_step: Highest ledge its wheels climb [m].
        speed: Top speed [m/s].
        turn_rate: Top turn rate on the spot [rad/s]; 0 where it cannot turn.
        track: Distance between left and right wheels [m]; 0 for a point.
        step: Length of one step of a two-axis rover [m]; 0 for others.
        footing: Length of ground over which the rover feels a slope [m].
        chassis: Wheels, joints and belly, for settling it on the ground. Where a rover with wheels
            does not say, it gets four wheels at the corners of its footprint and an averaging
            suspension; None without wheels.
        mobility: Mass, motors and soil, for slip and energy; None where they are not known.
        steering: Which wheels are steered, limits of the motors and their lag. Where a rover does
            not say, that of its drive: "skid" or "two-axis", without further limits.
    """

    name: str
    source: str
    drive: Drive
    length: float
    width: float
    wheel_radius: float
    clearance: float
    max_slope: float
    max_step: float
    speed: float
    turn_rate: float = 0.0
    track: float = 0.0
    step: float = 0.0
    footing: float = 0.0
    chassis: Chassis | None = None
    mobility: Mobility | None = None
    steering: Steering = NOT_GIVEN

    def _check(self) -> None:
        if self.drive not in get_args(Drive):
            known = suggest(self.drive, get_args(Drive))
            raise SettingError(f"rover {self.name}: unknown drive {self.drive!r}; {known}")
        if self.steering is NOT_GIVEN:
            object.__setattr__(self, "steering", Steering(kind=_STEERS[self.drive]))
        for field, low, high, unit in _RANGES:
            _within(self.name, field, getattr(self, field), (low, high), unit)
        if self.footing == 0.0:
            object.__setattr__(self, "footing", max(self.length, self.width) or POINT_FOOTING)
        for sentence in _contradictions(self):
            raise SettingError(f"rover {self.name}: {sentence}")
        if self.chassis is None and self.wheel_radius > 0.0 and self.track > 0.0:
            object.__setattr__(self, "chassis", _corners(self))

    def chassis_array(self) -> F64:
        """The chassis as the settling kernels take it.

        Raises:
            SettingError: The rover has no wheels.
        """
        if self.chassis is None or self.wheel_radius == 0.0 or self.track == 0.0:
            raise SettingError(
                f"rover {self.name} has no wheels to set onto the ground; give wheel_radius_m, "
                "track_m and a length, or a section chassis"
            )
        return chassis_array(
            self.chassis, radius=self.wheel_radius, track=self.track, clearance=self.clearance,
            max_step=self.max_step,
        )  # fmt: skip

    @property
    def radius(self) -> float:
        """Radius of the circle around the whole footprint [m]; 0 for a point."""
        return math.hypot(self.length, self.width) / 2.0

    @property
    def is_point(self) -> bool:
        """Whether the rover has no size."""
        return self.length == 0.0 and self.width == 0.0


STATIC_TILT = 45.0 * DEGREE
"""Where a rover file does not say at which angle it tips over: that of four NASA rovers [rad]."""
JOINT = 30.0 * DEGREE
"""Where a rover file does not say how far its joints turn: an assumption [rad]."""

_RANGES = (
    ("length", 0.0, 20.0, "m"),
    ("width", 0.0, 20.0, "m"),
    ("wheel_radius", 0.0, 5.0, "m"),
    ("clearance", 0.0, 10.0, "m"),
    ("max_slope", 0.0, 89.0 * DEGREE, "deg"),
    ("max_step", 0.0, 5.0, "m"),
    ("speed", 1e-6, 100.0, "m/s"),
    ("turn_rate", 0.0, 100.0, "rad/s"),
    ("track", 0.0, 20.0, "m"),
    ("step", 0.0, 1000.0, "m"),
    ("footing", 0.0, 100.0, "m"),
)
"""Field, smallest, largest, unit."""


def _within(rover: str, field: str, got: float, allowed: tuple[float, float], unit: str) -> None:
    low, high = allowed
    if low <= got <= high:  # False for NaN
        return
    if unit == "deg":
        low, high, got = low / DEGREE, high / DEGREE, got / DEGREE
    raise SettingError(
        f"rover {rover}: {field} must lie in {low:g} to {high:g} {unit}, got {got:g}"
    )


def _contradictions(rover: Rover) -> list[str]:
    """Sentences about numbers that are fine alone but not together."""
    found: list[str] = []
    if (rover.length == 0.0) != (rover.width == 0.0):
        found.append(
            f"length {rover.length:g} m and width {rover.width:g} m must both be 0 (a point) or "
            "both be positive"
        )
    if not rover.is_point and 2.0 * rover.wheel_radius > rover.length:
        found.append(
            f"a wheel of {2.0 * rover.wheel_radius:g} m does not fit into a length of "
            f"{rover.length:g} m, which includes the wheels; correct one of them"
        )
    if not rover.is_point and rover.track > rover.width:
        found.append(
            f"track {rover.track:g} m must not exceed width {rover.width:g} m, which includes "
            "the wheels"
        )
    if rover.chassis is not None:
        found.extend(_chassis_contradictions(rover, rover.chassis))
    if rover.drive == "two-axis" and rover.step == 0.0:
        found.append("a two-axis rover needs a positive step; set it")
    steered = rover.steering.kind
    if (rover.drive == "two-axis") != (steered == "two-axis"):
        found.append(
            f"a {rover.drive} rover cannot have {steered} steering; two-axis goes with itself"
        )
    if steered in ("ackermann", "crab") and rover.chassis is None and rover.wheel_radius == 0.0:
        found.append(f"{steered} steering needs wheels; give wheel_radius and track")
    if rover.drive == "differential" and (rover.track == 0.0 or rover.turn_rate == 0.0):
        found.append("a differential rover needs a positive track and turn rate; set both")
    return found


def _chassis_contradictions(rover: Rover, chassis: Chassis) -> list[str]:
    if rover.wheel_radius == 0.0 or rover.track == 0.0:
        return ["a chassis needs a positive wheel radius and track; set both"]
    long = chassis.wheelbase + 2.0 * rover.wheel_radius
    if long > rover.length + 1e-9:
        return [f"wheels reach over {long:g} m, more than the length of {rover.length:g} m"]
    return []


def _corners(rover: Rover) -> Chassis:
    """Four wheels at the corners of the footprint, for rovers that say no more."""
    x = 0.5 * rover.length - rover.wheel_radius
    wide = max(0.0, min(rover.width - rover.track, rover.track))
    return Chassis(
        suspension="averaging", wheel_x=(x, -x) if x > 0.0 else (0.01, -0.01), wheel_width=wide,
        rocker=(0.0, 0.0), bogie=(0.0, 0.0), bogie_wheels="rear",
        belly_length=2.0 * max(x, 0.0), belly_width=rover.track - wide, belly_x=0.0, mass_x=0.0,
        max_tilt=rover.max_slope, max_pitch=rover.max_slope, max_roll=rover.max_slope,
        static_tilt=max(rover.max_slope, STATIC_TILT),
        max_rocker=JOINT, max_bogie=JOINT,
    )  # fmt: skip
