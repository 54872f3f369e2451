"""What moves the rover: mass, motors, and the soil it is on unless told otherwise."""

from __future__ import annotations

from ..core import SettingError, value


@value
class Mobility:
    """Numbers that slip and energy need.

    Attributes:
        mass: [kg].
        gravity: Of the body it drives on [m/s^2].
        efficiency: Mechanical work at the wheels for each joule of drive power, 0 to 1.
        idle_power: Drawn while driving apart from the drive motors: computer, radio, heaters [W].
        drive_power: Most that the drive motors can draw [W]; 0 where it never limits.
        max_slip: Slip beyond which a way counts as impassable, 0 to 1.
        soil: Name of the soil it drives on unless told otherwise.
    """

    mass: float
    gravity: float
    efficiency: float
    idle_power: float
    drive_power: float
    max_slip: float
    soil: str

    def _check(self) -> None:
        for name, low, high, unit in _RANGES:
            got = getattr(self, name)
            if not low <= got <= high:
                raise SettingError(f"{name} must lie in {low:g} to {high:g}{unit}, got {got:g}")


_RANGES = (
    ("mass", 1e-3, 1e6, " kg"),
    ("gravity", 1e-3, 30.0, " m/s^2"),
    ("efficiency", 0.01, 1.0, ""),
    ("idle_power", 0.0, 1e6, " W"),
    ("drive_power", 0.0, 1e7, " W"),
    ("max_slip", 0.01, 0.99, ""),
)
