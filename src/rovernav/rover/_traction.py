"""What driving costs a rover on a slope, on a soil."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, get_args

import numpy as np

from ..core import F64, U8, InputError, SettingError, suggest, value
from ..kernels import traction as k
from ._chassis import Chassis
from ._mobility import Mobility
from ._model import Rover
from ._soils import Soil, read_soil

SlipBand = Literal["low", "expected", "high"]


@value
class DriveCost:
    """What driving costs at each of many slopes and headings; all arrays have one shape.

    Attributes:
        pitch: Nose up, on a plane of that slope [rad].
        roll: Left side up [rad].
        slip: Share of the wheels' way that is lost, 0 to 1.
        side_slip: Way sideways for each metre of the wheels' way; positive to the right, that is
            downhill where the left side is up.
        speed: Over ground [m/s].
        power: Drawn, idle power included [W]; NaN where the wheels get nowhere.
        energy: For each metre of map [J/m]; infinite where the wheels get nowhere.
        time: For each metre of map [s/m].
        code: 0 where it may drive, otherwise 1 pitch, 2 roll, 3 tilt, 4 slip beyond its limit;
            plus 8 where the slope, 16 where the side slope is outside of what was measured, uint8.
    """

    pitch: F64
    roll: F64
    slip: F64
    side_slip: F64
    speed: F64
    power: F64
    energy: F64
    time: F64
    code: U8

    @property
    def allowed(self) -> Any:
        """Whether all limits are kept."""
        return (self.code & 7) == k.ALLOWED

    @property
    def measured(self) -> Any:
        """Whether slip on a climb or descent like this was measured, not only assumed."""
        return (self.code & k.UNMEASURED) == 0


def drive_table(
    rover: Rover, soils: str | Soil | Sequence[str | Soil] | None = None, *, slip: str = "expected"
) -> F64:
    """What the traction kernels need of a rover and of each soil (soils, columns), read-only.

    Args:
        rover: Needs its section mobility.
        soils: A soil, a name or several of them; the rover's own where not given.
        slip: "low", "expected" or "high": which edge of the band of likely slip to take.

    Raises:
        SettingError: The rover says nothing of its mass and motors, or an unknown word.
    """
    mobility, chassis = _parts(rover)
    if slip not in get_args(SlipBand):
        raise SettingError(f"unknown slip {slip!r}; {suggest(slip, get_args(SlipBand))}")
    named = [mobility.soil] if soils is None else soils
    several = [named] if isinstance(named, str | Soil) else list(named)
    if not several:
        raise SettingError("give at least one soil")
    rows = [_row(rover, mobility, chassis, _soil(one), slip) for one in several]
    table = np.stack(rows)
    table.flags.writeable = False
    return table


def drive_cost(p: Any, q: Any, heading: Any, table: F64, soil: Any = 0) -> DriveCost:
    """What driving costs on slopes.

    Args:
        p: Rise per metre to the east.
        q: Rise per metre to the north.
        heading: Direction of travel [rad].
        table: From `drive_table`.
        soil: Row of `table`. All four broadcast against each other.

    Raises:
        InputError: A soil that the table does not have.
    """
    p, q, heading, soil = np.broadcast_arrays(p, q, heading, np.asarray(soil, np.int64))
    if soil.size and not (soil.min() >= 0 and soil.max() < len(table)):
        raise InputError(f"soil must be 0 to {len(table) - 1}, a row of the table")
    east = np.ascontiguousarray(p, np.float64).ravel()
    north = np.ascontiguousarray(q, np.float64).ravel()
    turn = np.asarray(heading, np.float64).ravel()
    out = np.empty((p.size, k.OUT))
    rows = np.ascontiguousarray(soil).ravel()
    k.drive_all(east, north, np.cos(turn), np.sin(turn), rows, np.ascontiguousarray(table), out)
    columns = {name: out[:, i].reshape(p.shape) for i, name in enumerate(_COLUMNS)}
    code = np.where(np.isnan(out[:, 8]), 0, out[:, 8]).astype(np.uint8).reshape(p.shape)
    return DriveCost(**columns, code=code)


_COLUMNS = ("pitch", "roll", "slip", "side_slip", "speed", "power", "energy", "time")


def cheapest(table: F64) -> tuple[float, float]:
    """Least energy [J] and time [s] for a metre of map, over all slopes and soils of a table.

    No way can cost less than this times its straight line: what A* needs of a lower bound. Taken
    from 4001 slopes of up to 45 degrees straight up and down, less one part in a thousand.
    """
    rise = np.linspace(-1.0, 1.0, 4001)
    costs = [drive_cost(rise, 0.0, 0.0, table, soil) for soil in range(len(table))]
    energy = min(float(cost.energy.min()) for cost in costs)
    return 0.999 * energy, 0.999 * min(float(cost.time.min()) for cost in costs)


def _soil(named: str | Soil) -> Soil:
    return named if isinstance(named, Soil) else read_soil(named)


def _parts(rover: Rover) -> tuple[Mobility, Chassis]:
    if rover.mobility is None or rover.chassis is None:
        raise SettingError(
            f"rover {rover.name} says nothing of its mass and motors, so slip and energy are not "
            "known; give its file a section mobility, and wheels"
        )
    return rover.mobility, rover.chassis


def _row(rover: Rover, mobility: Mobility, chassis: Chassis, soil: Soil, slip: str) -> F64:
    row = np.empty(k.COLUMNS)
    row[k.WEIGHT] = mobility.mass * mobility.gravity
    row[k.ROLLING], row[k.EFFICIENCY] = soil.rolling_resistance, mobility.efficiency
    row[k.IDLE], row[k.SPEED] = mobility.idle_power, rover.speed
    row[k.POWER] = mobility.drive_power or np.inf
    row[k.MOST_PITCH], row[k.MOST_ROLL] = np.tan(chassis.max_pitch), np.tan(chassis.max_roll)
    row[k.MOST_TILT], row[k.MOST_SLIP] = np.tan(chassis.max_tilt) ** 2, mobility.max_slip
    row[k.MEASURED_UP], row[k.MEASURED_DOWN] = np.tan((soil.measured_up, soil.measured_down))
    row[k.MEASURED_SIDE] = np.tan(soil.measured_side)
    curve = {"low": soil.slip_low, "expected": soil.slip, "high": soil.slip_high}[slip]
    angle = np.arctan(np.linspace(-1.0, 1.0, k.NODES))
    level = float(curve[0])
    # Downhill nothing was measured: wheels are taken to slip as on level ground.
    up = np.interp(angle, soil.slope, curve)
    row[k.FIRST : k.FIRST + k.NODES] = np.where(angle < 0.0, level, up)
    side = np.interp(np.abs(angle), soil.slope, soil.side_slip)
    row[k.FIRST + k.NODES :] = np.sign(angle) * side
    return row
