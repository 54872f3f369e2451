"""What carries the body: wheels, joints, belly and the limits of all three."""

from __future__ import annotations

import math
from typing import Literal, get_args

import numpy as np

from ..core import F64, SettingError, suggest, value

Suspension = Literal["rigid", "averaging", "rocker-bogie"]
End = Literal["front", "rear"]

_KINDS = {"rigid": 0.0, "averaging": 1.0, "rocker-bogie": 2.0}


@value
class Chassis:
    """Wheels, joints and belly.

    Positions are in body axes: x forward of the rover's middle, z above its axles [m].

    Attributes:
        suspension: "rigid": four wheels on one board, three of which carry it on rough ground.
            "averaging": two wheels on each side's rocker, the body at the mean of both rockers.
            "rocker-bogie": six wheels, two of a side on a bogie that is hinged to the rocker.
        wheel_x: Wheels of one side from front to rear (2,) or (3,) [m].
        wheel_width: [m].
        rocker: x and z of the pivot between body and rocker [m]; not used where rigid.
        bogie: x and z of the pivot between rocker and bogie [m]; rocker-bogie only.
        bogie_wheels: The end of the rover whose wheels hang on the bogies.
        belly_length: Length of the flat rectangle under the body [m].
        belly_width: Its width [m].
        belly_x: x of its middle [m].
        mass_x: x of the centre of mass [m]; tells which end a rigid rover rests on.
        max_tilt: Largest angle of the body against level in normal driving [rad].
        max_pitch: Largest up or down [rad].
        max_roll: Largest sideways [rad].
        static_tilt: Angle at which it tips over [rad].
        max_rocker: Largest angle between body and rocker [rad].
        max_bogie: Largest angle between body and bogie [rad].
    """

    suspension: Suspension
    wheel_x: tuple[float, ...]
    wheel_width: float
    rocker: tuple[float, float]
    bogie: tuple[float, float]
    bogie_wheels: End
    belly_length: float
    belly_width: float
    belly_x: float
    mass_x: float
    max_tilt: float
    max_pitch: float
    max_roll: float
    static_tilt: float
    max_rocker: float
    max_bogie: float

    def _check(self) -> None:
        if self.suspension not in get_args(Suspension):
            known = suggest(self.suspension, get_args(Suspension))
            raise SettingError(f"unknown suspension {self.suspension!r}; {known}")
        for sentence in (*_ranges(self), *_geometry(self)):
            raise SettingError(sentence)

    @property
    def wheels(self) -> int:
        """How many wheels."""
        return 2 * len(self.wheel_x)

    @property
    def wheelbase(self) -> float:
        """From the foremost to the rearmost axle [m]."""
        return self.wheel_x[0] - self.wheel_x[-1]


def chassis_array(
    chassis: Chassis, *, radius: float, track: float, clearance: float, max_step: float
) -> F64:
    """The chassis as the kernels of `kernels.settle` take it (CHASSIS,)."""
    c = chassis
    front = c.suspension == "rocker-bogie" and c.bogie_wheels == "front"
    x = c.wheel_x[::-1] if front else c.wheel_x
    numbers = [
        _KINDS[c.suspension], radius, track,
        x[0], x[1], x[-1], *c.rocker, *c.bogie,
        -1.0 if front else 1.0,
        clearance - radius,
        c.belly_x - 0.5 * c.belly_length, c.belly_x + 0.5 * c.belly_length, 0.5 * c.belly_width,
        1.0 if c.mass_x > 0.5 * (c.wheel_x[0] + c.wheel_x[-1]) else 0.0,
        c.max_tilt, c.max_pitch, c.max_roll, c.max_rocker, c.max_bogie, max_step, 0.0,
    ]  # fmt: skip
    return np.array(numbers)


_LENGTHS = ("wheel_width", "belly_length", "belly_width")
_ANGLES = ("max_tilt", "max_pitch", "max_roll", "static_tilt", "max_rocker", "max_bogie")


def _ranges(c: Chassis) -> list[str]:
    found = [
        f"{name} must lie in 0 to 20 m, got {getattr(c, name):g}"
        for name in _LENGTHS
        if not 0.0 <= getattr(c, name) <= 20.0
    ]
    for name in _ANGLES:
        got = math.degrees(getattr(c, name))
        if not 0.0 <= got <= 89.0:
            found.append(f"{name} must lie in 0 to 89 deg, got {got:g}")
    places = (*c.wheel_x, *c.rocker, *c.bogie, c.belly_x, c.mass_x)
    if not all(abs(place) <= 20.0 for place in places):
        found.append("a position must lie within 20 m of the rover's middle")
    return found


def _geometry(c: Chassis) -> list[str]:
    count = 3 if c.suspension == "rocker-bogie" else 2
    if len(c.wheel_x) != count:
        return [f"{c.suspension} needs {count} wheels a side in wheel_x, got {len(c.wheel_x)}"]
    if any(a <= b for a, b in zip(c.wheel_x, c.wheel_x[1:], strict=False)):
        return [f"wheel_x must fall from front to rear, got {', '.join(map(str, c.wheel_x))}"]
    if c.suspension == "rigid":
        return []
    low, high = c.wheel_x[-1], c.wheel_x[0]
    if not low < c.rocker[0] < high:
        return [f"the rocker's pivot must lie between the wheels ({low:g} to {high:g} m)"]
    if c.suspension == "averaging":
        return []
    if c.bogie_wheels not in get_args(End):
        return [f"bogie_wheels must be front or rear, got {c.bogie_wheels!r}"]
    pair = c.wheel_x[:2] if c.bogie_wheels == "front" else c.wheel_x[1:]
    if not pair[1] < c.bogie[0] < pair[0]:
        return [f"the bogie's pivot must lie between its wheels ({pair[1]:g} to {pair[0]:g} m)"]
    if c.bogie[1] < 0.0:
        return ["the bogie's pivot must not lie below the axles"]
    return []
